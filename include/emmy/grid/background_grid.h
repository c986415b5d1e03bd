#ifndef emmy_grid_background_grid_h
#define emmy_grid_background_grid_h

#include <deal.II/base/partitioner.h>
#include <emmy/base/section.h>

#include <emmy/grid/window.h>

#include <deal.II/distributed/tria.h>

#include <deal.II/dofs/dof_handler.h>

#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/mapping_cartesian.h>

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace emmy
{
  /** Section `Grid`. */
  template <int dim>
  class GridParameters : public Section
  {
  public:
    dealii::Point<dim>        lower_corner; // m
    dealii::Point<dim>        upper_corner; // m; must be above lower_corner
    std::vector<unsigned int> cells = std::vector<unsigned int>(dim, 0);

    explicit GridParameters(const std::string &section = "Grid");

    /** Throws ExcParameter for an empty grid or cells that do not fit. */
    void
    validate() const;
  };

  /**
   * The background grid: a box of equal cells that never deforms, distributed
   * over the ranks, with one scalar bi- or trilinear function per node. Where
   * no body is near there are no cells, only the lattice: cells exist in the
   * window() alone. Positions come from the lattice, so nothing depends on
   * which window is open.
   *
   * Owned by the scene. The lattice never changes; the window is chosen by
   * cover(), at the start and when particles come near its edge.
   */
  template <int dim>
  class BackgroundGrid
  {
  public:
    using Cell = typename dealii::Triangulation<dim>::active_cell_iterator;

    static constexpr unsigned int nodes_per_cell = 1 << dim;

    /** Which cell of the grid, counted per direction from the lower corner. */
    using Lattice = LatticePlace<dim>;

    /** A cell that holds points, and how many. */
    using Occupied = std::pair<Lattice, unsigned int>;

    /** What has cells after construction: all of the grid, or nothing yet. */
    enum class Cells
    {
      all,
      none
    };

    BackgroundGrid(const GridParameters<dim> &parameters,
                   const MPI_Comm             communicator,
                   const Cells                at_start = Cells::all);

    MPI_Comm
    communicator() const;

    const dealii::Triangulation<dim> &
    triangulation() const;

    /**
     * Choose the window that holds these cells with a margin (see
     * Window::around()), and distribute its cells over the ranks: a point
     * counts as much as an empty cell. Cells and ids of nodes that were
     * obtained before are no longer valid. Collective.
     *
     * @param occupied each on any one rank, also in parts
     */
    void
    cover(const std::vector<Occupied> &occupied);

    /** The part of the grid that has cells. */
    const Window<dim> &
    window() const;

    const dealii::Mapping<dim> &
    mapping() const;

    /** Lower and upper corner, m. */
    const dealii::Point<dim> &
    lower_corner() const;
    const dealii::Point<dim> &
    upper_corner() const;

    /** Cells per direction. */
    const std::vector<unsigned int> &
    n_cells() const;

    /** Cell sizes h_i, m. */
    const dealii::Tensor<1, dim> &
    cell_size() const;

    double
    smallest_cell_size() const;

    /** Number of coarse cells (p4est trees) of the window. */
    unsigned int
    n_trees() const;

    /** The cell of a position; of the nearest one if it is outside. */
    Lattice
    lattice(const dealii::Point<dim> &position) const;

    /** The place of a cell; of one that sticks out too. */
    Lattice
    lattice(const Cell &cell) const;

    /**
     * Position of the lower corner of a cell, m; the same as that of the
     * other cells' corners there, to the last bit.
     */
    dealii::Point<dim>
    corner(const Lattice &lattice) const;

    /**
     * A cell that this rank owns or knows as a neighbour of its own; past the
     * end of the triangulation if it is neither. Cost: a binary search.
     */
    Cell
    cell_at(const Lattice &lattice) const;

    /** The cells that this rank owns, sorted by their places. */
    std::vector<Cell>
    owned_cells() const;

    /** Ranks that may own a cell of the window; its owner is one of them. */
    std::vector<unsigned int>
    possible_owners(const Lattice &lattice) const;

    /** Ids of the nodes of a cell, in deal.II's vertex order. */
    std::array<dealii::types::global_dof_index, nodes_per_cell>
    node_ids(const Cell &cell) const;

    /** The place of a node that this rank knows: of the cell above it. */
    const Lattice &
    node_lattice(const dealii::types::global_dof_index id) const;

    /** Position of a node that this rank knows, m. */
    dealii::Point<dim>
    node_position(const dealii::types::global_dof_index id) const;

    /** Which nodes this rank owns and which it knows. */
    const std::shared_ptr<const dealii::Utilities::MPI::Partitioner> &
    nodes() const;

    /** Whether a position is in a closed cell, exactly. */
    bool
    is_in_cell(const Lattice            &lattice,
               const dealii::Point<dim> &position) const;

    /** Whether a position is in the closed box, to round-off (1e-13). */
    bool
    contains(const dealii::Point<dim> &position) const;

    /** The nearest position in the box; another one only by round-off. */
    dealii::Point<dim>
    clamped(const dealii::Point<dim> &position) const;

  private:
    void
    make_cells();
    void
    find_cells();
    void
    repartition(const std::vector<Occupied> &occupied);
    void
    number_nodes();
    /** Sorts as places do. */
    std::uint64_t
    number_of(const Lattice &lattice) const;

    const dealii::Point<dim>                                   lower, upper;
    const std::vector<unsigned int>                            counts;
    dealii::Tensor<1, dim>                                     h;
    Window<dim>                                                part;
    dealii::parallel::distributed::Triangulation<dim>          cells;
    dealii::MappingCartesian<dim>                              cartesian;
    dealii::FE_Q<dim>                                          element;
    dealii::DoFHandler<dim>                                    numbering;
    std::shared_ptr<const dealii::Utilities::MPI::Partitioner> node_partition;
    std::vector<Lattice> node_lattices; // by local index
    /** Owned and neighbouring cells by number_of(), sorted. */
    std::vector<std::pair<std::uint64_t, Cell>> cells_by_number;
    /** First and last place of the cells of each rank. */
    std::vector<std::pair<Lattice, Lattice>> boxes_of_ranks;
  };
} // namespace emmy

#endif
