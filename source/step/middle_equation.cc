#include <emmy/base/exceptions.h>
#include <emmy/step/middle_equation.h>

#include <algorithm>
#include <optional>

namespace emmy
{
  namespace
  {
    /** How often places may move before they stay where they are. */
    constexpr unsigned int most_moves = 12;

    /** Whether the same points reach the same nodes and cells. */
    template <int dim>
    bool
    have_same_nodes(const Stencils<dim> &a, const Stencils<dim> &b)
    {
      return a.groups.size() == b.groups.size() && a.node_ids == b.node_ids &&
             a.order == b.order &&
             std::equal(a.groups.begin(),
                        a.groups.end(),
                        b.groups.begin(),
                        [](const auto &one, const auto &other) {
                          return one.body == other.body &&
                                 one.n_points == other.n_points &&
                                 one.first_node == other.first_node &&
                                 one.origin == other.origin;
                        }) &&
             a.active_cells == b.active_cells;
    }
  } // namespace

  template <int dim>
  MiddleEquation<dim>::MiddleEquation(Start start, Places<dim> guess)
    : start(std::move(start))
    , first_places(std::move(guess))
  {
    renew(first_places, nullptr, nullptr);
  }

  template <int dim>
  Vector
  MiddleEquation<dim>::first_displacement() const
  {
    Vector u = on_grid->mean_velocity;
    u *= start.time_step;
    active->constraints().set_zero(u);
    start.balance.add_given_displacement(
      *active, start.time, start.time_step, u, start.phases);
    active->constraints().expand(u);
    return u;
  }

  template <int dim>
  void
  MiddleEquation<dim>::renew(Places<dim> new_places,
                             Vector     *solution,
                             Vector     *increment)
  {
    places = std::move(new_places);
    found =
      agree_on_problem(start.rules.grid.communicator(), problem_of(places));
    if (!found.empty())
      return;
    // what is of the places before goes first: there would be two of all
    std::optional<PointArrays<dim>> trial;
    if (current)
      {
        trial = std::move(step_equation->trial());
        step_equation.reset();
        current->stencils.values    = {};
        current->stencils.gradients = {};
      }
    moving.reset();
    auto before = active;
    auto next   = std::make_unique<Ground<dim>>();
    {
      const auto timed = start.phases->scope("stencils");
      next->stencils =
        start.rules.shape_functions.evaluate(places, start.rules.grid);
      next->stencils.at_middle = true;
    }
    // particles often stand in the order of before
    const bool has_order =
      current && next->stencils.order == current->stencils.order;
    if (current)
      next->points = std::move(current->points);
    if (!has_order)
      {
        const auto timed = start.phases->scope("gather");
        gather(next->stencils, start.rules.layout, next->points);
        if (trial)
          *trial = next->points;
      }
    renew_nodes(*next);
    active = on_grid->active;
    if (solution && before != active)
      {
        *solution =
          active->carried_over(*before, *solution, first_displacement());
        active->constraints().expand(*solution);
        *increment =
          active->carried_over(*before, *increment, active->make_vector());
      }
    before.reset();
    current = std::move(next);
    if (!is_frozen)
      moving = std::make_unique<MovingPlaces<dim>>(start.rules, places);
    const auto          timed = start.phases->scope("loads and matrices");
    const StepData<dim> step{current->stencils,
                             current->points,
                             *on_grid,
                             start.time,
                             start.time_step,
                             start.phases,
                             moving.get()};
    step_equation = trial ? start.balance.over(step, std::move(*trial))
                          : start.balance.over(step);
  }

  template <int dim>
  void
  MiddleEquation<dim>::renew_nodes(const Ground<dim> &next)
  {
    const auto timed     = start.phases->scope("particles to grid");
    const bool has_nodes = dealii::Utilities::MPI::min(
      current && have_same_nodes(next.stencils, current->stencils) ? 1 : 0,
      start.rules.grid.communicator());
    if (has_nodes && start.balance.take_weights(next.stencils,
                                                start.rules.grid,
                                                start.phases))
      {
        start.particles_to_grid.renew_momentum(next.stencils, next.points);
        return;
      }
    if (!on_grid) // classes are those of the first places
      start.balance.classify(next.stencils,
                             next.points,
                             start.rules.grid,
                             start.phases);
    on_grid = &start.particles_to_grid.renew_but_for_mass(
      next.stencils,
      next.points,
      start.balance.couplings(next.stencils,
                              start.rules.grid,
                              start.boundary_conditions,
                              start.phases));
  }

  template <int dim>
  std::string
  MiddleEquation<dim>::problem_of(const Places<dim> &places) const
  {
    const BackgroundGrid<dim> &grid = start.rules.grid;
    const auto                 end  = grid.triangulation().end();
    for (std::size_t i = 0; i < places.size(); ++i)
      {
        // in the cell that holds the particle all around is known
        const auto home =
          grid.key_of(places.particles[i]->get_surrounding_cell());
        const auto here = grid.key_of(places.positions[i]);
        if (here == home)
          continue;
        dealii::Tensor<1, dim> reach;
        if (!places.half_lengths.empty())
          for (unsigned int d = 0; d < dim; ++d)
            reach[d] =
              std::min(places.half_lengths[i][d], grid.size_of(here)[d]);
        for (unsigned int corner = 0; corner < (1u << dim); ++corner)
          {
            dealii::Point<dim> x = places.positions[i];
            for (unsigned int d = 0; d < dim; ++d)
              x[d] += (corner >> d) & 1 ? reach[d] : -reach[d];
            if (grid.cell_at(grid.key_of(grid.clamped(x))) == end)
              return "particle " +
                     std::to_string(places.particles[i]->get_id()) +
                     " moves too far within the step for its rank";
          }
      }
    return "";
  }

