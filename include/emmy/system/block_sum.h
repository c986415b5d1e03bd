#ifndef emmy_system_block_sum_h
#define emmy_system_block_sum_h

#include <emmy/system/node_graph.h>

#include <vector>

namespace emmy
{
  /**
   * Sums small matrices of nodes that are close to each other, before they are
   * added to a matrix at once. Worth it where groups of nodes overlap: with
   * GIMP every particle may have nodes of its own, and those of neighbours are
   * almost the same.
   */
  template <int dim>
  class BlockSum
  {
  public:
    /** Adds blocks of nodes to a matrix. */
    BlockSum(const NodeGraph<dim> &graph, Matrix &matrix);

    /** As NodeGraph::add(). */
    void
    add(const unsigned int *nodes, const ComponentBlocks &blocks);

    /** Hand over what is there; once after the last block. */
    void
    flush();

  private:
    /** Of the boxes of two cells' edge that particles of a cell's size reach.
     */
    static constexpr unsigned int most_nodes = dim == 2 ? 9 : 27;

    const NodeGraph<dim>     &graph;
    Matrix                   &matrix;
    std::vector<unsigned int> members;
    /** Of each local node: its index among the members, or none. */
    std::vector<unsigned int> index_of;
    std::vector<unsigned int> indices;
    /** Room for so many nodes in the sum. */
    unsigned int        room = 0;
    std::vector<double> sum; ///< [((i dim + j) room + a) room + b]
  };
} // namespace emmy

#endif
