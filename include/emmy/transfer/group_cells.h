#ifndef emmy_transfer_group_cells_h
#define emmy_transfer_group_cells_h

#include <emmy/particles/stencils.h>

namespace emmy
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
    const Lattice first = grid.lattice(grid.node_position(ids[0]) + half_cell);
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
} // namespace emmy

#endif
