#include <emmy/base/exceptions.h>
#include <emmy/base/formula.h>
#include <emmy/base/text.h>
#include <emmy/effects/time_history.h>
#include <emmy/run/card_line.h>
#include <emmy/run/load_waves.h>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>

namespace emmy
{
  namespace
  {
    /** What goes one way, from one sample to another. */
    struct Stretch
    {
      std::size_t first, last;
    };

    /** The stretches of a history, without swings below a height. */
    std::vector<Stretch>
    stretches(const std::vector<double> &values, const double height)
    {
      std::vector<Stretch> result;
      std::size_t          turn = 0, low = 0, high = 0; // since the turn
      int                  way = 0;                     // +1: upwards
      for (std::size_t i = 1; i < values.size(); ++i)
        {
          if (values[i] > values[high])
            high = i;
          if (values[i] < values[low])
            low = i;
          const bool falls = way >= 0 && values[i] < values[high] - height;
          const bool rises = way <= 0 && values[i] > values[low] + height;
          if (!falls && !rises)
            continue;
          const std::size_t extreme = falls ? high : low;
          if (way != 0 || extreme != turn)
            result.push_back({turn, extreme});
          way  = falls ? -1 : 1;
          turn = extreme;
          low = high = i;
        }
      if (way != 0)
        result.push_back({turn, way > 0 ? high : low});
      return result;
    }

    /** The stretch without what is flat at its ends. */
    Stretch
    without_ends(const std::vector<double> &values, Stretch stretch)
    {
      const double v0 = values[stretch.first], v1 = values[stretch.last];
      const double flat = 1e-9 * std::abs(v1 - v0);
      while (stretch.first + 1 < stretch.last &&
             std::abs(values[stretch.first + 1] - v0) <= flat)
        ++stretch.first;
      while (stretch.last > stretch.first + 1 &&
             std::abs(values[stretch.last - 1] - v1) <= flat)
        --stretch.last;
      return stretch;
    }

    double
    steepest(const std::vector<double> &values, const Stretch &stretch)
    {
      double result = 0.;
      for (std::size_t i = stretch.first; i < stretch.last; ++i)
        result = std::max(result, std::abs(values[i + 1] - values[i]));
      return result;
    }

    /** Loads and motions that the scene names. */
    template <int dim>
    std::vector<TimeHistory>
    histories_of(const Scene<dim>           &scene,
                 const SceneParameters<dim> &parameters)
    {
      std::vector<TimeHistory> result;
      for (const std::string &name : parameters.effect_names.names)
        if (const auto *given = dynamic_cast<const GivenOverTime *>(
              parameters.effects.at(name).get()))
          for (TimeHistory &history : given->histories())
            result.push_back(std::move(history));
      const auto names = side_names(dim);
      for (unsigned int side = 0; side < 2 * dim; ++side)
        {
          const std::string &text = parameters.moving_walls.velocities[side];
          if (dealii::Utilities::trim(text).empty())
            continue;
          const unsigned int n_components =
            scene.boundary_conditions.fixed_components_of(side).count();
          const std::shared_ptr<dealii::FunctionParser<1>> formula =
            read_formulas<1>(text,
                             n_components,
                             parameters.moving_walls.path(),
                             "Velocity of " + names[side],
                             "Write formulas in t.",
                             "t");
          for (unsigned int c = 0; c < n_components; ++c)
            result.push_back(
              {"the velocity of " + names[side], [formula, c](const double t) {
                 return formula->value(dealii::Point<1>(t), c);
               }});
        }
      for (const HeldPart<dim> &part : scene.boundary_conditions.held_parts())
        for (unsigned int c = 0; c < dim; ++c)
          result.push_back(
            {"the velocity of " + part.name,
             [part, c](const double t) { return part.velocity_at(t)[c]; }});
      return result;
    }

    /** Three digits. */
    std::string
    rough(const double number)
    {
      std::ostringstream out;
      out << std::setprecision(3) << number;
      return out.str();
    }

    struct SlowestWave
    {
      std::string words; ///< whose it is
      double      speed; ///< m/s
    };

    template <int dim>
    SlowestWave
    slowest_wave(const Scene<dim> &scene)
    {
      SlowestWave result{"", std::numeric_limits<double>::infinity()};
      for (unsigned int b = 0; b < scene.bodies.size(); ++b)
        {
          const Material<dim> &material = *scene.material_of_body[b];
          const double         shear    = material.shear_wave_modulus();
          const double         speed =
            std::sqrt((shear > 0. ? shear : material.p_wave_modulus()) /
                      scene.bodies[b].density);
          if (speed < result.speed)
            result = {(shear > 0. ? "S-waves of body " : "P-waves of body ") +
                        scene.bodies[b].name,
                      speed};
        }
      return result;
    }
  } // namespace

