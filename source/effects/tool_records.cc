#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/effects/tool_surface.h>
#include <emmy/effects/tools.h>

#include <algorithm>

// What tools tell and remember: at the start, in the ledger, in the log, in
// pictures, in checkpoints.
namespace emmy
{
  using dealii::Tensor;

  namespace
  {
    /** Deeper than this share of the spacing is worth a line. */
    constexpr double deep = 0.05;
    /** Nearer than this share of the spacing touches at the start. */
    constexpr double touching = 1e-6;
  } // namespace

  template <int dim>
  std::string
  Tools<dim>::mark(const BackgroundGrid<dim>               &grid,
                   dealii::Particles::ParticleHandler<dim> &particles) const
  {
    found.communicator = grid.communicator();
    std::string text;
    for (const Tool<dim> &tool : tools)
      text += (text.empty() ? "" : "\n" + std::string(24, ' ')) +
              mark(tool, grid, particles);
    return text;
  }

  template <int dim>
  std::string
  Tools<dim>::mark(const Tool<dim>                         &tool,
                   const BackgroundGrid<dim>               &grid,
                   dealii::Particles::ParticleHandler<dim> &particles) const
  {
    using namespace dealii::Utilities::MPI;
    const bool    holds    = tool.held != Tool<dim>::none;
    const auto    place    = tool.motion.place(0.);
    const auto    to_frame = transpose(tool.motion.directions(0.));
    std::uint64_t n_near   = 0;
    double        stored = 0., deepest = 0.;
    for (auto &particle : particles)
      {
        const auto                  properties = particle.get_properties();
        const ParticleCorners<dim> &corners =
          corners_of_body[properties[fields.body]];
        unsigned int held = 0;
        for (unsigned int i = 0; i < corners.n; ++i)
          {
            const Tensor<1, dim> from =
              particle.get_location() + corners[i] - place;
            const double gap = tool.shape->distance(to_frame * from).value;
            if (gap <= touching * corners.spacing)
              {
                ++n_near;
                held |= 1u << i;
              }
            deepest = std::max(deepest, -gap / corners.spacing);
            stored += contact_energy(law(tool, corners).stiffness,
                                     gap,
                                     holds && (held >> i & 1));
          }
        if (holds)
          properties[tool.held] = held;
      }
    n_near  = sum(n_near, grid.communicator());
    stored  = sum(stored, grid.communicator());
    deepest = max(deepest, grid.communicator());
    AssertThrow(!holds || n_near > 0,
                ExcRun("Effects/Tools/" + tool.name,
                       "nothing touches the tool at the start, so it can "
                       "hold nothing",
                       "put its <Reference point> on the surface of the "
                       "body, or set Holds = false."));
    return "tool <" + tool.name + ">: " +
           (holds ? "holds " + std::to_string(n_near) + " corners, " : "") +
           (deepest > touching
              ? "overlaps bodies by up to " + brief(deepest) +
                  " of their spacing, which stores " + brief(stored) + " J" +
                  (deepest > 0.5 && !holds
                     ? " and throws them off: put its Reference point where it "
                       "just touches; a normal leads out of the tool, an axis "
                       "into it; "
                     : ", ")
              : "") +
           "stiffness " + brief(tool.stiffness) +
           " M/s: a pressure of 1 % of the P-wave modulus M sinks in by " +
           brief(0.01 / tool.stiffness) + " of the spacing s";
  }

  template <int dim>
  std::vector<EnergyEntry>
  Tools<dim>::energy_entries() const
  {
    using Kind = EnergyEntry::Kind;
    std::vector<EnergyEntry> entries{{"contact_energy", Kind::stored, 0.}};
    if (has_friction)
      {
        entries.push_back({"friction_energy", Kind::stored, 0.});
        entries.push_back({"friction_dissipation", Kind::dissipated, 0.});
      }
    for (const Tool<dim> &tool : tools)
      {
        const std::string name = "tool_" + tool.name;
        entries.push_back({name + "_work", Kind::work, 0.});
        if (tool.push)
          entries.push_back({name + "_kinetic_energy", Kind::stored, 0.});
      }
    return entries;
  }

  template <int dim>
  unsigned int
  Tools<dim>::work_of(const unsigned int tool) const
  {
    unsigned int result = has_friction ? 3 : 1;
    for (unsigned int t = 0; t < tool; ++t)
      result += tools[t].push ? 2 : 1;
    return result;
  }

  template <int dim>
  std::vector<EnergyEntry>
  Tools<dim>::energies_at_start(const PointArrays<dim> &points,
                                const double            time) const
  {
    std::vector<EnergyEntry> entries = energy_entries();
    const unsigned int       this_rank =
      dealii::Utilities::MPI::this_mpi_process(*found.communicator);
    for (unsigned int t = 0; t < tools.size(); ++t)
      {
        const Tool<dim> &tool     = tools[t];
        const auto       place    = place_of(t, time);
        const auto       to_frame = transpose(tool.motion.directions(time));
        double           stored   = 0.;
        for (std::size_t p = 0; p < points.n_points(); ++p)
          {
            const ParticleCorners<dim> &corners =
              corners_of_body[points.component(fields.body)[p]];
            const auto F = tensor_field(points, fields.deformation_gradient, p);
            for (unsigned int i = 0; i < corners.n; ++i)
              {
                const Tensor<1, dim> from =
                  points.point(p) + F * corners[i] - place;
                const bool held =
                  tool.held != Tool<dim>::none &&
                  is_held(tool, points.component(tool.held)[p], i);
                stored +=
                  contact_energy(law(tool, corners).stiffness,
                                 tool.shape->distance(to_frame * from).value,
                                 held);
              }
          }
        entries[0].change += stored;
        entries[work_of(t)].change = stored;
        if (!tool.push || this_rank != 0)
          continue;
        const double kinetic =
          0.5 * tool.push->mass * pushed[t].speed * pushed[t].speed;
        entries[work_of(t)].change += kinetic;
        entries[kinetic_energy_of(t)].change = kinetic;
      }
    return entries;
  }

