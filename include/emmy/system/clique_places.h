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
   * bytes for each pair of nodes and some 100 for each call of a sweep.
   */
  template <int dim>
  class CliquePlaces
  {
  public:
    /** In a row, in nodes. */
    using Place = unsigned short;
    /** Of nodes that do not meet. */
    static constexpr Place none = -1;

    /** Of a graph; borrowed. */
    explicit CliquePlaces(const NodeGraph<dim> &graph);

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
    /** Of some nodes. */
    struct Kept
    {
      std::vector<unsigned int> nodes;
      std::vector<Place>        places;
    };
    void
    find_row(const unsigned int               row,
             const std::vector<unsigned int> &nodes,
             Place                           *places);

    const NodeGraph<dim> &graph;
    std::vector<Kept>     kept;
    std::size_t           next = 0; ///< of these

    /** By local node: a row, and where the node stands there. */
    struct Mark
    {
      unsigned int row, place;
    };
    std::vector<Mark> marks;
  };
} // namespace emmy

#endif