  template <int dim>
  std::vector<unsigned int>
  bodies_without_waves(const Scene<dim> &scene, const double time_step)
  {
    const auto size = scene.grid.upper_corner() - scene.grid.lower_corner();
    std::vector<unsigned int> bodies;
    for (unsigned int b = 0; b < scene.bodies.size(); ++b)
      {
        const auto box    = scene.bodies[b].shape->bounding_box();
        double     length = 0.;
        for (unsigned int d = 0; d < dim; ++d)
          length = std::max(length, std::min(box.side_length(d), size[d]));
        const double speed =
          std::sqrt(scene.material_of_body[b]->p_wave_modulus() /
                    scene.bodies[b].density);
        if (steps_per_period * speed * time_step > 4. * length)
          bodies.push_back(b);
      }
    return bodies;
  }

  FastestChange
  fastest_change(const std::function<double(double)> &history,
                 const double                         end_time,
                 const unsigned int                   n_samples)
  {
    const double        interval = end_time / n_samples;
    std::vector<double> values(n_samples);
    for (unsigned int i = 0; i < n_samples; ++i) // a formula may have no value
      values[i] = history((i + 0.5) * interval); // at 0 itself
    FastestChange result{std::numeric_limits<double>::infinity(), 0., false};
    const auto [lowest, highest] =
      std::minmax_element(values.begin(), values.end());
    const double range = *highest - *lowest;
    if (!(range > 1e-9 * std::max(std::abs(*lowest), std::abs(*highest))))
      return result;
    const auto all    = stretches(values, 0.05 * range);
    double     inside = 0.; // the steepest of whole swings
    for (std::size_t i = 1; i + 1 < all.size(); ++i)
      inside = std::max(inside, steepest(values, all[i]));
    for (std::size_t i = 0; i < all.size(); ++i)
      {
        const bool is_whole = i > 0 && i + 1 < all.size();
        if (!is_whole && steepest(values, all[i]) <= 1.05 * inside)
          continue;
        const Stretch stretch = without_ends(values, all[i]);
        const double  time    = (stretch.last - stretch.first) * interval;
        if (time < result.half_period)
          result = {time,
                    0.5 * (stretch.first + stretch.last + 1) * interval,
                    stretch.last - stretch.first <= 3};
      }
    return result;
  }

  template <int dim>
  void
  tell_load_waves(const Scene<dim>           &scene,
                  const SceneParameters<dim> &parameters,
                  const StepReport           &initial,
                  std::ostream               &out)
  {
    double end_time = parameters.time.end_time;
    if (parameters.time.maximum_steps > 0)
      end_time =
        std::min(end_time, parameters.time.maximum_steps * initial.time_step);
    const auto   wave = slowest_wave(scene);
    const auto   size = scene.grid.size_at(scene.grid.lower_corner());
    const double h    = *std::max_element(size.begin_raw(), size.end_raw());
    // not a multiple of the steps, so as not to meet each period at one place
    const unsigned int n_samples =
      std::clamp(20. * end_time / initial.time_step, 20011., 200003.);
    std::vector<std::string> told;
    const auto               tell = [&](const std::string &words) {
      if (std::count(told.begin(), told.end(), words) > 0)
        return; // components of one thing
      card_line(out, told.empty() ? "waves of loads" : "") << words << '\n';
      told.push_back(words);
    };
    for (const TimeHistory &history : histories_of(scene, parameters))
      {
        FastestChange change;
        try
          {
            change = fastest_change(history.at, end_time, n_samples);
          }
        catch (const ExcRun &problem)
          {
            tell(history.name + ": " + message_of(problem));
            continue;
          }
        if (!std::isfinite(change.half_period))
          continue;
        if (change.is_jump)
          {
            tell(history.name + " jumps at " + rough(change.time) +
                 " s, and sends waves as short as the grid has them");
            continue;
          }
        const double period = 2. * change.half_period;
        const double length = wave.speed * period;
        tell(history.name + " changes within " + rough(change.half_period) +
             " s: " + wave.words + " are " + rough(length) + " m long, " +
             rough(length / h) + " cells; " +
             rough(period / initial.time_step) + " steps a period");
        if (length < cells_per_wave * h)
          out << "  note: " << cells_per_wave
              << " cells show a wave. Take cells of "
              << rough(length / cells_per_wave)
              << " m, or let the load change slower\n";
        if (period < steps_per_period * initial.time_step)
          out << "  note: " << steps_per_period
              << " steps show a period. Take steps of "
              << rough(period / steps_per_period) << " s\n";
      }
  }

  template std::vector<unsigned int>
  bodies_without_waves<2>(const Scene<2> &, const double);
  template std::vector<unsigned int>
  bodies_without_waves<3>(const Scene<3> &, const double);
  template void
  tell_load_waves<2>(const Scene<2> &,
                     const SceneParameters<2> &,
                     const StepReport &,
                     std::ostream &);
  template void
  tell_load_waves<3>(const Scene<3> &,
                     const SceneParameters<3> &,
                     const StepReport &,
                     std::ostream &);
} // namespace emmy
