#include <emmy/base/dealii_version.h>
#include <emmy/base/exceptions.h>
#include <emmy/base/formula.h>
#include <emmy/grid/boundary_conditions.h>
#include <emmy/particles/basic_shapes.h>
#include <emmy/particles/body.h>
#include <emmy/particles/particle_layout.h>
#include <emmy/particles/particle_table.h>
#include <emmy/particles/shape_formula.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace emmy
{
  using dealii::Point;

  namespace
  {
    /**
     * First and last cell of the grid that a shape may reach: with a cell to
     * spare, as the places of its box's corners are rounded.
     */
    template <int dim>
    std::array<CellKey<dim>, 2>
    reached_cells(const Shape<dim> &shape, const BackgroundGrid<dim> &grid)
    {
      const auto box = shape.bounding_box();
      Point<dim> low, high;
      for (unsigned int d = 0; d < dim; ++d)
        {
          low[d]  = box.lower_bound(d);
          high[d] = box.upper_bound(d);
        }
      low -= grid.size_at(low);
      high += grid.size_at(high);
      return {{grid.key_of(low), grid.key_of(high)}};
    }

    /** Call function(place) for all cells from the first to the last. */
    template <int dim, class Function>
    void
    for_each_cell(const std::array<CellKey<dim>, 2> &reached,
                  const Function                    &function)
    {
      auto cell = reached[0];
      for (unsigned int d = 0; d < dim;)
        {
          function(cell);
          for (d = 0; d < dim && ++cell[d] > reached[1][d]; ++d)
            cell[d] = reached[0][d];
        }
    }
  } // namespace

  template <int dim>
  std::vector<typename BackgroundGrid<dim>::Occupied>
  occupied_cells(const std::vector<Body<dim>> &bodies,
                 const BackgroundGrid<dim>    &grid)
  {
    using namespace dealii::Utilities::MPI;
    const unsigned int n_ranks = n_mpi_processes(grid.communicator()),
                       rank    = this_mpi_process(grid.communicator());
    std::vector<typename BackgroundGrid<dim>::Occupied> result;
    for (const Body<dim> &body : bodies)
      {
        const ParticleLayout<dim> lattice(body, grid);
        const auto                reached = reached_cells(*body.shape, grid);
        // ranks take the layers in turn
        for (unsigned int layer = reached[0].back(); layer <= reached[1].back();
             ++layer)
          if (layer % n_ranks == rank)
            {
              auto within      = reached;
              within[0].back() = layer;
              within[1].back() = layer;
              for_each_cell<dim>(within, [&](const auto &cell) {
                if (const auto points = lattice.points_in(cell);
                    !points.empty())
                  result.emplace_back(cell, points.size());
              });
            }
      }
    return result;
  }

  template <int dim>
  dealii::Tensor<1, dim>
  initial_half_length(const Body<dim> &body, const BackgroundGrid<dim> &grid)
  {
    return ParticleLayout<dim>(body, grid).half_length();
  }

  namespace
  {
    /** Of a body that is far from the size of the grid: a unit, perhaps. */
    template <int dim>
    std::string
    size_hint(const Body<dim> &body, const BackgroundGrid<dim> &grid)
    {
      const auto box = body.shape->bounding_box();
      if (!is_bounded(box))
        return "";
      double cells = 0., grids = 0.;
      for (unsigned int d = 0; d < dim; ++d)
        {
          const double whole = grid.upper_corner()[d] - grid.lower_corner()[d];
          grids              = std::max(grids, box.side_length(d) / whole);
          cells =
            std::max(cells,
                     box.side_length(d) / grid.size_at(grid.lower_corner())[d]);
        }
      if (grids > 10.)
        return "; it is " + brief(grids) +
               " times as long as the grid: is it in millimetres?";
      return cells < 0.1 ? "; it is " + brief(cells) +
                             " of a cell long: is its scale right?"
                         : "";
    }

    /** What is wrong with the extent of a body, if anything. */
    template <int dim>
    std::string
    extent_problem(const Body<dim> &body, const BackgroundGrid<dim> &grid)
    {
      const auto box = body.shape->bounding_box();
      // a shape that does not know its extent is checked by points
      if (!is_bounded(box) || !body.shape->has_tight_box())
        return "";
      for (unsigned int d = 0; d < dim; ++d)
        {
          const double tolerance = 1e-9 * grid.size_at(grid.lower_corner())[d];
          const bool   is_below =
            !body.cut_by[2 * d] &&
            box.lower_bound(d) < grid.lower_corner()[d] - tolerance;
          const bool is_above =
            !body.cut_by[2 * d + 1] &&
            box.upper_bound(d) > grid.upper_corner()[d] + tolerance;
          if (is_below || is_above)
            return "body <" + body.name + "> spans " + "xyz"[d] + " = " +
                   shortest(box.lower_bound(d)) + " ... " +
                   shortest(box.upper_bound(d)) +
                   " m, which is not inside the grid, " +
                   shortest(grid.lower_corner()[d]) + " ... " +
                   shortest(grid.upper_corner()[d]) + " m" +
                   size_hint(body, grid);
        }
      return "";
    }

    /**
     * Whether a shape goes on beyond the grid next to one of its points: for
     * shapes that do not know their extent.
     */
    template <int dim>
    std::string
    cut_problem(const Body<dim>           &body,
                const BackgroundGrid<dim> &grid,
                const Point<dim>          &point)
    {
      for (unsigned int d = 0; d < dim; ++d)
        for (const unsigned int end : {0, 1})
          {
            Point<dim> next = point;
            next[d] += (end == 0 ? -1. : 1.) * grid.size_at(point)[d] /
                       body.points_per_direction;
            if (!body.cut_by[2 * d + end] && !grid.contains(next) &&
                body.shape->contains(next))
              return "body <" + body.name +
                     "> reaches outside the grid, e.g. at (" +
                     dealii::Patterns::Tools::to_string(next) + ") m";
          }
      return "";
    }

    /**
     * The cells that this rank owns and the bodies whose boxes may meet them,
     * as indices, cell by cell. Cost: that of the cells in the boxes.
     */
    template <int dim>
    std::vector<std::pair<unsigned int, unsigned int>>
    bodies_at_cells(
      const std::vector<typename BackgroundGrid<dim>::Cell> &cells,
      const std::vector<Body<dim>>                          &bodies,
      const BackgroundGrid<dim>                             &grid)
    {
      std::vector<CellKey<dim>> places; // sorted
      for (const auto &cell : cells)
        places.push_back(grid.key_of(cell));
      std::vector<std::pair<unsigned int, unsigned int>> result;
      for (unsigned int b = 0; b < bodies.size(); ++b)
        {
          const auto reached = reached_cells(*bodies[b].shape, grid);
          double     size    = 1.;
          for (unsigned int d = 0; d < dim; ++d)
            size *= reached[1][d] - reached[0][d] + 1.;
          if (size > cells.size()) // e.g. all of a large grid
            for (unsigned int c = 0; c < cells.size(); ++c)
              result.emplace_back(c, b);
          else
            for_each_cell<dim>(reached, [&](const auto &place) {
              const auto found =
                std::lower_bound(places.begin(), places.end(), place);
              if (found != places.end() && *found == place)
                result.emplace_back(found - places.begin(), b);
            });
        }
      std::sort(result.begin(), result.end());
      return result;
    }

    /** The points of a body in a cell. */
    template <int dim>
    struct Filling
    {
      typename BackgroundGrid<dim>::Cell cell;
      unsigned int                       body;
      std::vector<Point<dim>>            points;
    };

    /**
     * Who is where, cell by cell. Collective; throws ExcRun for bodies that
     * are cut by the grid, overlap or are empty.
     */
    template <int dim>
    std::vector<Filling<dim>>
    find_points(const std::vector<Body<dim>> &bodies,
                const BackgroundGrid<dim>    &grid)
    {
      const MPI_Comm             communicator = grid.communicator();
      const auto                 cells        = grid.owned_cells();
      const auto                 pairs = bodies_at_cells(cells, bodies, grid);
      std::vector<Filling<dim>>  result;
      std::vector<unsigned long> n_points(bodies.size(), 0);
      std::vector<ParticleLayout<dim>> lattices;
      for (const Body<dim> &body : bodies)
        lattices.emplace_back(body, grid);
      std::string cut, overlap;
      for (auto first = pairs.begin(); first != pairs.end();)
        {
          auto last = first;
          while (last != pairs.end() && last->first == first->first)
            ++last;
          for (auto here = first; here != last; ++here)
            {
              const auto &[c, b] = *here;
              Filling<dim> filling{
                cells[c], b, lattices[b].points_in(grid.key_of(cells[c]))};
              n_points[b] += filling.points.size();
              for (const Point<dim> &point : filling.points)
                {
                  if (cut.empty())
                    cut = cut_problem(bodies[b], grid, point);
                  for (auto other = first; other != last; ++other)
                    if (other != here && overlap.empty() &&
                        bodies[other->second].shape->contains(point))
                      overlap =
                        "bodies <" + bodies[b].name + "> and <" +
                        bodies[other->second].name + "> overlap, e.g. at (" +
                        dealii::Patterns::Tools::to_string(point) + ") m";
                }
              if (!filling.points.empty())
                result.push_back(std::move(filling));
            }
          first = last;
        }
      throw_together(communicator,
                     "Bodies",
                     cut,
                     "enlarge the grid (Grid/Lower corner, Upper corner), or "
                     "name that side in the body's <Cut by>.");
      throw_together(communicator,
                     "Bodies",
                     overlap,
                     "move or shrink one of them; bodies may touch.");
      dealii::Utilities::MPI::sum(n_points, communicator, n_points);
      const auto empty = std::find(n_points.begin(), n_points.end(), 0);
      throw_together(
        communicator,
        "Bodies",
        empty == n_points.end()
          ? ""
          : "body <" + bodies[empty - n_points.begin()].name +
              "> holds no particle: no box centre of the cells' subdivision lies "
              "in its shape" +
              size_hint(bodies[empty - n_points.begin()], grid),
        "raise its Points per direction, refine the grid, or check its shape.");
      return result;
    }

    /** Volume, mass and velocity of a row of a table, as far as it has them. */
    template <int dim>
    void
    take_row(const ParticleTable<dim> &table,
             const std::size_t         row,
             const double              density,
             double                   &volume,
             double                   &mass,
             dealii::Tensor<1, dim>   &velocity)
    {
      volume = table.volumes[row];
      mass   = table.masses.empty() ? density * volume : table.masses[row];
      if (!table.velocities.empty())
        velocity += table.velocities[row];
    }

    /** What is wrong with the velocity of a body at a point, or empty. */
    template <int dim>
    std::string
    velocity_problem(const Body<dim>              &body,
                     const Point<dim>             &point,
                     const dealii::Tensor<1, dim> &velocity)
    {
      for (unsigned int d = 0; d < dim; ++d)
        if (!std::isfinite(velocity[d]))
          return "the initial velocity of body <" + body.name + "> is " +
                 shortest(velocity[d]) + " m/s at (" +
                 dealii::Patterns::Tools::to_string(point) + ") m";
      return {};
    }
  } // namespace

  template <int dim>
  FilledRows
  fill(const std::vector<Body<dim>>            &bodies,
       const BackgroundGrid<dim>               &grid,
       const FieldLayout                       &layout,
       dealii::Particles::ParticleHandler<dim> &particles)
  {
    const MPI_Comm communicator = grid.communicator();
    std::string    outside;
    for (const Body<dim> &body : bodies)
      if (outside.empty())
        outside = extent_problem(body, grid);
    throw_together(communicator,
                   "Bodies",
                   outside,
                   "enlarge the grid (Grid/Lower corner, Upper corner), "
                   "move the body, or name that side in its <Cut by>.");
    const auto fillings = find_points(bodies, grid);

    // ids that are unique over the ranks
    unsigned long n_local = 0;
    for (const Filling<dim> &filling : fillings)
      n_local += filling.points.size();
    dealii::types::particle_index id =
      sum_below_and_total(n_local, communicator).first;
    FilledRows filled;
    filled.first_id = id;

    const unsigned int velocity = layout["velocity"], mass = layout["mass"],
                       volume               = layout["reference_volume"],
                       body                 = layout["body"];
    std::vector<double>              values = layout.initial_values();
    std::string                      wrong_velocity;
    std::vector<ParticleLayout<dim>> lattices;
    for (const Body<dim> &from : bodies)
      lattices.emplace_back(from, grid);
    particles.reserve(n_local);
    for (const Filling<dim> &filling : fillings)
      {
        const Body<dim> &from = bodies[filling.body];
        values[body]          = filling.body;
        values[volume]        = 1.;
        for (unsigned int d = 0; d < dim; ++d)
          values[volume] *= lattices[filling.body].spacing()[d];
        values[mass] = from.density * values[volume];
        if (layout.has("half_length"))
          for (unsigned int d = 0; d < dim; ++d)
            values[layout["half_length"] + d] =
              lattices[filling.body].half_length()[d];
        const auto        key   = grid.key_of(filling.cell);
        const auto *const table = from.shape->table();
        for (unsigned int i = 0; i < filling.points.size(); ++i)
          {
            const Point<dim> &point = filling.points[i];
            auto              start = from.velocity_at(point);
            filled.rows.push_back(0);
            if (table)
              {
                filled.rows.back() = lattices[filling.body].rows_in(key)[i];
                take_row(*table,
                         filled.rows.back(),
                         from.density,
                         values[volume],
                         values[mass],
                         start);
              }
            for (unsigned int d = 0; d < dim; ++d)
              values[velocity + d] = start[d];
            if (wrong_velocity.empty())
              wrong_velocity = velocity_problem(from, point, start);
            Point<dim> reference = grid.reference_position(key, point);
            for (unsigned int d = 0; d < dim; ++d)
              reference[d] = std::min(1., std::max(0., reference[d]));
            particles.insert_particle(
              point,
              reference,
              id++,
              filling.cell,
              dealii::ArrayView<const double>(values.data(), values.size()));
          }
      }
    throw_together(communicator,
                   "Bodies",
                   wrong_velocity,
                   "correct its Initial velocity, which must be finite at "
                   "every particle.");
    particles.update_cached_numbers();
    return filled;
  }

#define INSTANTIATE(dim)                                        \
  template std::vector<typename BackgroundGrid<dim>::Occupied>  \
  occupied_cells<dim>(const std::vector<Body<dim>> &,           \
                      const BackgroundGrid<dim> &);             \
  template dealii::Tensor<1, dim> initial_half_length<dim>(     \
    const Body<dim> &, const BackgroundGrid<dim> &);            \
  template FilledRows fill<dim>(const std::vector<Body<dim>> &, \
                                const BackgroundGrid<dim> &,    \
                                const FieldLayout &,            \
                                dealii::Particles::ParticleHandler<dim> &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
