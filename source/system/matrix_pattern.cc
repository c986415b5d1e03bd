#include <emmy/base/unknown.h>
#include <emmy/system/matrix_pattern.h>

#include <Epetra_CrsGraph.h>
#include <Epetra_CrsMatrix.h>
#include <Epetra_Map.h>

namespace emmy
{
  using dealii::types::global_dof_index;

  namespace
  {
    /** A graph that may be told that its columns are sorted. */
    struct SortedGraph : Epetra_CrsGraph
    {
      using Epetra_CrsGraph::Epetra_CrsGraph;
      using Epetra_CrsGraph::SetSorted;
    };
  } // namespace

  template <int dim>
  std::unique_ptr<const Epetra_CrsMatrix>
  matrix_pattern(const std::vector<std::vector<unsigned int>> &rows,
                 const std::vector<global_dof_index>          &column_dofs,
                 const dealii::IndexSet                       &owned_dofs,
                 const MPI_Comm                                communicator)
  {
    const Epetra_Map map = owned_dofs.make_trilinos_map(communicator);
    std::vector<int> unknowns, lengths;
    for (const global_dof_index dof : column_dofs)
      for (unsigned int c = 0; c < dim; ++c)
        unknowns.push_back(static_cast<int>(dof + c));
    const Epetra_Map column_map(
      -1, unknowns.size(), unknowns.data(), 0, map.Comm());
    for (const std::vector<unsigned int> &row : rows)
      lengths.insert(lengths.end(), dim, dim * row.size());
    // local indices: nothing is looked up, nothing sorted
    SortedGraph graph(
      Copy, map, column_map, lengths.data(), /*StaticProfile=*/true);
    std::vector<int> columns;
    for (unsigned int node = 0; node < rows.size(); ++node)
      {
        columns.clear();
        for (const unsigned int column : rows[node])
          for (unsigned int c = 0; c < dim; ++c)
            columns.push_back(unknown<dim>(column, c));
        for (unsigned int c = 0; c < dim; ++c)
          graph.InsertMyIndices(unknown<dim>(node, c),
                                columns.size(),
                                columns.data());
      }
    graph.SetSorted(true); // else a third of the time goes into sorting
    graph.FillComplete(map, map);
    graph.OptimizeStorage();
    return std::make_unique<const Epetra_CrsMatrix>(View, graph);
  }

  template std::unique_ptr<const Epetra_CrsMatrix>
  matrix_pattern<2>(const std::vector<std::vector<unsigned int>> &,
                    const std::vector<global_dof_index> &,
                    const dealii::IndexSet &,
                    const MPI_Comm);
  template std::unique_ptr<const Epetra_CrsMatrix>
  matrix_pattern<3>(const std::vector<std::vector<unsigned int>> &,
                    const std::vector<global_dof_index> &,
                    const dealii::IndexSet &,
                    const MPI_Comm);
} // namespace emmy
