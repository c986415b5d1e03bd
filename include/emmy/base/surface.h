#ifndef emmy_base_surface_h
#define emmy_base_surface_h

#include <deal.II/base/point.h>

#include <array>
#include <vector>

namespace emmy
{
  /** A surface to be shown: lines in the plane, triangles in space. */
  template <int dim>
  struct Surface
  {
    std::vector<std::array<dealii::Point<dim>, dim>> facets; ///< m
  };
} // namespace emmy

#endif
