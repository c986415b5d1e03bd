#include <deal.II/base/quadrature_lib.h>

#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/effects/moving_walls.h>

#include <algorithm>
#include <cmath>

namespace emmy
{
  MovingWallParameters::MovingWallParameters(const unsigned int dim,
                                             const std::string &section)
    : Section(section)
    , velocities(2 * dim)
  {
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

  bool
  MovingWallParameters::are_present() const
  {
    return std::any_of(velocities.begin(),
                       velocities.end(),
                       [](const std::string &text) {
                         return !dealii::Utilities::trim(text).empty();
                       });
  }

  template <int dim>
  MovingWalls<dim>::MovingWalls(
    const MovingWallParameters    &parameters,
    const BoundaryConditions<dim> &boundary_conditions,
    const BackgroundGrid<dim>     &grid)
    : boundary_conditions(boundary_conditions)
    , grid(grid)
    , section(parameters.path())
  {
    const std::vector<std::string> names = side_names(dim);
    for (unsigned int side = 0; side < 2 * dim; ++side)
      {
        const std::string &text  = parameters.velocities[side];
        const std::string  entry = "Velocity of " + names[side];
        if (dealii::Utilities::trim(text).empty())
          continue;
        const unsigned int n_components =
          boundary_conditions.fixed_components_of(side).count();
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
  EffectCard
  MovingWalls<dim>::card(const bool is_present)
  {
    EffectCard card;
    card.name           = "moving walls";
    card.setting        = "Boundary conditions/Velocity of a side";
    card.enters         = "velocity from momentum, Newton: given values";
    card.ledger_columns = {"reaction_work"};
    card.is_present     = is_present;
    return card;
  }

  template <int dim>
  typename MovingWalls<dim>::Sides
  MovingWalls<dim>::velocities(const double time) const
  {
    Sides result;
    for (unsigned int side = 0; side < 2 * dim; ++side)
      if (motion[side])
        for (unsigned int c = 0, entry = 0; c < dim; ++c)
          if (boundary_conditions.fixed_components_of(side)[c])
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
  typename MovingWalls<dim>::Sides
  MovingWalls<dim>::displacements(const double time,
                                  const double time_step) const
  {
    const dealii::QGauss<1> gauss(4);
    Sides                   result;
    for (unsigned int q = 0; q < gauss.size(); ++q)
      {
        const Sides velocity = velocities(time + gauss.point(q)[0] * time_step);
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
      "name <tools> in Effects/Names: in Effects/Tools a tool with Shape = "
      "plane, its Reference point on that side, Displacement in place of the "
      "velocity, and in its subsection <plane> the Normal towards the body; to "
      "draw, Holds = true.";
  } // namespace

  template <int dim>
  double
  MovingWalls<dim>::allowed_travel(const unsigned int side) const
  {
    return largest_normal_travel * grid.cell_size()[side / 2];
  }

  template <int dim>
  void
  MovingWalls<dim>::check_run(const double end_time) const
  {
    constexpr unsigned int  n_parts = 4096;
    const dealii::QGauss<1> gauss(4);
    for (unsigned int side = 0; side < 2 * dim; ++side)
      {
        if (!motion[side] || !boundary_conditions.is_wall(side) ||
            !(end_time > 0.))
          continue;
        // of the components that are given, the normal one
        const unsigned int entry =
          boundary_conditions.fixed_components_of(side).count() == 1 ? 0
                                                                     : side / 2;
        const double dt = end_time / n_parts, allowed = allowed_travel(side);
        double       moved = 0., passed_at = -1., farthest = 0.;
        for (unsigned int part = 0; part < n_parts && std::isfinite(moved);
             ++part)
          {
            for (unsigned int q = 0; q < gauss.size(); ++q)
              moved += gauss.weight(q) * dt *
                       motion[side]->value(dealii::Point<1>(
                                             (part + gauss.point(q)[0]) * dt),
                                           entry);
            if (!(std::abs(moved) > allowed) || !std::isfinite(moved))
              continue;
            if (passed_at < 0.)
              passed_at = (part + 1) * dt;
            farthest = std::max(farthest, std::abs(moved));
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
  std::vector<double>
  MovingWalls<dim>::contents() const
  {
    std::vector<double> numbers;
    for (const dealii::Tensor<1, dim> &of_side : travel)
      for (unsigned int c = 0; c < dim; ++c)
        numbers.push_back(of_side[c]);
    return numbers;
  }

  template <int dim>
  void
  MovingWalls<dim>::recall(const std::vector<std::vector<double>> &parts)
  {
    // the same on all ranks
    for (unsigned int side = 0; side < 2 * dim; ++side)
      for (unsigned int c = 0; c < dim; ++c)
        travel[side][c] = parts.at(0).at(side * dim + c);
  }

  template <int dim>
  typename MovingWalls<dim>::Sides
  MovingWalls<dim>::travel_after(const double time,
                                 const double time_step) const
  {
    Sides result = displacements(time, time_step);
    for (unsigned int side = 0; side < 2 * dim; ++side)
      result[side] += travel[side];
    return result;
  }

  template <int dim>
  void
  MovingWalls<dim>::check_step(const double       time,
                               const double       time_step,
                               const std::string &where) const
  {
    const Sides after = travel_after(time, time_step);
    for (unsigned int side = 0; side < 2 * dim; ++side)
      {
        const double along = std::abs(after[side][side / 2]);
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
  void
  MovingWalls<dim>::end_step(const double time, const double time_step)
  {
    travel = travel_after(time, time_step);
  }

  template <int dim>
  const GivenMotion<dim> *
  MovingWalls<dim>::given_motion() const
  {
    return this;
  }

  template <int dim>
  void
  MovingWalls<dim>::add_sides(const Sides           &sides,
                              const ActiveGrid<dim> &active,
                              Vector                &vector) const
  {
    auto entry = vector.begin();
    for (unsigned int node = 0; node < active.n_owned_nodes(); ++node)
      {
        const auto here = boundary_conditions.sides_at(active.position(node));
        for (unsigned int c = 0; c < dim; ++c, ++entry)
          for (unsigned int side = 0; side < 2 * dim; ++side)
            if (here[side] && motion[side] &&
                boundary_conditions.fixed_components_of(side)[c])
              {
                *entry += sides[side][c];
                break;
              }
      }
  }

  template <int dim>
  void
  MovingWalls<dim>::add_velocity(const ActiveGrid<dim> &active,
                                 const double           time,
                                 Vector                &velocity) const
  {
    add_sides(velocities(time), active, velocity);
  }

  template <int dim>
  void
  MovingWalls<dim>::add_displacement(const ActiveGrid<dim> &active,
                                     const double           time,
                                     const double           time_step,
                                     Vector                &displacement) const
  {
    add_sides(displacements(time, time_step), active, displacement);
  }

  template <int dim>
  std::string
  MovingWalls<dim>::work_column() const
  {
    return "reaction_work";
  }

  template class MovingWalls<2>;
  template class MovingWalls<3>;
} // namespace emmy