  template <int dim>
  std::vector<std::string>
  Tools<dim>::columns_of(const std::string &name,
                         const bool         is_turning,
                         const bool         is_pushed)
  {
    const std::string        tool = "tool_" + name + "_";
    std::vector<std::string> columns;
    for (const char *what : {"", "force_"})
      for (unsigned int d = 0; d < dim; ++d)
        columns.push_back(tool + what + "xyz"[d]);
    for (unsigned int d = dim == 2 ? 2 : 0; d < 3; ++d)
      columns.push_back(tool + "moment_" + "xyz"[d]);
    columns.push_back(tool + "sinking");
    if (is_turning)
      columns.push_back(tool + "angle");
    if (is_pushed)
      columns.push_back(tool + "momentum");
    return columns;
  }

  template <int dim>
  std::vector<StepMeasure>
  Tools<dim>::measure(const PointArrays<dim> &,
                      const double               time,
                      const BackgroundGrid<dim> &grid)
  {
    std::vector<StepMeasure> result;
    for (unsigned int t = 0; t < tools.size(); ++t)
      {
        const auto    &motion = tools[t].motion;
        const MPI_Comm ranks  = grid.communicator();
        const auto    &push   = tools[t].push;
        auto           place  = place_of(t, time);
        if (push) // the step has not ended
          place += found.way[t] * push->direction;
        const auto force  = dealii::Utilities::MPI::sum(found.force[t], ranks);
        const auto moment = dealii::Utilities::MPI::sum(found.moment[t], ranks);
        std::vector<double> values;
        for (unsigned int d = 0; d < dim; ++d)
          values.push_back(place[d]);
        for (unsigned int d = 0; d < dim; ++d)
          values.push_back(force[d]);
        for (unsigned int d = dim == 2 ? 2 : 0; d < 3; ++d)
          values.push_back(moment[d]);
        values.push_back(dealii::Utilities::MPI::max(found.sunk_in[t], ranks));
        if (motion.is_turning())
          values.push_back(motion.angle(time));
        if (push)
          values.push_back(push->mass * found.speed[t]);
        const auto names =
          columns_of(tools[t].name, motion.is_turning(), push.has_value());
        for (unsigned int i = 0; i < values.size(); ++i)
          result.push_back({names[i], values[i]});
      }
    return result;
  }

  template <int dim>
  std::vector<Surface<dim>>
  Tools<dim>::surfaces(const double              time,
                       const dealii::Point<dim> &lower,
                       const dealii::Point<dim> &upper) const
  {
    std::vector<Surface<dim>> result;
    for (unsigned int t = 0; t < tools.size(); ++t)
      result.push_back(surface_of(*tools[t].shape,
                                  place_of(t, time),
                                  tools[t].motion.directions(time),
                                  lower,
                                  upper));
    return result;
  }

  template <int dim>
  std::vector<double>
  Tools<dim>::contents() const
  {
    std::vector<double> result{told_depth};
    for (unsigned int t = 0; t < tools.size(); ++t)
      if (tools[t].push)
        result.insert(result.end(), {pushed[t].travel, pushed[t].speed});
    return result;
  }

  template <int dim>
  void
  Tools<dim>::recall(const std::vector<std::vector<double>> &parts)
  {
    const double *entry = parts.front().data();
    told_depth          = *entry++;
    for (unsigned int t = 0; t < tools.size(); ++t)
      if (tools[t].push)
        {
          pushed[t].travel = *entry++;
          pushed[t].speed = found.speed[t] = *entry++;
        }
  }

  template <int dim>
  void
  Tools<dim>::end_step(const double, const double)
  {
    for (unsigned int t = 0; t < tools.size(); ++t)
      if (tools[t].push)
        {
          pushed[t].travel += found.way[t];
          pushed[t].speed = found.speed[t];
          found.way[t]    = 0.;
        }
  }

  template <int dim>
  std::string
  Tools<dim>::finding()
  {
    if (!found.communicator)
      return "";
    const double deepest =
      dealii::Utilities::MPI::max(found.deepest, *found.communicator);
    if (deepest <= std::max(deep, 2. * told_depth))
      return "";
    told_depth                   = deepest;
    std::vector<double> of_tools = found.sunk_in;
    dealii::Utilities::MPI::max(of_tools, *found.communicator, of_tools);
    const auto most = std::max_element(of_tools.begin(), of_tools.end());
    return "particles sink into the tool <" +
           tools[most - of_tools.begin()].name + "> by up to " +
           brief(deepest) +
           " of their spacing; a larger <Stiffness> of the tool, or smaller "
           "steps, let them sink in less";
  }

  template class Tools<2>;
  template class Tools<3>;
} // namespace emmy
