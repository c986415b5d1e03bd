#ifndef emmy_system_matrix_pattern_h
#define emmy_system_matrix_pattern_h

#include <deal.II/base/index_set.h>

#include <memory>
#include <vector>

class Epetra_CrsMatrix;

namespace emmy
{
  /**
   * What matrices are made of: dim unknowns follow each other at a node, and
   * all of them meet. In local indices, so that nothing is looked up or sorted;
   * deal.II's pattern looks for each entry. Collective.
   * @param rows        columns of the owned nodes, sorted, in nodes
   * @param column_dofs of each column, its first unknown; owned nodes first
   * @param owned_dofs  of this rank, without gaps
   */
  template <int dim>
  std::unique_ptr<const Epetra_CrsMatrix>
  matrix_pattern(
    const std::vector<std::vector<unsigned int>>       &rows,
    const std::vector<dealii::types::global_dof_index> &column_dofs,
    const dealii::IndexSet                             &owned_dofs,
    const MPI_Comm                                      communicator);
} // namespace emmy

#endif
