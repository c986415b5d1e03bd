#ifndef emmy_system_active_cells_h
#define emmy_system_active_cells_h

#include <deal.II/grid/grid_tools.h>

#include <emmy/particles/stencils.h>

#include <set>
#include <utility>

namespace emmy
{
  /** A cell as the particles of one body see it. */
  template <int dim>
  using CellOfBody = std::pair<unsigned int, CellKey<dim>>;

  /**
   * The active cells that this rank owns, whoever's particles make them so;
   * one entry for each body that overlaps a cell. Collective.
   */
  template <int dim>
  std::set<CellOfBody<dim>>
  owned_active_cells(const Stencils<dim>       &stencils,
                     const BackgroundGrid<dim> &grid);

  /**
   * Tell the ranks beside this one of its cells, active or not. Collective.
   *
   * @param get Data(key), of a cell that this rank owns
   * @param set called as set(key, Data) for the cells beside them
   */
  template <class Data, int dim, class Get, class Set>
  void
  exchange_beside(const BackgroundGrid<dim> &grid,
                  const Get                 &get,
                  const Set                 &set)
  {
    if (dealii::Utilities::MPI::n_mpi_processes(grid.communicator()) == 1)
      return;
    using Cell = typename BackgroundGrid<dim>::Cell;
    dealii::GridTools::exchange_cell_data_to_ghosts<Data>(
      grid.triangulation(),
      [&](const Cell &cell) { return get(grid.key_of(cell)); },
      [&](const Cell &cell, const Data &data) {
        set(grid.key_of(cell), data);
      });
  }
} // namespace emmy

#endif
