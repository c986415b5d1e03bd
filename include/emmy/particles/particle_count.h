#ifndef emmy_particles_particle_count_h
#define emmy_particles_particle_count_h

#include <emmy/particles/body.h>
#include <emmy/particles/field_layout.h>

namespace emmy
{
  /**
   * Refuse bodies before their particles are made: more than ids count, or than
   * the memory of the machines holds. About as many are expected as a body's
   * volume has room for, or its box inside the grid if its shape does not know
   * the volume. Cost: none. Collective; throws ExcRun.
   */
  template <int dim>
  void
  refuse_too_many(const std::vector<Body<dim>> &bodies,
                  const BackgroundGrid<dim>    &grid,
                  const FieldLayout            &layout);
} // namespace emmy

#endif
