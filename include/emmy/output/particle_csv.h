#ifndef emmy_output_particle_csv_h
#define emmy_output_particle_csv_h

#include <deal.II/base/mpi.h>

#include <deal.II/particles/particle_handler.h>

#include <emmy/particles/field_layout.h>

#include <string>

namespace emmy
{
  /**
   * All that a scene needs to begin with particles as they are, as a table
   * with all digits (CSV): id, body, x, y (z), volume (present), mass,
   * velocity, elastic_strain, logarithmic_strain, cauchy_stress, and what
   * materials remember. `Shape = particles` reads it. The first rank writes
   * it; throws ExcRun on all. Collective. Cost: some 500 bytes a particle on
   * the first rank.
   */
  template <int dim>
  void
  write_particle_csv(const std::string                             &filename,
                     const FieldLayout                             &layout,
                     const dealii::Particles::ParticleHandler<dim> &particles,
                     const MPI_Comm communicator);
} // namespace emmy

#endif
