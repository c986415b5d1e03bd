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

  template <int dim>
  BodyParameters<dim>::BodyParameters(const std::string &section,
                                      const std::string &shape)
    : Section(section)
    , shape_name(shape)
  {
    this->add_parameter(
      "Shape",
      shape_name,
      "What the body looks like: " + join(shape_library<dim>().names()) +
        " (cylinder and mesh in 3D only; in plane strain a disc is a "
        "ball). Its measures stand in a subsection of that name. Or a "
        "formula, without a subsection: difference(box(0, 0; 4, 1), "
        "ball(2, 0.5; 0.2)). Functions are box, ball, half_space, "
        "expression, polygon (2D), cylinder, cone and mesh (3D); union, "
        "intersection, difference; shift, turn, scale. Required.");
    this->add_parameter("Material",
                        material,
                        "One of Materials/Names. Required.");
    this->add_parameter(
      "Points per direction",
      points_per_direction,
      "Each cell is divided into this number of boxes in "
      "each direction; a box whose centre is in the shape "
      "becomes a particle, with the mass of its box. A box that does not "
      "fit is divided itself, see <Particle layout>. Required.",
      this->prm,
      dealii::Patterns::Integer(0));
    this->add_parameter(
      "Particle layout",
      particle_layout,
      "What is divided into the boxes of particles. body: a box is divided "
      "itself, into boxes whose size is as near as it can be to that of the "
      "cells' boxes, so that it stands where it is written; for other shapes "
      "the cells. cells: always the cells, whose boxes can stick out of the "
      "body or leave it uncovered by half their size.",
      this->prm,
      dealii::Patterns::Selection("body|cells"));
    this->add_parameter(
      "Initial velocity",
      initial_velocity,
      "Components separated by , or ;, each a formula in x, y "
      "(and z). Unit: m/s. Empty: at rest.");
    this->add_parameter(
      "Angular velocity",
      angular_velocity,
      std::string("Adds a rotation to the initial velocity: ") +
        (dim == 2 ? "about z, turning x to y." : "a vector along the axis.") +
        " Unit: rad/s. Empty: none.",
      this->prm,
      dealii::Patterns::List(dealii::Patterns::Double(), 0, dim == 2 ? 1 : 3));
    this->add_parameter("Center of rotation",
                        center_of_rotation,
                        "A point of the axis of <Angular velocity>, which "
                        "requires it. Unit: m.",
                        this->prm,
                        dealii::Patterns::List(dealii::Patterns::Double(),
                                               0,
                                               dim));
    this->add_parameter(
      "Cut by",
      cut_by,
      "Sides of the grid beyond which the shape may reach; "
      "what lies outside is left out, as where a side is a "
      "plane of symmetry; that side should then be a <Roller>, or "
      "the cut is a free face. A list of x-min, x-max, y-min, "
      "y-max, z-min, z-max.",
      this->prm,
      dealii::Patterns::List(dealii::Patterns::Anything(), 0));
    if (!shape.empty() && !is_shape_formula(shape))
      shape_parameters = shape_library<dim>()
                           .find(shape, section, "Shape")
                           .make(section + "/" + shape);
  }

  template <int dim>
  std::unique_ptr<Shape<dim>>
  BodyParameters<dim>::make_shape() const
  {
    return is_shape_formula(shape_name)
             ? read_shape<dim>(shape_name, this->path())
             : shape_parameters->make();
  }

  template <int dim>
  void
  BodyParameters<dim>::validate() const
  {
    AssertThrow(shape_parameters != nullptr || is_shape_formula(shape_name),
                ExcParameter(this->path(),
                             "Shape",
                             "",
                             "it is required. Known shapes are: " +
                               join(shape_library<dim>().names()) + "."));
    const auto require_all = [this](const std::string         &name,
                                    const std::vector<double> &numbers,
                                    const unsigned int         n) {
      AssertThrow(angular_velocity.empty() ? numbers.empty()
                                           : numbers.size() == n,
                  ExcParameter(this->path(),
                               name,
                               dealii::Patterns::Tools::to_string(numbers),
                               "a rotation needs <Angular velocity>, " +
                                 std::to_string(dim == 2 ? 1 : 3) +
                                 " numbers in rad/s, and <Center of "
                                 "rotation>, " +
                                 std::to_string(dim) + " in m."));
    };
    require_all("Angular velocity", angular_velocity, dim == 2 ? 1 : 3);
    require_all("Center of rotation", center_of_rotation, dim);
    AssertThrow(points_per_direction > 0,
                ExcParameter(this->path(),
                             "Points per direction",
                             std::to_string(points_per_direction),
                             "it is required and must be at least 1."));
  }

  template <int dim>
  Body<dim>
  make_body(const std::string         &name,
            const BodyParameters<dim> &parameters,
            const unsigned int         material,
            const double               density)
  {
    parameters.validate();
    Body<dim> body;
    body.name                 = name;
    body.material             = material;
    body.density              = density;
    body.points_per_direction = parameters.points_per_direction;
    body.divides_box          = parameters.particle_layout == "body";
    body.shape                = parameters.make_shape();
    for (const std::string &side : parameters.cut_by)
      body.cut_by.set(side_number(side, dim, parameters.path(), "Cut by"));

    std::string text = parameters.initial_velocity;
    if (dealii::Utilities::trim(text).empty())
      for (unsigned int d = 0; d < dim; ++d)
        text += d == 0 ? "0" : ";0";
    body.initial_velocity = read_formulas<dim>(
      text,
      dim,
      parameters.path(),
      "Initial velocity",
      "Write " + std::to_string(dim) +
        " components separated by , or ;, each a formula in " +
        dealii::FunctionParser<dim>::default_variable_names() + ", e.g. " +
        (dim == 2 ? "0.75; 0" : "0.75; 0; 0") + ".");
    const auto &omega = parameters.angular_velocity;
    for (unsigned int i = 0; i < omega.size(); ++i)
      body.angular_velocity[dim == 2 ? 2 : i] = omega[i];
    for (unsigned int d = 0; d < parameters.center_of_rotation.size(); ++d)
      body.center_of_rotation[d] = parameters.center_of_rotation[d];
    return body;
  }

  template <int dim>
  dealii::Tensor<1, dim>
  Body<dim>::velocity_at(const Point<dim> &position) const
  {
    dealii::Tensor<1, 3>   arm;
    dealii::Tensor<1, dim> velocity;
    for (unsigned int d = 0; d < dim; ++d)
      arm[d] = position[d] - center_of_rotation[d];
    const auto rotation = dealii::cross_product_3d(angular_velocity, arm);
    for (unsigned int d = 0; d < dim; ++d)
      velocity[d] = initial_velocity->value(position, d) + rotation[d];
    return velocity;
  }

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
                   shortest(grid.upper_corner()[d]) + " m";
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
              "in its shape",
        "raise its Points per direction, refine the grid, or check its shape.");
      return result;
    }
  } // namespace

  template <int dim>
  void
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
            if (table)
              {
                const auto row = lattices[filling.body].rows_in(key)[i];
                values[volume] = table->volumes[row];
                values[mass]   = from.density * values[volume];
                if (!table->velocities.empty())
                  start += table->velocities[row];
              }
            for (unsigned int d = 0; d < dim; ++d)
              {
                values[velocity + d] = start[d];
                if (!std::isfinite(values[velocity + d]))
                  wrong_velocity =
                    "the initial velocity of body <" + from.name + "> is " +
                    shortest(values[velocity + d]) + " m/s at (" +
                    dealii::Patterns::Tools::to_string(point) + ") m";
              }
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
  }

#define INSTANTIATE(dim)                                                     \
  template class BodyParameters<dim>;                                        \
  template dealii::Tensor<1, dim> Body<dim>::velocity_at(const Point<dim> &) \
    const;                                                                   \
  template Body<dim> make_body<dim>(const std::string &,                     \
                                    const BodyParameters<dim> &,             \
                                    const unsigned int,                      \
                                    const double);                           \
  template std::vector<typename BackgroundGrid<dim>::Occupied>               \
  occupied_cells<dim>(const std::vector<Body<dim>> &,                        \
                      const BackgroundGrid<dim> &);                          \
  template dealii::Tensor<1, dim> initial_half_length<dim>(                  \
    const Body<dim> &, const BackgroundGrid<dim> &);                         \
  template void fill<dim>(const std::vector<Body<dim>> &,                    \
                          const BackgroundGrid<dim> &,                       \
                          const FieldLayout &,                               \
                          dealii::Particles::ParticleHandler<dim> &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
