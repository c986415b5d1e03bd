#include <emmy/step/accounts.h>
#include <emmy/step/velocity_map.h>

namespace emmy
{
  template <int dim>
  LinearResult
  map_velocity(const PointMapping &mapping,
               const Vector       &wall_velocity,
               LinearSolver       &linear_solver,
               GridStart<dim>     &start,
               Phases             *phases)
  {
    const Constraints &constraints = start.active->constraints();
    // the map with and without the essential conditions; an effect that is
    // being timed has its iterations too
    const auto solve = [&](const Matrix      &damped_mass,
                           const Constraints &constraints,
                           Vector            &velocity) {
      unsigned int iterations = 0;
      const auto   refine     = [&](LinearResult result) {
        if (result.is_solved)
          result = solve_to_round_off(
            linear_solver, start.mass, constraints, start.momentum, velocity);
        iterations += result.iterations;
        return result;
      };
      LinearResult result = refine(linear_solver.prepare(damped_mass));
      // not from the start: LU of a scaled singular matrix ends with numbers
      // that mean nothing, where that of the matrix itself fails
      if (!result.is_solved)
        result = refine(linear_solver.prepare_mass(damped_mass));
      result.iterations = iterations;
      if (phases)
        phases->add_iterations("velocity from momentum", iterations);
      return result;
    };

    // The vectors of the step before may be distributed in another way, which
    // Trilinos vectors do not notice when they are copied into: so move.
    LinearResult result;
    if (mapping.walls != PointMapping::Walls::unconstrained)
      {
        Vector velocity = start.mean_velocity;
        constraints.set_zero(velocity);
        velocity += wall_velocity;
        constraints.expand(velocity);
        result         = solve(start.damped_mass, constraints, velocity);
        start.velocity = std::move(velocity);
      }
    if (result.is_solved && mapping.walls != PointMapping::Walls::constrained)
      {
        Vector velocity = start.mean_velocity;
        // the only solve of unconstrained walls is none too many
        const auto timed =
          effect_scope(mapping.walls == PointMapping::Walls::inelastic
                         ? phases
                         : nullptr,
                       inelastic_walls_effect);
        result =
          solve(start.damped_mass_without_walls, Constraints(), velocity);
        start.mapped_velocity = std::move(velocity);
      }
    if (mapping.walls == PointMapping::Walls::constrained)
      start.mapped_velocity = Vector(start.velocity);
    if (mapping.walls == PointMapping::Walls::unconstrained)
      start.velocity = Vector(start.mapped_velocity);
    return result;
  }

  template LinearResult
  map_velocity<2>(const PointMapping &,
                  const Vector &,
                  LinearSolver &,
                  GridStart<2> &,
                  Phases *);
  template LinearResult
  map_velocity<3>(const PointMapping &,
                  const Vector &,
                  LinearSolver &,
                  GridStart<3> &,
                  Phases *);
} // namespace emmy
