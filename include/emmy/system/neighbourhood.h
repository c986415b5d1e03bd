#ifndef emmy_system_neighbourhood_h
#define emmy_system_neighbourhood_h

#include <emmy/system/active_grid.h>

namespace emmy
{
  /**
   * The nodes of groups that follow each other and begin in the same cell.
   * With GIMP a group has few particles, of the size of a quarter of a cell
   * one; but all that begin in a cell reach no more than the 3^dim nodes from
   * there, and a small matrix of these goes into a large one at once. With
   * linear functions it is the cell.
   *
   * Where many bodies with velocity fields of their own meet, it ends behind
   * some 200 nodes.
   *
   * The order of the nodes is that in which groups reach them: first those of
   * the cell, which all groups do. Cost: an array over the local nodes, and a
   * number for each node of each group.
   */
  template <int dim>
  class Neighbourhood
  {
  public:
    using Group = typename Stencils<dim>::Group; ///< of a step

    /** None yet; borrows both. */
    Neighbourhood(const Stencils<dim> &stencils, const ActiveGrid<dim> &active);

    /** Begin with a group of the stencils, and go as far as it reaches. */
    void
    begin(const Group &group);

    /** Whether a group, not before the first of them, is one of these. */
    bool
    has(const Group &group) const
    {
      return &group < last;
    }
    /** The group behind them. */
    const Group *
    end() const
    {
      return last;
    }

    /** Local indices. */
    const std::vector<unsigned int> &
    nodes() const
    {
      return members;
    }
    /** Where the nodes of one of the groups stand in nodes(). */
    const unsigned int *
    places(const Group &group) const
    {
      return indices.data() + (group.first_node - first->first_node);
    }

  private:
    /** With a group more, at most 256. */
    static constexpr unsigned int enough_nodes = 192;

    const Stencils<dim>      &stencils;
    const ActiveGrid<dim>    &active;
    const Group              *first = nullptr, *last = nullptr;
    std::vector<unsigned int> members;
    /** Of each local node: its index among the members, or none. */
    std::vector<unsigned int> index_of;
    /** Of the nodes of all groups, one group after the other. */
    std::vector<unsigned int> indices;
  };
} // namespace emmy

#endif
