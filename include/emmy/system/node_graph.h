#ifndef emmy_system_node_graph_h
#define emmy_system_node_graph_h

#include <deal.II/base/index_set.h>

#include <deal.II/lac/full_matrix.h>

#include <emmy/base/linear_algebra.h>
#include <emmy/system/constraints.h>
#include <emmy/system/foreign_rows.h>

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

class Epetra_CrsMatrix;

namespace emmy
{
  template <int dim>
  class BlockAdder;

  /**
   * A small matrix of the unknowns of some nodes: that of components i, j at
   * nodes a, b stands at values[i by_i + j by_j + a by_a + b by_b].
   */
  struct ComponentBlocks
  {
    const double *values;  ///< of a cell's matrix
    unsigned int  n_nodes; ///< of the cell
    /** Strides. */
    std::size_t by_i, by_j, by_a, by_b = 1;

    /** Values by b. */
    const double *
    at(const unsigned int i, const unsigned int j, const unsigned int a) const
    {
      return values + i * by_i + j * by_j + a * by_a;
    }
  };

  /**
   * Which nodes of an active grid meet in its matrices, and where their
   * entries stand. Nodes are local indices; dim unknowns follow each other at
   * a node, and all of them meet. Small matrices of nodes that meet are added
   * straight at their places, without a search.
   *
   * Owned by ActiveGrid. Cost: two numbers for each pair of nodes, and what
   * CliquePlaces keeps.
   */
  template <int dim>
  class NodeGraph
  {
  public:
    /** Nodes that all meet: [first, first + n) of an array. */
    struct Clique
    {
      const unsigned int *nodes; ///< neighbours
      unsigned int        n;     ///< how many
    };

    /** Rows of this rank. */
    unsigned int
    n_nodes() const
    {
      return first_dofs.size();
    }

    /** The nodes that a local node meets, sorted, itself among them; [first,
     * first + n) of all pairs. */
    struct Row
    {
      const unsigned int *nodes; ///< the first of them
      unsigned int        n;     ///< how many
      std::size_t         first; ///< of all pairs
    };
    /** Of a local node. */
    Row
    row(const unsigned int node) const
    {
      return {neighbours.data() + first[node],
              static_cast<unsigned int>(first[node + 1] - first[node]),
              first[node]};
    }
    /** Of all local nodes. */
    std::size_t
    n_pairs() const
    {
      return neighbours.size();
    }
    /** Where a pair's second node stands in the rows of the first, in nodes.
     */
    unsigned int
    place(const std::size_t pair) const
    {
      return places[pair];
    }
    /** The same of its component c, in entries. */
    unsigned int
    place(const std::size_t pair, const unsigned int c) const
    {
      return dim * places[pair] + c;
    }
    /** What is added to the row of a local unknown. */
    double *
    entries_of(const unsigned int unknown, Matrix &matrix) const;
    /** Whether no unknown of a local node has a condition. */
    bool
    has_no_condition(const unsigned int node) const
    {
      return is_plain[node] != 0;
    }
    /** Whether a local unknown, dim * node + c, has no condition. */
    bool
    is_free(const unsigned int unknown) const
    {
      return free_unknowns[unknown] != 0;
    }
    /**
     * Call function(unknown, weight) for those free unknowns of which a local
     * one is a sum: itself, none, or the roots of a follower that are free.
     */
    template <class Function>
    void
    for_each_root(const unsigned int unknown, const Function &function) const
    {
      if (free_unknowns[unknown])
        function(unknown, 1.);
      else if (is_following[unknown])
        for (const auto &[root, weight] : roots_of[unknown])
          if (free_unknowns[root])
            function(root, weight);
    }

    /** Whether the conditions are worked into a matrix. */
    enum class Conditions
    {
      worked_in,
      left_out
    };

    /** None. */
    NodeGraph();
    NodeGraph(const NodeGraph &) = delete;
    ~NodeGraph();

    /**
     * Make it, and the pattern of the matrices. Once. Collective.
     * @param cliques     of this rank; followers bring their roots along
     * @param first_dofs  of each local node; owned nodes come first
     * @param owned_dofs  those of this rank, without gaps
     * @param before      another one, whose pattern serves if the same nodes
     *   meet; null: none
     */
    void
    make(const std::vector<Clique>                          &cliques,
         const std::vector<dealii::types::global_dof_index> &first_dofs,
         const dealii::IndexSet                             &owned_dofs,
         const Constraints                                  &constraints,
         const MPI_Comm                                      communicator,
         const NodeGraph *const                              before = nullptr);

    /** Make a matrix on it, zero. Collective. */
    void
    reinit(Matrix &matrix) const;
    /** Set a matrix to zero. */
    void
    clear(Matrix &matrix) const;
    /**
     * After the last block of a matrix, before the first one of another: what
     * belongs to rows of other ranks goes there. Collective.
     */
    void
    finish(Matrix &matrix) const;

    /** How many entries a matrix has, over all ranks. Collective. */
    std::uint64_t
    n_nonzeros() const;

    /**
     * Add a matrix of the unknowns of some nodes that meet, with the
     * conditions worked in.
     * @param block (dim a + c, dim b + d) of unknowns c and d of the nodes a,
     *   b; zero for nodes that do not meet
     */
    void
    add(const unsigned int               *nodes,
        const dealii::FullMatrix<double> &block,
        Matrix                           &matrix) const;

    /** The same in any order. */
    void
    add(const unsigned int    *nodes,
        const ComponentBlocks &blocks,
        Matrix                &matrix) const;

    /** Add a matrix of nodes to each component of the unknowns, with the
     * conditions worked in. */
    void
    add_components(const unsigned int               *nodes,
                   const dealii::FullMatrix<double> &nodal,
                   Matrix                           &matrix) const;

  private:
    using Dofs = std::vector<dealii::types::global_dof_index>;
    /** Unknowns with weights. */
    using Roots = std::vector<std::pair<unsigned int, double>>;

    void
    note_conditions(const Constraints &constraints);
    void
    find_plain_nodes();
    void
    find_neighbours(std::vector<Clique> cliques);
    /**
     * Of the rows to which other ranks add: columns of the matrix, in nodes.
     * @param column_dofs those that no local node is are appended
     */
    std::vector<std::vector<unsigned int>>
    columns_of_others(const dealii::types::global_dof_index first_owned,
                      Dofs                                 &column_dofs) const;
    void
    make_pattern(const dealii::IndexSet &owned_dofs,
                 const MPI_Comm          communicator);

    Dofs         first_dofs;
    unsigned int n_owned = 0; ///< nodes
    /** By local unknown: whether it has no condition, and whether it follows.
     */
    std::vector<char> free_unknowns, is_following;
    /** By local node: whether no unknown has a condition. */
    std::vector<char> is_plain;
    /** By local unknown, of those that follow; without any, empty. */
    std::vector<Roots> roots_of;

    /** Neighbours of a node, sorted: from [first[node]] to [first[node + 1]].
     */
    std::vector<std::size_t>  first;
    std::vector<unsigned int> neighbours;
    /** Of each pair: where its second node stands in the rows of the first,
     * in nodes. */
    std::vector<unsigned int>               places;
    ForeignRows<dim>                        foreign;
    std::shared_ptr<const Epetra_CrsMatrix> pattern; ///< of one or more graphs
    std::unique_ptr<BlockAdder<dim>>        adder;
  };
} // namespace emmy

#endif
