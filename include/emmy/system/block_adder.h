#ifndef emmy_system_block_adder_h
#define emmy_system_block_adder_h

#include <emmy/system/clique_places.h>
#include <emmy/system/node_graph.h>

#include <vector>

namespace emmy
{
  /**
   * Adds small matrices of nodes to a matrix of a NodeGraph, C^T block C:
   * followers hand over to their roots, and the equation of an unknown with a
   * condition has its diagonal alone.
   *
   * Owned by NodeGraph. Cost: each entry is read and written once. A row of a
   * block is copied only where its nodes have conditions, or its numbers do
   * not stand node after node.
   */
  template <int dim>
  class BlockAdder
  {
  public:
    /** To matrices of a graph; borrowed. @param before of a graph that will be
     * much the same; null: none */
    BlockAdder(const NodeGraph<dim> &graph, const BlockAdder *before)
      : graph(graph)
      , clique_places(graph, before ? &before->clique_places : nullptr)
    {}

    /** Before the first block of a matrix. */
    void
    begin()
    {
      clique_places.begin();
    }
    /** See NodeGraph. */
    void
    add(const unsigned int    *nodes,
        const ComponentBlocks &blocks,
        Matrix                &matrix);
    /** The same matrix to each component, of nodes without a condition. */
    void
    add_components(const unsigned int               *nodes,
                   const dealii::FullMatrix<double> &nodal,
                   Matrix                           &matrix);

  private:
    using Place = typename CliquePlaces<dim>::Place;

    /** What a column of a row hands to another: a follower to its root. */
    struct Share
    {
      unsigned int from, to;
      double       weight;
    };

    void
    set_nodes(const unsigned int *nodes, const unsigned int n);
    void
    add_roots(const unsigned int n_nodes);
    void
    find_places(Matrix &matrix);
    /** Row i of node a, node by node. Valid until the next call. */
    const double *
    row_of(const ComponentBlocks &blocks,
           const unsigned int     a,
           const unsigned int     i);
    /** To row i of one of the nodes. */
    void
    add_row(const unsigned int a,
            const unsigned int i,
            const double      *values,
            Matrix            &matrix) const;

    const NodeGraph<dim> &graph;
    CliquePlaces<dim>     clique_places;

    // of a call
    std::vector<unsigned int> with_roots; ///< the nodes, and roots behind them
    const Place              *places = nullptr;
    std::vector<Share>        shares;
    std::vector<unsigned int> bound; ///< columns with a condition
    std::vector<double>       row, share_of_row;
  };
} // namespace emmy

#endif
