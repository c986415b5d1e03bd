#ifndef emmy_particles_body_pieces_h
#define emmy_particles_body_pieces_h

#include <emmy/particles/body.h>

#include <vector>

namespace emmy
{
  /**
   * In how many pieces the grid sees each body: cells that hold its particles
   * and share a node belong to one piece; pieces can part from the first step
   * on. Collective. Ranks join their own cells; the first one joins the
   * pieces by those cells that lack a neighbour on their rank, which are as
   * many as the body has on its surface and along the cuts between ranks.
   */
  template <int dim>
  std::vector<unsigned int>
  count_pieces(const unsigned int                             n_bodies,
               const BackgroundGrid<dim>                     &grid,
               const FieldLayout                             &layout,
               const dealii::Particles::ParticleHandler<dim> &particles);
} // namespace emmy

#endif
