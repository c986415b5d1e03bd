#include <emmy/solve/met_nodes.h>

#include <Epetra_CrsGraph.h>

#include <algorithm>

namespace emmy
{
  using dealii::types::global_dof_index;

  std::vector<global_dof_index>
  met_on_others(const Epetra_CrsGraph &graph, const unsigned int n)
  {
    const Epetra_BlockMap        &met = graph.ColMap();
    std::vector<global_dof_index> result;
    for (int j = 0; j < met.NumMyElements(); ++j)
      if (!graph.RowMap().MyGID(met.GID(j)))
        result.push_back(met.GID(j) / n);
    std::sort(result.begin(), result.end());
    result.erase(std::unique(result.begin(), result.end()), result.end());
    return result;
  }

  NodeExchange
  exchange_with_others(const Matrix                        &matrix,
                       const unsigned int                   n,
                       const std::vector<global_dof_index> &others)
  {
    dealii::IndexSet own(matrix.m() / n), beyond(matrix.m() / n);
    const auto       range = matrix.local_range();
    own.add_range(range.first / n, range.second / n);
    beyond.add_indices(others.begin(), others.end());
    return NodeExchange(dealii::Utilities::MPI::Partitioner(
      own, beyond, matrix.get_mpi_communicator()));
  }
} // namespace emmy
