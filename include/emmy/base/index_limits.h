#ifndef emmy_base_index_limits_h
#define emmy_base_index_limits_h

#include <deal.II/base/mpi.h>

#include <cstdint>
#include <vector>

/**
 * Numbers that deal.II and Epetra keep in 32 bits: beyond them they would wrap
 * around in silence. Each function refuses such a number in words and throws
 * ExcRun, on all ranks if all pass the same, or as it says. Cost: none.
 */
namespace emmy
{
  /**
   * Places of a grid's cells are numbered with 63 bits. @param n_cells in each
   * direction
   */
  void
  refuse_lattice(const std::vector<unsigned int> &n_cells);

  /**
   * Cells that exist, and their nodes, have numbers of deal.II.
   * @param n_cells,n_nodes of all ranks; exact or a bound from above
   */
  void
  refuse_cells(const double n_cells, const double n_nodes);

  /** Unknowns of all ranks have numbers of Epetra, which are int. */
  void
  refuse_unknowns(const std::uint64_t n_unknowns);

  /**
   * So have the entries of a matrix on each rank. Collective.
   * @param n_entries of this rank
   */
  void
  refuse_matrix_entries(const std::uint64_t n_entries,
                        const MPI_Comm      communicator);
} // namespace emmy

#endif
