#ifndef emmy_base_dealii_version_h
#define emmy_base_dealii_version_h

#include <deal.II/base/config.h>

#include <deal.II/base/index_set.h>
#include <deal.II/base/mpi.h>

#include <deal.II/lac/affine_constraints.h>

#include <cstdint>
#include <utility>

/**
 * What differs between deal.II 9.4.1 and 9.6, in one place.
 */
namespace emmy
{
  /**
   * Sum of @p count over the ranks below this one, and over all ranks:
   * numbers things without gaps. Collective. (deal.II has
   * partial_and_total_sum for this from 9.5 on.)
   */
  inline std::pair<std::uint64_t, std::uint64_t>
  sum_below_and_total(const std::uint64_t count, const MPI_Comm communicator)
  {
    std::uint64_t up_to_here = 0;
    const int     error =
      MPI_Scan(&count, &up_to_here, 1, MPI_UINT64_T, MPI_SUM, communicator);
    AssertThrowMPI(error);
    const std::uint64_t total = dealii::Utilities::MPI::broadcast(
      communicator,
      up_to_here,
      dealii::Utilities::MPI::n_mpi_processes(communicator) - 1);
    return {up_to_here - count, total};
  }

  /** Empty constraints on unknowns of which this rank knows some. */
  inline void
  reinit_constraints(dealii::AffineConstraints<double> &constraints,
                     const dealii::IndexSet            &owned,
                     const dealii::IndexSet            &known)
  {
#if DEAL_II_VERSION_GTE(9, 6, 0)
    constraints.reinit(owned, known);
#else
    (void)owned;
    constraints.reinit(known);
#endif
  }
} // namespace emmy

#endif
