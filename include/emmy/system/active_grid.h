#ifndef emmy_system_active_grid_h
#define emmy_system_active_grid_h

#include <deal.II/base/index_set.h>

#include <deal.II/base/partitioner.h>

#include <emmy/base/linear_algebra.h>
#include <emmy/grid/boundary_conditions.h>
#include <emmy/particles/stencils.h>
#include <emmy/system/constraints.h>
#include <emmy/system/couplings.h>
#include <emmy/system/node_graph.h>
#include <emmy/system/node_places.h>

#include <vector>

namespace emmy
{
  /**
   * The part of the grid that particles touch, and the equations on it: the
   * nodes of active cells, numbered without gaps over all ranks; the unknown
   * of component c of node n is dim n + c. All other nodes carry no equation.
   * Where bodies have velocity fields of their own, a node of the grid is a
   * node here for each field that has particles around it; what is said of
   * nodes by their ids in the grid says so, see VelocityFields.
   *
   * Arrays over nodes are local to the rank: first the active nodes that it
   * owns, in the order of their numbers, then those of its active cells, and
   * of the masters of their nodes, that another rank owns.
   *
   * Made by the transfer when the groups of nodes or the active cells change,
   * kept otherwise; what matrices look like is kept as long as the same nodes
   * meet. Cost: proportional to the rank's part of the grid's window.
   */
  template <int dim>
  class ActiveGrid
  {
  public:
    /** Whether there will be matrices on this grid. */
    enum class Matrices
    {
      wanted,
      none ///< no graph() is made
    };

    /**
     * Collective.
     * @param couplings nodes that meet, and nodes that follow others
     * @param before    the one that this follows; null: none
     */
    ActiveGrid(const Stencils<dim>           &stencils,
               const Couplings<dim>          &couplings,
               const BackgroundGrid<dim>     &grid,
               const BoundaryConditions<dim> &boundary_conditions,
               const Matrices                 matrices = Matrices::wanted,
               const ActiveGrid *const        before   = nullptr);

    /**
     * Whether these stencils have the same groups of nodes, and the couplings
     * are the same, so that numbering, constraints and sparsity can stay.
     * Collective.
     */
    bool
    fits(const Stencils<dim> &stencils, const Couplings<dim> &couplings) const;

    /** Local indices of a group's nodes. */
    const unsigned int *
    nodes(const typename Stencils<dim>::Group &group) const
    {
      return group_nodes.data() + group.first_node;
    }

    /** Local indices of Couplings::node_ids, from one of them on. */
    const unsigned int *
    coupled_nodes(const std::size_t first) const
    {
      return local_coupled_nodes.data() + first;
    }

    /** That this rank's cells touch. */
    unsigned int
    n_local_nodes() const
    {
      return node_numbers.size();
    }
    /** Whose equations this rank has. */
    unsigned int
    n_owned_nodes() const
    {
      return node_partition->locally_owned_size();
    }
    /** Over all ranks. */
    dealii::types::global_dof_index
    n_dofs() const
    {
      return owned_dofs.size();
    }

    /** The number of the first unknown of a local node. */
    dealii::types::global_dof_index
    first_dof(const unsigned int local_node) const
    {
      return dim * node_numbers[local_node];
    }

    /** m. */
    const dealii::Point<dim> &
    position(const unsigned int local_node) const
    {
      return node_positions[local_node];
    }

    /** A vector of unknowns, zero. No rank waits for another. */
    Vector
    make_vector() const;

    /** The values of a vector at the local nodes: [dim * node + c]. Collective.
     */
    std::vector<double>
    to_local(const Vector &vector) const;

    /** Add an array over local nodes to a vector of unknowns. Collective. */
    void
    add(const std::vector<double> &local, Vector &vector) const;

    /**
     * Sum scalar arrays over local nodes over the ranks that share them;
     * only the entries of owned nodes are complete afterwards. Collective.
     */
    void
    sum_over_ranks(std::vector<double> &local) const;

    /**
     * Sum an array over local nodes, [node] or [dim * node + c], over the
     * ranks that share them; all entries are complete afterwards. Collective.
     */
    void
    share(std::vector<double> &local) const;

    /**
     * A vector of the unknowns of another grid over the same cells, on those
     * of this one; where a node was not active, the values of @p otherwise.
     * Collective.
     */
    Vector
    carried_over(const ActiveGrid &from,
                 const Vector     &vector,
                 const Vector     &otherwise) const;

    /** The owned entries of such an array as a vector of unknowns. */
    Vector
    to_vector(const std::vector<double> &local) const;

    /** For the coarse level of linear solvers. */
    const NodePlaces &
    places() const
    {
      return node_places;
    }

    /** Of all ranks. */
    MPI_Comm
    communicator() const;

    /** Of the background grid, m. */
    double
    shortest_side() const;

    /** Of this rank. */
    const dealii::IndexSet &
    dofs() const
    {
      return owned_dofs;
    }
    /** Essential conditions, and nodes that follow others. */
    const Constraints &
    constraints() const
    {
      return conditions;
    }

    /** Adds to matrices on this grid. */
    const NodeGraph<dim> &
    graph() const
    {
      return node_graph;
    }
    /** The active cells of this rank and the local indices of their nodes. */
    const std::vector<ActiveCell<dim>> &
    cells() const
    {
      return active_cells;
    }
    /** Local numbers of a cell's nodes. */
    const std::array<unsigned int, BackgroundGrid<dim>::nodes_per_cell> &
    cell_nodes(const unsigned int cell) const
    {
      return nodes_of_cell[cell];
    }

  private:
    unsigned int
    local_index(const dealii::types::global_dof_index grid_id) const;
    void
    number_nodes(const Stencils<dim> &stencils);
    /** Essential conditions win: a fixed component does not follow. */
    void
    make_constraints(const BoundaryConditions<dim> &boundary_conditions);
    void
    make_graph(const Stencils<dim> &stencils, const ActiveGrid *const before);

    const BackgroundGrid<dim> &grid;
    /** Of the window for which this was made. */
    std::shared_ptr<const dealii::Utilities::MPI::Partitioner> grid_nodes;
    std::vector<ActiveCell<dim>>                               active_cells;
    std::vector<std::array<unsigned int, BackgroundGrid<dim>::nodes_per_cell>>
      nodes_of_cell;

    /** Grid ids of the local nodes and their local indices, sorted. */
    std::vector<std::pair<dealii::types::global_dof_index, unsigned int>>
                                                 local_index_of;
    std::vector<dealii::types::global_dof_index> node_numbers;
    std::vector<dealii::Point<dim>>              node_positions;
    /** The stencils' node_ids and the same as local indices. */
    std::vector<dealii::types::global_dof_index> group_node_ids;
    std::vector<unsigned int>                    group_nodes;
    Couplings<dim>                               couplings;
    std::vector<unsigned int>                    local_coupled_nodes;

    std::shared_ptr<const dealii::Utilities::MPI::Partitioner> node_partition,
      dof_partition;
    dealii::IndexSet owned_dofs;
    Constraints      conditions;
    NodeGraph<dim>   node_graph;
    /** What make_vector() copies. */
    Vector     zero;
    NodePlaces node_places;
  };
} // namespace emmy

#endif
