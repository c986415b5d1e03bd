#ifndef emmy_system_clique_places_h
#define emmy_system_clique_places_h

#include <cstddef>
#include <vector>

namespace emmy
{
  template <int dim>
  class NodeGraph;

  /**
   * Where some nodes stand in each other's rows in matrices of a NodeGraph.
   * Small matrices come in the same order in each evaluation: what was found
   * in the last one is taken where the nodes are the same.
   *
   * Owned by BlockAdder. Cost: to find, the rows of all the nodes; to keep, two
   * bytes for each pair of nodes and 32 for each call of a sweep.
   */
  template <int dim>
  class CliquePlaces
  {
  public:
    /** In a row, in nodes. */
    using Place = unsigned short;
    /** Of nodes that do not meet. */
    static constexpr Place none = -1;

    /** Of a graph; borrowed. @param before as many as another one are
     * expected; null: unknown */
    CliquePlaces(const NodeGraph<dim> &graph, const CliquePlaces *before);

    /** From now on the first nodes are those of the last time. */
    void
    begin()
    {
      next = 0;
    }

    /** Places of the nodes in the row of the first, in that of the second, and
     * so on. Valid until the next call. */
    const Place *
    find(const std::vector<unsigned int> &nodes);

  private:
    /** Of some nodes: from where on they and their places stand. */
    struct Kept
    {
      std::size_t nodes, places;
    };
    std::size_t
    n_nodes(const std::size_t i) const;
    void
    find_row(const unsigned int               row,
             const std::vector<unsigned int> &nodes,
             Place                           *places);

    const NodeGraph<dim>     &graph;
    std::vector<Kept>         kept;
    std::vector<unsigned int> nodes_of_kept;
    std::vector<Place>        places_of_kept;
    std::size_t               next = 0; ///< of these

    /** By local node: a row, and where the node stands there. */
    struct Mark
    {
      unsigned int row, place;
    };
    std::vector<Mark> marks;
  };
} // namespace emmy

#endif
