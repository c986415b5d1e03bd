#include <deal.II/base/quadrature_lib.h>

#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/grid/boundary_conditions.h>

#include <algorithm>
#include <cmath>

namespace emmy
{
  BoundaryParameters::BoundaryParameters(const unsigned int dim,
                                         const std::string &section)
    : Section(section)
    , velocities(2 * dim)
  {
    const dealii::Patterns::List sides(dealii::Patterns::Anything(), 0);
    add_parameter("Fixed",
                  fixed,
                  "Sides of the grid where all components of the displacement "
                  "are zero. A list of x-min, x-max, y-min, y-max, z-min, "
                  "z-max.",
                  prm,
                  sides);
    add_parameter("Roller",
                  roller,
                  "Sides of the grid where the normal component of the "
                  "displacement is zero. A list of sides, as for <Fixed>.",
                  prm,
                  sides);
    for (unsigned int side = 0; side < 2 * dim; ++side)
      add_parameter(
        "Velocity of " + side_names(dim)[side],
        velocities[side],
        "Formulas in t (s) of a wall that moves: " + std::to_string(dim) +
          " components separated by , or ; for a side in <Fixed>, the "
          "normal one for a side in <Roller>. Unit: m/s. Empty: "
          "at rest. The grid stays where it is, so a side can move "
          "along itself only: at most 1 % of a cell along its "
          "normal in all.");
  }

  std::vector<std::string>
  side_names(const unsigned int dim)
  {
    std::vector<std::string> names;
    for (unsigned int d = 0; d < dim; ++d)
      for (const char *end : {"-min", "-max"})
        names.push_back(std::string(1, "xyz"[d]) + end);
    return names;
  }

  unsigned int
  side_number(const std::string &name,
              const unsigned int dim,
              const std::string &section,
              const std::string &entry)
  {
    const std::vector<std::string> names = side_names(dim);
    const auto        position = std::find(names.begin(), names.end(), name);
    const std::string nearest  = nearest_name(name, names);
    AssertThrow(position != names.end(),
                ExcParameter(section,
                             entry,
                             name,
                             "the grid has no such side. " +
                               (nearest.empty()
                                  ? std::string()
                                  : "Did you mean <" + nearest + ">? ") +
                               "Its sides are " + join(names) +
                               ". Commas separate several."));
    return position - names.begin();
  }

  template <int dim>
  BoundaryConditions<dim>::BoundaryConditions(
    const BoundaryParameters  &parameters,
    const BackgroundGrid<dim> &grid)
    : grid(grid)
    , section(parameters.path())
  {
    const std::vector<std::string> names = side_names(dim);
    for (const std::string &name : parameters.fixed)
      fixed_on_side[side_number(name, dim, section, "Fixed")].set();
    for (const std::string &name : parameters.roller)
      {
        const unsigned int side = side_number(name, dim, section, "Roller");
        fixed_on_side[side].set(side / 2);
      }
    for (unsigned int side = 0; side < 2 * dim; ++side)
      {
        const std::string &text  = parameters.velocities[side];
        const std::string  entry = "Velocity of " + names[side];
        if (dealii::Utilities::trim(text).empty())
          continue;
        const unsigned int n_components = fixed_on_side[side].count();
        AssertThrow(n_components > 0,
                    ExcParameter(section,
                                 entry,
                                 text,
                                 "this side is free. Name it in <Fixed> or "
                                 "<Roller>, or remove the velocity."));
        motion[side] = read_formulas<1>(
          text,
          n_components,
          section,
          entry,
          n_components == 1
            ? "Write one formula in t, the normal velocity (m/s), e.g. 0.1*t."
            : "Write " + std::to_string(dim) +
                " components separated by , or ;, each a formula in t (m/s), e.g. " +
                (dim == 2 ? "0; 0.1*t." : "0; 0; 0.1*t."),
          "t");
      }
  }

  template <int dim>
  std::bitset<2 * dim>
  BoundaryConditions<dim>::sides_at(const dealii::Point<dim> &position) const
  {
    std::bitset<2 * dim> sides;
    for (unsigned int d = 0; d < dim; ++d)
      {
        const double tolerance = 1e-6 * grid.cell_size()[d];
        sides[2 * d] =
          std::abs(position[d] - grid.lower_corner()[d]) < tolerance;
        sides[2 * d + 1] =
          std::abs(position[d] - grid.upper_corner()[d]) < tolerance;
      }
    return sides;
  }

  template <int dim>
  std::bitset<dim>
  BoundaryConditions<dim>::fixed_components(
    const dealii::Point<dim> &position) const
  {
    const auto       sides = sides_at(position);
    std::bitset<dim> result;
    for (unsigned int side = 0; side < 2 * dim; ++side)
      if (sides[side])
        result |= fixed_on_side[side];
    return result;
  }

  template <int dim>
  bool
  BoundaryConditions<dim>::is_wall(const unsigned int side) const
  {
    return fixed_on_side[side][side / 2];
  }

  template <int dim>
  bool
  BoundaryConditions<dim>::has_walls() const
  {
    return std::any_of(fixed_on_side.begin(),
                       fixed_on_side.end(),
                       [](const auto &fixed) { return fixed.any(); });
  }

