#include <emmy/base/text.h>
#include <emmy/particles/basic_shapes.h>
#include <emmy/particles/body_measures.h>
#include <emmy/particles/body_pieces.h>
#include <emmy/particles/particle_layout.h>

#include <boost/random/sobol.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace emmy
{
  using dealii::Point;

  namespace
  {
    /** What is told: beyond this part of the value or of a cell. */
    constexpr double worth_a_note = 0.01;

    /** What a shape knows of itself, inside the grid. */
    template <int dim>
    struct Exact
    {
      double     volume     = 0.; ///< 0: unknown
      bool       has_extent = false, has_center = false;
      Point<dim> lower, upper, center;

      Exact(const Body<dim> &body, const BackgroundGrid<dim> &grid)
      {
        const bool is_whole = body.cut_by.none();
        if (!is_whole && !body.shape->is_box())
          return;
        const auto box = uncut_box(body, grid);
        has_extent     = is_bounded(box);
        if (!has_extent)
          return;
        for (unsigned int d = 0; d < dim; ++d)
          {
            lower[d] = box.lower_bound(d);
            upper[d] = box.upper_bound(d);
          }
        volume     = is_whole ? body.shape->volume() : box.volume();
        has_center = is_whole ? body.shape->center(center) : true;
        if (!is_whole)
          center = box.center();
        // a box around a formula is not its extent
        has_extent = has_center && body.shape->has_tight_box();
      }
    };

    template <int dim>
    std::string
    span(const Point<dim> &lower, const Point<dim> &upper, const unsigned int d)
    {
      return std::string(1, "xyz"[d]) + " = " + brief(lower[d]) + " ... " +
             brief(upper[d]);
    }

    /** What is off by more than a hundredth of a cell; empty: nothing. */
    template <int dim>
    std::string
    misplaced(const BodyMeasures<dim>   &found,
              const Exact<dim>          &exact,
              const BackgroundGrid<dim> &grid)
    {
      std::string result;
      double      largest = 0.;
      const auto  note =
        [&](const unsigned int d, const double off, const std::string &what) {
          const double cells = std::abs(off) / grid.size_at(found.lower)[d];
          if (!(cells > worth_a_note))
            return;
          largest = std::max(largest, cells);
          result += (result.empty() ? "" : "; ") + what;
        };
      if (exact.has_extent)
        for (unsigned int d = 0; d < dim; ++d)
          note(d,
               std::max(std::abs(found.lower[d] - exact.lower[d]),
                        std::abs(found.upper[d] - exact.upper[d])),
               span(found.lower, found.upper, d) + " m instead of " +
                 span(exact.lower, exact.upper, d).substr(4));
      if (exact.has_center)
        for (unsigned int d = 0; d < dim; ++d)
          note(d,
               found.center[d] - exact.center[d],
               std::string("centre ") + "xyz"[d] + " = " +
                 brief(found.center[d]) + " m instead of " +
                 brief(exact.center[d]));
      return result.empty() ? result
                            : result + ": up to " + brief(100. * largest) +
                                " % of a cell off";
    }
  } // namespace

  template <int dim>
  double
  sampled_volume(const Shape<dim> &shape, const MPI_Comm communicator)
  {
    using namespace dealii::Utilities::MPI;
    constexpr unsigned int n   = 1 << 18;
    const auto             box = shape.bounding_box();
    if (!is_bounded(box))
      return 0.;
    const unsigned int n_ranks = n_mpi_processes(communicator),
                       share   = (n + n_ranks - 1) / n_ranks,
                       first   = share * this_mpi_process(communicator),
                       last    = std::min(n, first + share);
    boost::random::sobol sequence(dim);
    if (first < last)
      sequence.discard(static_cast<std::uintmax_t>(first) * dim);
    unsigned int n_inside = 0;
    for (unsigned int i = first; i < last; ++i)
      {
        Point<dim> point;
        for (unsigned int d = 0; d < dim; ++d)
          point[d] =
            box.lower_bound(d) + box.side_length(d) * (sequence() / 0x1p64);
        n_inside += shape.contains(point);
      }
    return box.volume() * (double(sum(n_inside, communicator)) / n);
  }

  template <int dim>
  std::vector<BodyMeasures<dim>>
  measure_bodies(const std::vector<Body<dim>>                  &bodies,
                 const BackgroundGrid<dim>                     &grid,
                 const FieldLayout                             &layout,
                 const dealii::Particles::ParticleHandler<dim> &particles)
  {
    const unsigned int n = bodies.size();
    // volume, mass and its moments; then -lower and upper
    const unsigned int  n_sums = 2 + dim;
    std::vector<double> sums(n * n_sums),
      reach(n * 2 * dim, std::numeric_limits<double>::lowest());
    std::vector<dealii::Tensor<1, dim>> half;
    for (const Body<dim> &body : bodies)
      half.push_back(initial_half_length(body, grid));
    for (const auto &particle : particles)
      {
        const auto         properties = particle.get_properties();
        const unsigned int b          = properties[layout["body"]];
        const double       mass       = properties[layout["mass"]];
        sums[n_sums * b] += properties[layout["reference_volume"]];
        sums[n_sums * b + 1] += mass;
        for (unsigned int d = 0; d < dim; ++d)
          {
            const double x = particle.get_location()[d];
            sums[n_sums * b + 2 + d] += mass * x;
            double *const ends = &reach[2 * (dim * b + d)];
            ends[0]            = std::max(ends[0], half[b][d] - x);
            ends[1]            = std::max(ends[1], x + half[b][d]);
          }
      }
    dealii::Utilities::MPI::sum(sums, grid.communicator(), sums);
    dealii::Utilities::MPI::max(reach, grid.communicator(), reach);
    std::vector<BodyMeasures<dim>> result(n);
    const auto pieces = count_pieces(n, grid, layout, particles);
    for (unsigned int b = 0; b < n; ++b)
      {
        result[b].pieces = pieces[b];
        if (bodies[b].shape->volume() == 0. && bodies[b].cut_by.none())
          result[b].shape_volume =
            sampled_volume(*bodies[b].shape, grid.communicator());
        result[b].mass = sums[n_sums * b + 1];
        // undeformed volumes of ground with stress are not those of its boxes
        result[b].volume = bodies[b].initial_stress
                             ? result[b].mass / bodies[b].density
                             : sums[n_sums * b];
        for (unsigned int d = 0; d < dim; ++d)
          {
            result[b].center[d] = sums[n_sums * b + 2 + d] / result[b].mass;
            result[b].lower[d]  = 0. - reach[2 * (dim * b + d)]; // never -0
            result[b].upper[d]  = reach[2 * (dim * b + d) + 1];
          }
      }
    return result;
  }

  template <int dim>
  std::vector<std::string>
  describe_measures(const Body<dim>           &body,
                    const BodyMeasures<dim>   &measures,
                    const BackgroundGrid<dim> &grid)
  {
    Exact<dim>               exact(body, grid);
    const bool               is_sampled = exact.volume == 0.;
    std::vector<std::string> lines;
    if (is_sampled)
      exact.volume = measures.shape_volume;
    std::string line = "volume of its particles " + brief(measures.volume) +
                       " m^3, mass " + brief(measures.mass) + " kg";
    if (exact.volume > 0.)
      line += "; of its shape " + std::string(is_sampled ? "about " : "") +
              brief(exact.volume) + " m^3, " +
              brief(body.density * exact.volume) + " kg";
    lines.push_back(line);
    line = "they span ";
    for (unsigned int d = 0; d < dim; ++d)
      line += (d > 0 ? ", " : "") + span(measures.lower, measures.upper, d);
    line += " m, centre (";
    for (unsigned int d = 0; d < dim; ++d)
      line += (d > 0 ? ", " : "") + brief(measures.center[d]);
    lines.push_back(line + ") m, in " +
                    (measures.pieces == 1
                       ? "one piece"
                       : std::to_string(measures.pieces) + " pieces"));

    const bool        is_box = body.shape->is_box();
    const std::string remedy =
      is_box && !body.divides_box
        ? "Set its Particle layout = body"
        : std::string("Take more Points per direction") +
            (is_box ? ", or faces on multiples of h/points" : "");
    if (exact.volume > 0.)
      {
        const double error = measures.volume / exact.volume - 1.;
        if (std::abs(error) > worth_a_note)
          lines.push_back("note: that is " + brief(100. * error) +
                          " % off, and so is the mass. " + remedy);
      }
    const std::string place = misplaced(measures, exact, grid);
    if (!place.empty())
      lines.push_back("note: " + place + ". " + remedy);
    return lines;
  }

#define INSTANTIATE(dim)                                                   \
  template double sampled_volume<dim>(const Shape<dim> &, const MPI_Comm); \
  template std::vector<BodyMeasures<dim>> measure_bodies<dim>(             \
    const std::vector<Body<dim>> &,                                        \
    const BackgroundGrid<dim> &,                                           \
    const FieldLayout &,                                                   \
    const dealii::Particles::ParticleHandler<dim> &);                      \
  template std::vector<std::string> describe_measures<dim>(                \
    const Body<dim> &,                                                     \
    const BodyMeasures<dim> &,                                             \
    const BackgroundGrid<dim> &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
