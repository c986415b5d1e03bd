#ifndef emmy_effects_table_states_h
#define emmy_effects_table_states_h

#include <emmy/material/material.h>
#include <emmy/particles/body.h>

#include <string>
#include <vector>

namespace emmy
{
  /** Whether a body's particles come from a table that says more than where. */
  template <int dim>
  bool
  has_table_state(const Body<dim> &body);

  /**
   * Give particles that were just filled from tables what the tables say of
   * their state; what they do not say is that of a virgin body. Collective.
   *
   * The elastic state is that of the first of these that is there:
   * elastic_strain (1/2 ln b^e), kirchhoff_stress, cauchy_stress (Pa),
   * elastic_left_cauchy_green, and, of materials without history,
   * logarithmic_strain and left_cauchy_green; each with its components _xx,
   * _yy, _zz, _xy (_xz, _yz). Of materials with history the last two say how
   * the particle has been deformed in all; without them it is as the elastic
   * state. The material's history and what it varies by, and
   * plastic_dissipation_density, come by their names.
   *
   * The table has the present volume: the reference volume is that over J.
   * Throws ExcRun on all ranks for a column that the material has no use for,
   * for a stress that it does not bear, and beside an initial stress.
   *
   * @return notes for the log: what was taken, and what is as in a virgin body
   */
  template <int dim>
  std::vector<std::string>
  set_table_states(const std::vector<Body<dim>>             &bodies,
                   const std::vector<const Material<dim> *> &material_of_body,
                   const FieldLayout                        &layout,
                   const FilledRows                         &filled,
                   const MPI_Comm                            communicator,
                   dealii::Particles::ParticleHandler<dim>  &particles);

  /** The energy whose density is this field, J. Collective. */
  template <int dim>
  double
  total_energy(const std::string                             &density,
               const FieldLayout                             &layout,
               const MPI_Comm                                 communicator,
               const dealii::Particles::ParticleHandler<dim> &particles);
} // namespace emmy

#endif
