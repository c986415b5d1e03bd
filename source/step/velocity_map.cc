#include <emmy/solve/mass_solver.h>
#include <emmy/step/velocity_map.h>

namespace emmy
{
  namespace
  {
    /** Where gradients do not get there: nodes that few particles reach. */
    template <int dim>
    LinearResult
    with_all_unknowns(LinearSolver                               &linear_solver,
                      const GridStart<dim>                       &start,
                      const typename NodalMatrix<dim>::Conditions which,
                      Vector                                     &velocity)
    {
      const Matrix damped_mass = mass_of_unknowns(start, which, Damped::yes);
      const Constraints  none;
      const Constraints &constraints =
        which == NodalMatrix<dim>::Conditions::worked_in
          ? start.active->constraints()
          : none;
      unsigned int iterations = 0;
      const auto   refine     = [&](LinearResult result) {
        if (result.is_solved)
          result = solve_to_round_off(
            linear_solver,
            [&](Vector &r, const Vector &v) {
              start.mass.residual(r, v, start.momentum);
            },
            constraints,
            start.momentum,
            velocity);
        iterations += result.iterations;
        return result;
      };
      LinearResult result = refine(linear_solver.prepare(damped_mass));
      // not from the start: LU of a scaled singular matrix ends with numbers
      // that mean nothing, where that of the matrix itself fails
      if (!result.is_solved)
        result = refine(linear_solver.prepare_mass(damped_mass));
      result.iterations = iterations;
      return result;
    }
  } // namespace

  template <int dim>
  LinearResult
  map_velocity(const Balance<dim>  &balance,
               const StepData<dim> &step,
               LinearSolver        &linear_solver,
               GridStart<dim>      &start)
  {
    LinearResult result;
    // an effect that is being timed has its iterations too
    const auto solve = [&](const typename NodalMatrix<dim>::Conditions which,
                           Vector &velocity) {
      // In the middle of a step what the mass can hardly see, at nodes that
      // next to nothing reaches, goes on into the next step: it stays what the
      // factors of the damped mass make of it.
      if (step.stencils.at_middle)
        result.is_solved = false;
      else
        result = MassSolver<dim>(start.mass, start.damping, which)
                   .solve(velocity, start.momentum);
      unsigned int iterations = result.iterations;
      if (!result.is_solved)
        {
          result = with_all_unknowns(linear_solver, start, which, velocity);
          iterations += result.iterations;
        }
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
