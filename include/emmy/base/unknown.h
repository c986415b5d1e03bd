#ifndef emmy_base_unknown_h
#define emmy_base_unknown_h

namespace emmy
{
  /**
   * Where a component of the velocity of a local node stands in arrays over the
   * local nodes, and among the unknowns of a rank. Local nodes are those of one
   * velocity field; where there are several, a node of the grid has one local
   * node in each: see ActiveGrid.
   */
  template <int dim>
  constexpr unsigned int
  unknown(const unsigned int node, const unsigned int component)
  {
    return dim * node + component;
  }
} // namespace emmy

#endif
