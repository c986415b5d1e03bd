#include <emmy/transfer/active_cells.h>

#include <map>
#include <vector>

namespace emmy
{
  namespace
  {
    /** Call function(Lattice) for all cells that a group of points overlaps. */
    template <int dim, class Function>
    void
    for_each_cell(const Stencils<dim>                 &stencils,
                  const typename Stencils<dim>::Group &group,
                  const BackgroundGrid<dim>           &grid,
                  const Function                      &function)
    {
      using Lattice = typename BackgroundGrid<dim>::Lattice;
      // the nodes of a group are those of a box of cells, corner to corner
      const dealii::Tensor<1, dim> half_cell = 0.5 * grid.cell_size();
      const auto                  *ids = &stencils.node_ids[group.first_node];
      const Lattice                first =
        grid.lattice(grid.node_position(ids[0]) + half_cell);
      const Lattice last =
        grid.lattice(grid.node_position(ids[group.n_nodes - 1]) - half_cell);
      Lattice cell = first;
      for (unsigned int d = 0; d < dim;)
        {
          function(cell);
          for (d = 0; d < dim && ++cell[d] > last[d]; ++d)
            cell[d] = first[d];
        }
    }
  } // namespace

  template <int dim>
  std::set<CellOfBody<dim>>
  owned_active_cells(const Stencils<dim>       &stencils,
                     const BackgroundGrid<dim> &grid)
  {
    std::set<CellOfBody<dim>> found, owned;
    for (const auto &group : stencils.groups)
      for_each_cell(stencils, group, grid, [&](const auto &cell) {
        found.insert({group.body, cell});
      });
    std::map<unsigned int, std::vector<CellOfBody<dim>>> of_others;
    for (const auto &entry : found)
      {
        const auto cell = grid.cell_at(entry.second);
        if (cell->is_locally_owned())
          owned.insert(entry);
        else
          of_others[cell->subdomain_id()].push_back(entry);
      }
    for (const auto &[sender, entries] :
         dealii::Utilities::MPI::some_to_some(grid.communicator(), of_others))
      {
        (void)sender;
        owned.insert(entries.begin(), entries.end());
      }
    return owned;
  }

  template std::set<CellOfBody<2>>
  owned_active_cells<2>(const Stencils<2> &, const BackgroundGrid<2> &);
  template std::set<CellOfBody<3>>
  owned_active_cells<3>(const Stencils<3> &, const BackgroundGrid<3> &);
} // namespace emmy
