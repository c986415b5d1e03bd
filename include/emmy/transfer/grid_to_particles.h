#ifndef emmy_transfer_grid_to_particles_h
#define emmy_transfer_grid_to_particles_h

#include <emmy/transfer/particles_to_grid.h>

#include <string>

namespace emmy
{
  /**
   * Move the trial states: x_p += sum S u, and, with the FLIP fraction alpha,
   * v_p = alpha (v_p + sum S (v_new - v_mapped)) + (1 - alpha) sum S v_new
   * (FLIP and PIC; Pretti et al. 2023, eqs 28-30), with v_mapped of
   * VelocityMap::mapped(). Nothing is written to particles.
   *
   * @param points states at t
   * @param displacement,velocity_change u, m, and v_new - alpha v_mapped, m/s,
   *   over local nodes, [dim * node + c]
   * @param trial  gets positions and velocities at t + dt
   *
   * @return the particle of this rank that would leave the grid, in words;
   *   empty if there is none
   */
  template <int dim>
  std::string
  move_points(const Stencils<dim>       &stencils,
              const PointArrays<dim>    &points,
              const ActiveGrid<dim>     &active,
              const BackgroundGrid<dim> &grid,
              const FieldLayout         &layout,
              const double               flip_fraction,
              const std::vector<double> &displacement,
              const std::vector<double> &velocity_change,
              PointArrays<dim>          &trial);

  /**
   * Write accepted states to the particles and hand them to their new cells
   * and ranks. The only place where particles are written. Collective.
   * Throws ExcRun on all ranks if a particle got lost.
   */
  template <int dim>
  void
  grid_to_particles(const Stencils<dim>                     &stencils,
                    const PointArrays<dim>                  &accepted,
                    const FieldLayout                       &layout,
                    BackgroundGrid<dim>                     &grid,
                    dealii::Particles::ParticleHandler<dim> &particles);
} // namespace emmy

#endif
