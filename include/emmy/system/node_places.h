#ifndef emmy_system_node_places_h
#define emmy_system_node_places_h

#include <emmy/base/linear_algebra.h>

namespace emmy
{
  /** Where the nodes are to which the rows of a matrix belong. */
  struct NodePlaces
  {
    /** Of each row's node, in the direction of the row's component, m. */
    Vector coordinates;
    double cell_size = 0.; ///< m
  };
} // namespace emmy

#endif
