#ifndef emmy_solve_met_nodes_h
#define emmy_solve_met_nodes_h

#include <emmy/base/linear_algebra.h>
#include <emmy/system/node_exchange.h>

#include <vector>

class Epetra_CrsGraph;

namespace emmy
{
  /**
   * Nodes of other ranks that the rows of this one meet, sorted.
   * @param n unknowns of a node
   */
  std::vector<dealii::types::global_dof_index>
  met_on_others(const Epetra_CrsGraph &graph, const unsigned int n);

  /** Of a matrix with all unknowns of a node on one rank. Collective. */
  NodeExchange
  exchange_with_others(
    const Matrix                                       &matrix,
    const unsigned int                                  n,
    const std::vector<dealii::types::global_dof_index> &others);
} // namespace emmy

#endif
