#ifndef emmy_step_velocity_map_h
#define emmy_step_velocity_map_h

#include <emmy/solve/linear_solver.h>
#include <emmy/step/balance.h>

namespace emmy
{
  /**
   * Find start.velocity by the map of a balance, with a linear solver: see
   * VelocityMap. Collective.
   *
   * @param step its time is that of given velocities; its phases get the
   *   iterations
   * @param start that of the step
   * @return how the last solve ended
   */
  template <int dim>
  LinearResult
  map_velocity(const Balance<dim>  &balance,
               const StepData<dim> &step,
               LinearSolver        &linear_solver,
               GridStart<dim>      &start);
} // namespace emmy

#endif
