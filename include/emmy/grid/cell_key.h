#ifndef emmy_grid_cell_key_h
#define emmy_grid_cell_key_h

#include <array>

namespace emmy
{
  /**
   * Which cell of the grid, counted per direction from the lower corner; of a
   * node: the cell above it. That it counts is known in the grid only: to all
   * others it is a key, which sorts.
   */
  template <int dim>
  using CellKey = std::array<unsigned int, dim>;

  /** The cell that is so many cells further in each direction. */
  template <int dim>
  CellKey<dim>
  further(const CellKey<dim>                  &key,
          const std::array<unsigned int, dim> &n_cells);

  /**
   * The key of a cell's node, in deal.II's vertex order.
   * @param span here and below: of a block of so many cells in each direction,
   *   whose lowest is the cell given
   */
  template <int dim>
  CellKey<dim>
  node_of(const CellKey<dim> &cell,
          const unsigned int  vertex,
          const unsigned int  span = 1);

  /** How many layers of cells a node is away from a cell; 0: it has it. */
  template <int dim>
  unsigned int
  layers_between(const CellKey<dim> &node,
                 const CellKey<dim> &cell,
                 const unsigned int  span = 1);

  /**
   * The values at a node, near or far, of the bi- or trilinear polynomials of a
   * cell that are one at one of its nodes: whole numbers, of a block whole
   * parts.
   */
  template <int dim>
  std::array<double, (1 << dim)>
  continued(const CellKey<dim> &cell,
            const CellKey<dim> &node,
            const unsigned int  span = 1);

  /**
   * The block of cells that a cell is in, by its lowest; blocks are counted
   * from the lower corner of the grid.
   */
  template <int dim>
  CellKey<dim>
  block_of(const CellKey<dim> &cell, const unsigned int span);
} // namespace emmy

#endif