  template <int dim>
  bool
  MiddleEquation<dim>::evaluate(const Vector &solution,
                                const bool    with_jacobian)
  {
    if (!found.empty() || !step_equation->evaluate(solution, with_jacobian))
      return false;
    if (moving && !with_jacobian)
      moving->find_defect(step_equation->data(), active->to_local(solution));
    if (moving)
      defect = dealii::Utilities::MPI::max(moving->largest_defect(),
                                           active->communicator());
    return true;
  }

  template <int dim>
  void
  MiddleEquation<dim>::take(Vector &solution, Vector &increment)
  {
    solution += increment;
    places_before = places;
    if (!moving)
      return;
    if (++n_moves == most_moves)
      {
        is_frozen = true;
        moving.reset();
        renew(places, &solution, &increment);
        return;
      }
    renew(moving->moved(step_equation->data(), active->to_local(increment)),
          &solution,
          &increment);
  }

  template <int dim>
  void
  MiddleEquation<dim>::halve(Vector &solution, Vector &increment)
  {
    increment *= 0.5;
    solution -= increment;
    if (!moving)
      return;
    for (std::size_t i = 0; i < places.size(); ++i)
      {
        places.positions[i] = dealii::Point<dim>(
          0.5 * (dealii::Tensor<1, dim>(places.positions[i]) +
                 places_before.positions[i]));
        places.cells[i] = start.rules.grid.key_of(places.positions[i]);
        if (!places.half_lengths.empty())
          places.half_lengths[i] =
            0.5 * (places.half_lengths[i] + places_before.half_lengths[i]);
      }
    renew(places, &solution, &increment);
    // the increment was one of other followers if the last renewal found them
    active->constraints().expand(solution);
  }

  template <int dim>
  void
  MiddleEquation<dim>::take_back(Vector &solution, Vector &increment)
  {
    solution -= increment;
    if (!moving)
      return;
    renew(places_before, &solution, &increment);
    active->constraints().expand(solution);
  }

  template <int dim>
  bool
  MiddleEquation<dim>::is_settled() const
  {
    return is_frozen || defect <= start.tolerance;
  }

  template <int dim>
  void
  MiddleEquation<dim>::begin_again(Vector &solution, const Vector &first)
  {
    (void)first; // numbered as the unknowns were at the start
    is_frozen = true;
    renew(first_places, nullptr, nullptr);
    solution = first_displacement();
  }

  template <int dim>
  bool
  MiddleEquation<dim>::has_given_up() const
  {
    return is_frozen;
  }

  template <int dim>
  double
  MiddleEquation<dim>::largest_defect() const
  {
    return defect;
  }

  template <int dim>
  dealii::Tensor<1, 3>
  MiddleEquation<dim>::angular_momentum_left(
    const Vector           &displacement,
    const PointArrays<dim> &trial) const
  {
    const auto &[stencils, points] = *current;
    const auto         local       = active->to_local(displacement);
    const unsigned int mass        = start.rules.layout["mass"],
                       velocity    = start.rules.layout["velocity"];
    dealii::Tensor<1, 3> result;
    for (const auto &group : stencils.groups)
      for (unsigned int q = 0; q < group.n_points; ++q)
        {
          const std::size_t    p = group.first_point + q;
          dealii::Tensor<1, 3> arm, dv;
          for (unsigned int c = 0; c < dim; ++c)
            {
              arm[c] =
                points.position(c)[p] - places.positions[stencils.order[p]][c];
              for (unsigned int a = 0; a < group.n_nodes; ++a)
                arm[c] += 0.5 * stencils.value(group, a)[q] *
                          local[unknown<dim>(active->nodes(group)[a], c)];
              dv[c] = trial.component(velocity + c)[p] -
                      points.component(velocity + c)[p];
            }
          result += points.component(mass)[p] * cross_product_3d(arm, dv);
        }
    return dealii::Utilities::MPI::sum(result, active->communicator());
  }

  template <int dim>
  GridStart<dim> &
  MiddleEquation<dim>::grid_start()
  {
    return *on_grid;
  }

  template <int dim>
  const Ground<dim> &
  MiddleEquation<dim>::ground() const
  {
    return *current;
  }

  template <int dim>
  StepEquation<dim> &
  MiddleEquation<dim>::equation()
  {
    return *step_equation;
  }

  template <int dim>
  NewtonSystem
  MiddleEquation<dim>::system()
  {
    return step_equation->system();
  }

  template <int dim>
  void
  MiddleEquation<dim>::expand(Vector &increment) const
  {
    step_equation->expand(increment);
  }

  template <int dim>
  double
  MiddleEquation<dim>::size(const Vector &increment) const
  {
    return step_equation->size(increment);
  }

  template <int dim>
  const std::string &
  MiddleEquation<dim>::problem() const
  {
    return found.empty() ? step_equation->problem() : found;
  }

  template class MiddleEquation<2>;
  template class MiddleEquation<3>;
} // namespace emmy
