#include <emmy/step/velocity_map.h>

namespace emmy
{
  template <int dim>
  LinearResult
  map_velocity(const Mapping  &mapping,
               const Vector   &wall_velocity,
               LinearSolver   &linear_solver,
               GridStart<dim> &start)
  {
    const auto &walls = start.active->constraints();
    // the map with and without the essential conditions
    const auto solve = [&](const Matrix                            &damped_mass,
                           const dealii::AffineConstraints<double> &constraints,
                           Vector                                  &velocity) {
      LinearResult result = linear_solver.prepare(damped_mass);
      if (result.is_solved)
        result = solve_to_round_off(
          linear_solver, start.mass, constraints, start.momentum, velocity);
      return result;
    };

    LinearResult result;
    start.velocity = start.mean_velocity;
    if (mapping.walls != Mapping::Walls::unconstrained)
      {
        walls.set_zero(start.velocity);
        start.velocity += wall_velocity;
        result = solve(start.damped_mass, walls, start.velocity);
      }
    if (mapping.walls == Mapping::Walls::constrained || !result.is_solved)
      {
        start.mapped_velocity = start.velocity;
        return result;
      }
    dealii::AffineConstraints<double> none;
    none.close();
    start.mapped_velocity = start.mean_velocity;
    const LinearResult without_walls =
      solve(start.damped_mass_without_walls, none, start.mapped_velocity);
    if (mapping.walls == Mapping::Walls::unconstrained)
      start.velocity = start.mapped_velocity;
    result.iterations += without_walls.iterations;
    result.is_solved = without_walls.is_solved;
    result.problem   = without_walls.problem;
    return result;
  }

  template LinearResult
  map_velocity<2>(const Mapping &,
                  const Vector &,
                  LinearSolver &,
                  GridStart<2> &);
  template LinearResult
  map_velocity<3>(const Mapping &,
                  const Vector &,
                  LinearSolver &,
                  GridStart<3> &);
} // namespace emmy
