#ifndef emmy_particles_particle_count_h
#define emmy_particles_particle_count_h

#include <emmy/particles/body.h>
#include <emmy/particles/field_layout.h>

namespace emmy
{
  /**
   * About how many particles a body will have: its volume, or that of its box
   * inside the grid if the shape does not know it, over that of a particle.
   */
  template <int dim>
  double
  expected_particles(const Body<dim> &body, const BackgroundGrid<dim> &grid);

  /**
   * Refuse bodies before their particles are made: more than have numbers, or
   * than the memory of the machines holds. Collective; throws ExcRun.
   */
  template <int dim>
  void
  refuse_too_many(const std::vector<Body<dim>> &bodies,
                  const BackgroundGrid<dim>    &grid,
                  const FieldLayout            &layout);
} // namespace emmy

#endif
