#ifndef emmy_grid_background_grid_h
#define emmy_grid_background_grid_h

#include <deal.II/base/partitioner.h>
#include <emmy/base/section.h>

#include <deal.II/distributed/tria.h>

#include <deal.II/dofs/dof_handler.h>

#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/mapping_cartesian.h>

#include <array>
#include <functional>
#include <memory>
#include <string>
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
   * over the ranks, with one scalar bi- or trilinear function per node. A few
   * coarse cells are refined as often as the numbers of cells allow, because
   * a p4est forest of one tree per cell does not scale.
   *
   * Owned by the scene. Nothing here changes after construction, except the
   * partition, when the scene rebalances it.
   */
  template <int dim>
  class BackgroundGrid
  {
  public:
    using Cell = typename dealii::Triangulation<dim>::active_cell_iterator;

    static constexpr unsigned int nodes_per_cell = 1 << dim;

    /** Which cell of the grid, counted per direction from the lower corner. */
    using Lattice = std::array<unsigned int, dim>;

    BackgroundGrid(const GridParameters<dim> &parameters,
                   const MPI_Comm             communicator);

    MPI_Comm
    communicator() const;

    const dealii::Triangulation<dim> &
    triangulation() const;

    /**
     * Distribute the cells over the ranks so that each has about the same sum
     * of weights. Collective. Call it before anything refers to cells.
     *
     * @param weight relative cost of a cell, at least 1
     */
    void
    repartition(const std::function<unsigned int(const Cell &)> &weight);

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

    /** Number of coarse cells (p4est trees). */
    unsigned int
    n_trees() const;

    /** The cell of a position; of the nearest one if it is outside. */
    Lattice
    lattice(const dealii::Point<dim> &position) const;

    /**
     * A cell that this rank owns or knows as a neighbour of its own; past the
     * end of the triangulation if it is neither. Cost: a binary search.
     */
    Cell
    cell_at(const Lattice &lattice) const;

    /** Ids of the nodes of a cell, in deal.II's vertex order. */
    std::array<dealii::types::global_dof_index, nodes_per_cell>
    node_ids(const Cell &cell) const;

    /** Position of a node that this rank knows, m. */
    const dealii::Point<dim> &
    node_position(const dealii::types::global_dof_index id) const;

    /** Which nodes this rank owns and which it knows. */
    const std::shared_ptr<const dealii::Utilities::MPI::Partitioner> &
    nodes() const;

    /** Whether a position is in the closed box, to round-off (1e-13). */
    bool
    contains(const dealii::Point<dim> &position) const;

    /** The nearest position in the box; another one only by round-off. */
    dealii::Point<dim>
    clamped(const dealii::Point<dim> &position) const;

  private:
    void
    number_nodes();
    std::uint64_t
    cell_number(const Lattice &lattice) const;

    const dealii::Point<dim>                                   lower, upper;
    const std::vector<unsigned int>                            counts;
    dealii::Tensor<1, dim>                                     h;
    unsigned int                                               trees;
    dealii::parallel::distributed::Triangulation<dim>          cells;
    dealii::MappingCartesian<dim>                              cartesian;
    dealii::FE_Q<dim>                                          element;
    dealii::DoFHandler<dim>                                    numbering;
    std::shared_ptr<const dealii::Utilities::MPI::Partitioner> node_partition;
    std::vector<dealii::Point<dim>> node_positions; // by local index
    /** Owned and neighbouring cells by cell_number(), sorted. */
    std::vector<std::pair<std::uint64_t, Cell>> cells_by_number;
  };
} // namespace emmy

#endif
