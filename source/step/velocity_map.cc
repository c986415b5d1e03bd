#include <emmy/step/velocity_map.h>

namespace emmy
{
  template <int dim>
  LinearResult
  map_velocity(const Balance<dim>  &balance,
               const StepData<dim> &step,
               LinearSolver        &linear_solver,
               GridStart<dim>      &start)
  {
    LinearResult result;
    // an effect that is being timed has its iterations too
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
      result = refine(linear_solver.prepare(damped_mass));
      // not from the start: LU of a scaled singular matrix ends with numbers
      // that mean nothing, where that of the matrix itself fails
      if (!result.is_solved)
        result = refine(linear_solver.prepare_mass(damped_mass));
      result.iterations = iterations;
      if (step.phases)
        step.phases->add_iterations("velocity from momentum", iterations);
      return result.is_solved;
    };
    balance.velocity_map().find(step,
                                balance.given_velocity(*start.active,
                                                       step.time,
                                                       step.phases),
                                solve,
                                start);
    return result;
  }

  template LinearResult
  map_velocity<2>(const Balance<2> &,
                  const StepData<2> &,
                  LinearSolver &,
                  GridStart<2> &);
  template LinearResult
  map_velocity<3>(const Balance<3> &,
                  const StepData<3> &,
                  LinearSolver &,
                  GridStart<3> &);
} // namespace emmy
