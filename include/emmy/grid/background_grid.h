#ifndef emmy_grid_background_grid_h
#define emmy_grid_background_grid_h

#include <deal.II/base/partitioner.h>

#include <emmy/grid/grid_parameters.h>
#include <emmy/grid/velocity_fields.h>
#include <emmy/grid/window.h>

#include <deal.II/distributed/tria.h>

#include <deal.II/dofs/dof_handler.h>

#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/mapping_cartesian.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace emmy
{
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
    /** A cell of the window. */
    using Cell = typename dealii::Triangulation<dim>::active_cell_iterator;

    static constexpr unsigned int nodes_per_cell = 1 << dim; ///< corners

    /** A cell that holds points, and how many. */
    using Occupied = std::pair<CellKey<dim>, unsigned int>;

    /** What has cells after construction: all of the grid, or nothing yet. */
    enum class Cells
    {
      all,
      none
    };

    /** The grid of a parameter file, with a window around nothing yet. */
    BackgroundGrid(const GridParameters<dim> &parameters,
                   const MPI_Comm             communicator,
                   const Cells                at_start = Cells::all);

    /** Choose them, before there are cells. */
    void
    set_fields(VelocityFields chosen)
    {
      velocity_fields = std::move(chosen);
    }
    /** Which bodies share a velocity. */
    const VelocityFields &
    fields() const
    {
      return velocity_fields;
    }

    /** Of all ranks. */
    MPI_Comm
    communicator() const;

    /** deal.II's, of the window. */
    const dealii::Triangulation<dim> &
    triangulation() const
    {
      return cells;
    }

    /**
     * Choose the window that holds these cells with a margin (see
     * Window::around()), and distribute its cells over the ranks by their work:
     * see grid/cell_work.h. Cells and ids of nodes that were
     * obtained before are no longer valid. Collective.
     *
     * @param occupied each on any one rank, also in parts
     */
    void
    cover(const std::vector<Occupied> &occupied);

    /**
     * What cover() was last given on this rank. The same cells with the same
     * numbers of points, wherever they are given, make the same window, the
     * same partition and the same ids of nodes.
     */
    const std::vector<Occupied> &
    covered() const
    {
      return last_covered;
    }

    /** Those of them that this rank owns now, with all points. Collective. */
    std::vector<Occupied>
    covered_here() const;

    /** The part of the grid that has cells. */
    const Window<dim> &
    window() const
    {
      return part;
    }

    /** From the unit cell, affine. */
    const dealii::Mapping<dim> &
    mapping() const
    {
      return cartesian;
    }

    /** Lower and upper corner, m. */
    const dealii::Point<dim> &
    lower_corner() const;
    /** m. */
    const dealii::Point<dim> &
    upper_corner() const;

    /** Cells per direction. */
    const std::vector<unsigned int> &
    n_cells() const;

    /**
     * Cell sizes h_i, m: for what relies on equal cells. All others ask for
     * size_of() a cell, or size_at() a position.
     */
    const dealii::Tensor<1, dim> &
    cell_size() const
    {
      return h;
    }

    /** The sides of a cell, m. */
    const dealii::Tensor<1, dim> &
    size_of(const CellKey<dim> &) const
    {
      return h;
    }

    /** The sides of the cells at a position, m. */
    const dealii::Tensor<1, dim> &
    size_at(const dealii::Point<dim> &) const
    {
      return h;
    }

    /** The shortest of all cells, m. */
    double
    shortest_side() const;

    /** Number of coarse cells (p4est trees) of the window. */
    unsigned int
    n_trees() const;

    /** The cell of a position; of the nearest one if it is outside. */
    CellKey<dim>
    key_of(const dealii::Point<dim> &position) const;

    /** The key of a cell; of one that sticks out too. */
    CellKey<dim>
    key_of(const Cell &cell) const;

    /** The cell whose lower corner is a node, from the node's position. */
    CellKey<dim>
    key_above(const dealii::Point<dim> &node_position) const;

    /**
     * The cell beyond a face, active or not; none beyond a side of the grid.
     * @param face 2d: below in direction d, 2d + 1: above
     */
    std::optional<CellKey<dim>>
    neighbour(const CellKey<dim> &key, const unsigned int face) const;

    /** A cell and those that share a node with it, inside the grid. */
    std::vector<CellKey<dim>>
    cells_around(const CellKey<dim> &key) const;

    /** The cells that have a node, inside the grid. */
    std::vector<CellKey<dim>>
    cells_at_node(const CellKey<dim> &node) const;

    /**
     * From a node to the centre of a cell, or of a block of cells as in
     * node_of(), m; exact for equal distances.
     */
    dealii::Tensor<1, dim>
    from_node_to_center(const CellKey<dim> &node,
                        const CellKey<dim> &cell,
                        const unsigned int  span = 1) const;

    /** int N_A of a node inside the grid, m^dim. */
    double
    volume_of_node(const dealii::Point<dim> &node_position) const;

    /** A position in the unit cell of a cell, not clipped. */
    dealii::Point<dim>
    reference_position(const CellKey<dim>       &key,
                       const dealii::Point<dim> &position) const;

    /**
     * Position of the lower corner of a cell, m; the same as that of the
     * other cells' corners there, to the last bit.
     */
    dealii::Point<dim>
    corner(const CellKey<dim> &key) const;

    /**
     * A cell that this rank owns or knows as a neighbour of its own; past the
     * end of the triangulation if it is neither. Cost: a binary search.
     */
    Cell
    cell_at(const CellKey<dim> &key) const;

    /** How many cells this rank owns, those that stick out left out. */
    std::size_t
    n_owned_cells() const
    {
      return n_owned;
    }

    /** The cells that this rank owns, sorted by their places. */
    std::vector<Cell>
    owned_cells() const;

    /** Ranks that may own a cell of the window; its owner is one of them. */
    std::vector<unsigned int>
    possible_owners(const CellKey<dim> &key) const;

    /** Ids of the nodes of a cell in a field, in deal.II's vertex order. */
    std::array<dealii::types::global_dof_index, nodes_per_cell>
    node_ids(const Cell &cell, const unsigned int field = 0) const;

    /** The key of a node that this rank knows: of the cell above it. */
    const CellKey<dim> &
    node_key(const dealii::types::global_dof_index id) const;

    /** Position of a node that this rank knows, m. */
    dealii::Point<dim>
    node_position(const dealii::types::global_dof_index id) const;

    /** The ids that this rank owns and those that it knows. */
    const std::shared_ptr<const dealii::Utilities::MPI::Partitioner> &
    nodes() const;

    /** Whether a position is in a closed cell, exactly. */
    bool
    is_in_cell(const CellKey<dim>       &key,
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
    repartition();
    void
    number_nodes();
    /** Sorts as places do. */
    std::uint64_t
    number_of(const CellKey<dim> &key) const;

    const dealii::Point<dim>                                   lower, upper;
    const std::vector<unsigned int>                            counts;
    dealii::Tensor<1, dim>                                     h;
    Window<dim>                                                part;
    std::vector<Occupied>                                      last_covered;
    VelocityFields                                             velocity_fields;
    dealii::parallel::distributed::Triangulation<dim>          cells;
    dealii::MappingCartesian<dim>                              cartesian;
    dealii::FE_Q<dim>                                          element;
    dealii::DoFHandler<dim>                                    numbering;
    std::shared_ptr<const dealii::Utilities::MPI::Partitioner> node_partition;
    std::vector<CellKey<dim>> node_keys; // by local index, one field
    /** Owned and neighbouring cells by number_of(), sorted. */
    std::vector<std::pair<std::uint64_t, Cell>> cells_by_number;
    std::size_t                                 n_owned = 0;
    /** First and last place of the cells of each rank. */
    std::vector<std::pair<CellKey<dim>, CellKey<dim>>> boxes_of_ranks;
  };
} // namespace emmy

#endif
