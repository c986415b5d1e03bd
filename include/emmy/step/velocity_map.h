#ifndef emmy_step_velocity_map_h
#define emmy_step_velocity_map_h

#include <emmy/solve/linear_solver.h>
#include <emmy/transfer/particles_to_grid.h>

namespace emmy
{
  /**
   * The map from the particles' momentum to the grid's velocity, M~ v = p
   * (Pretti et al. 2023, eq. 26), with the walls as the mapping has them: sets
   * start.velocity and start.mapped_velocity. Collective.
   *
   * @param wall_velocity the velocity of the walls on fixed unknowns, m/s, and
   *   zero elsewhere. Walls::unconstrained does not use it.
   * @param phases where iterations are booked, and the second solve of
   *   Walls::inelastic as an effect
   * @return how the last solve ended
   */
  template <int dim>
  LinearResult
  map_velocity(const PointMapping &mapping,
               const Vector       &wall_velocity,
               LinearSolver       &linear_solver,
               GridStart<dim>     &start,
               Phases             *phases = nullptr);
} // namespace emmy

#endif
