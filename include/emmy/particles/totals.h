#ifndef emmy_particles_totals_h
#define emmy_particles_totals_h

#include <deal.II/base/mpi.h>
#include <deal.II/base/tensor.h>

#include <emmy/particles/field_layout.h>
#include <emmy/particles/point_arrays.h>

#include <cstdint>

namespace emmy
{
  /** Sums over all particles of all ranks. */
  struct Totals
  {
    std::uint64_t        particles      = 0;  ///< over all ranks
    double               mass           = 0.; ///< kg
    double               kinetic_energy = 0.; ///< J
    dealii::Tensor<1, 3> linear_momentum;     ///< kg m/s
    /** About the origin of coordinates, kg m^2/s; in plane strain only [2]. */
    dealii::Tensor<1, 3> angular_momentum;
  };

  /** Collective. */
  template <int dim>
  Totals
  measure(const PointArrays<dim> &points,
          const FieldLayout      &layout,
          const MPI_Comm          communicator);
} // namespace emmy

#endif
