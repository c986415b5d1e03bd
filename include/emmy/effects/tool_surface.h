#ifndef emmy_effects_tool_surface_h
#define emmy_effects_tool_surface_h

#include <emmy/base/surface.h>
#include <emmy/effects/tool_shapes.h>

namespace emmy
{
  /**
   * Where a tool's surface is within a box: the zeros of the
   * signed distance, found by deal.II's marching cubes on a lattice of the
   * box. So all shapes are drawn alike, and a plane ends where the box does.
   * What is smaller than the box by more than the number of cells along its
   * longest side, 200 in the plane and 40 in space, is not seen.
   *
   * Cost: a distance at each node of the lattice.
   *
   * @param place,directions of the tool, as ToolMotion gives them
   */
  template <int dim>
  Surface<dim>
  surface_of(const ToolShape<dim>         &shape,
             const dealii::Point<dim>     &place,
             const dealii::Tensor<2, dim> &directions,
             const dealii::Point<dim>     &lower,
             const dealii::Point<dim>     &upper);
} // namespace emmy

#endif
