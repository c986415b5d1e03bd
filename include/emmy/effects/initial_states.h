#ifndef emmy_effects_initial_states_h
#define emmy_effects_initial_states_h

#include <emmy/material/material.h>
#include <emmy/particles/body.h>

namespace emmy
{
  /**
   * Give particles that were just filled what their material varies by, and the
   * state that has the initial stress of their body. Collective.
   *
   * The state is the elastic strain whose Cauchy stress that is, with the axes
   * of the stress; Newton finds its three values with the material itself. The
   * box of a particle has its volume with that strain, so its reference volume
   * is that over J, and its forces are those of the Cauchy stress. Its mass
   * stays. Total and elastic deformation are the same; nothing has flowed.
   *
   * Throws ExcRun on all ranks where a parameter of a material is not positive,
   * or a material does not bear the stress without flow. Cost: some 20 points
   * of the material for each particle with initial stress.
   *
   * @param material_of_body one per body
   */
  template <int dim>
  void
  set_initial_states(const std::vector<Body<dim>>             &bodies,
                     const std::vector<const Material<dim> *> &material_of_body,
                     const FieldLayout                        &layout,
                     const MPI_Comm                            communicator,
                     dealii::Particles::ParticleHandler<dim>  &particles);

  /**
   * Give particles that have a state, but did not come from a step with the
   * treatment of locking (MeanDilatation), what that carries: own volumes are
   * those of their deformation, and the mean stress of a cell is that of its
   * particles of one material, sum V0 tr tau/3 over sum V0 J, as it is in each
   * step. Nothing where a scene has no such treatment. Cost: two passes over
   * the particles.
   */
  template <int dim>
  void
  set_cell_states(const std::vector<const Material<dim> *> &material_of_body,
                  const FieldLayout                        &layout,
                  dealii::Particles::ParticleHandler<dim>  &particles);
} // namespace emmy

#endif
