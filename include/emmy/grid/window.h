#ifndef emmy_grid_window_h
#define emmy_grid_window_h

#include <deal.II/base/mpi.h>

#include <emmy/grid/cell_key.h>

#include <vector>

namespace emmy
{
  /**
   * The part of the grid that has cells: blocks of 2^level cells per
   * direction, each a coarse cell (p4est tree) that is refined level times.
   * The rest of the grid is only a lattice and costs nothing. Blocks at the
   * upper sides may stick out; their cells outside are never used.
   *
   * All ranks hold the same blocks. There are at most about most_blocks of
   * them, whatever the size of the bodies: larger windows have larger blocks.
   * Only in thin grids there may be more: no block is more than twice as wide
   * as the grid's least number of cells.
   */
  template <int dim>
  class Window
  {
  public:
    using Place = CellKey<dim>; ///< on the lattice of blocks

    /** Blocks of a window around bodies have at least 2^this cells. */
    static constexpr unsigned int least_level = 2;
    /** Above it blocks get larger. */
    static constexpr unsigned int most_blocks = 2000;

    /** No cell at all. */
    Window() = default;

    /** The whole grid, in the largest blocks that fit without sticking out. */
    static Window
    whole(const std::vector<unsigned int> &n_cells);

    /**
     * The blocks of these cells of all ranks, and the blocks beside them; the
     * whole grid if that is more than half of it. At least one block.
     * Collective.
     */
    static Window
    around(const std::vector<Place>        &cells,
           const std::vector<unsigned int> &n_cells,
           const MPI_Comm                   communicator);

    /** Whether a cell of the grid and all cells around it are there. */
    bool
    has_surroundings_of(const Place &cell) const;

    /** How often a block is refined: it has 2^level cells per direction. */
    unsigned int
    level() const
    {
      return refinements;
    }

    /** Places of the blocks, in units of blocks; sorted. */
    const std::vector<Place> &
    blocks() const
    {
      return places;
    }

  private:
    std::vector<unsigned int> n_cells;
    unsigned int              refinements = 0;
    std::vector<Place>        places;
  };
} // namespace emmy

#endif