  template <int dim>
  bool
  BoundaryConditions<dim>::has_moving_walls() const
  {
    return std::any_of(motion.begin(), motion.end(), [](const auto &wall) {
      return wall != nullptr;
    });
  }

  template <int dim>
  typename BoundaryConditions<dim>::Sides
  BoundaryConditions<dim>::wall_velocities(const double time) const
  {
    Sides result;
    for (unsigned int side = 0; side < 2 * dim; ++side)
      if (motion[side])
        for (unsigned int c = 0, entry = 0; c < dim; ++c)
          if (fixed_on_side[side][c])
            {
              const double v =
                motion[side]->value(dealii::Point<1>(time), entry++);
              AssertThrow(std::isfinite(v),
                          ExcRun(section,
                                 "<Velocity of " + side_names(dim)[side] +
                                   "> is " + shortest(v) +
                                   " m/s at t = " + brief(time) + " s",
                                 "correct the formula, or end the run "
                                 "earlier (Time/End time)."));
              result[side][c] = v;
            }
    return result;
  }

  template <int dim>
  typename BoundaryConditions<dim>::Sides
  BoundaryConditions<dim>::wall_displacements(const double time,
                                              const double time_step) const
  {
    const dealii::QGauss<1> gauss(4);
    Sides                   result;
    for (unsigned int q = 0; q < gauss.size(); ++q)
      {
        const Sides velocity =
          wall_velocities(time + gauss.point(q)[0] * time_step);
        for (unsigned int side = 0; side < 2 * dim; ++side)
          result[side] += gauss.weight(q) * time_step * velocity[side];
      }
    return result;
  }

  namespace
  {
    /** Of a side along its normal in all; in cells. */
    constexpr double largest_normal_travel = 0.01;

    constexpr const char *instead_of_travel =
      "A side may move along its normal by at most 1 % of a cell in all: the "
      "grid stays where it is, so the wall would act where the grid ends and "
      "not where the wall is. What it presses would get about half of the "
      "work and pass through it, what it draws would leave the grid. Let the "
      "side move along itself (normal component 0). To press or draw a body, "
      "give it a point load, or let a stiff, heavy second body push it; rigid "
      "tools that move through the grid are not there yet.";
  } // namespace

  template <int dim>
  double
  BoundaryConditions<dim>::allowed_travel(const unsigned int side) const
  {
    return largest_normal_travel * grid.cell_size()[side / 2];
  }

  template <int dim>
  void
  BoundaryConditions<dim>::check_run(const double end_time) const
  {
    constexpr unsigned int  n_parts = 4096;
    const dealii::QGauss<1> gauss(4);
    for (unsigned int side = 0; side < 2 * dim; ++side)
      {
        if (!motion[side] || !is_wall(side) || !(end_time > 0.))
          continue;
        // of the components that are given, the normal one
        const unsigned int entry =
          fixed_on_side[side].count() == 1 ? 0 : side / 2;
        const double dt = end_time / n_parts, allowed = allowed_travel(side);
        double       travel = 0., passed_at = -1., farthest = 0.;
        for (unsigned int part = 0; part < n_parts && std::isfinite(travel);
             ++part)
          {
            for (unsigned int q = 0; q < gauss.size(); ++q)
              travel += gauss.weight(q) * dt *
                        motion[side]->value(dealii::Point<1>(
                                              (part + gauss.point(q)[0]) * dt),
                                            entry);
            if (!(std::abs(travel) > allowed) || !std::isfinite(travel))
              continue;
            if (passed_at < 0.)
              passed_at = (part + 1) * dt;
            farthest = std::max(farthest, std::abs(travel));
          }
        const double h = grid.cell_size()[side / 2];
        AssertThrow(
          passed_at < 0.,
          ExcParameter(section,
                       "Velocity of " + side_names(dim)[side],
                       join(motion[side]->get_expressions(), "; "),
                       "the side would move along its normal by " +
                         brief(farthest) + " m, " + brief(farthest / h) +
                         " cells, and passes 1 % of a cell at t = " +
                         brief(passed_at) + " s. " + instead_of_travel));
      }
  }

  template <int dim>
  void
  BoundaryConditions<dim>::check_travel(const Sides       &travel,
                                        const std::string &where) const
  {
    for (unsigned int side = 0; side < 2 * dim; ++side)
      {
        const double along = std::abs(travel[side][side / 2]);
        AssertThrow(along <= allowed_travel(side),
                    ExcRun(where,
                           "the side " + side_names(dim)[side] +
                             " would have moved by " + brief(along) + " m, " +
                             brief(along / grid.cell_size()[side / 2]) +
                             " cells, along its normal",
                           "the last accepted state was kept. " +
                             std::string(instead_of_travel)));
      }
  }

  template <int dim>
  double
  BoundaryConditions<dim>::value(const Sides              &sides,
                                 const dealii::Point<dim> &position,
                                 const unsigned int        component) const
  {
    const auto here = sides_at(position);
    for (unsigned int side = 0; side < 2 * dim; ++side)
      if (here[side] && motion[side] && fixed_on_side[side][component])
        return sides[side][component];
    return 0.;
  }

  template class BoundaryConditions<2>;
  template class BoundaryConditions<3>;
} // namespace emmy
