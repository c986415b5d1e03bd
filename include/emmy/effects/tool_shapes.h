#ifndef emmy_effects_tool_shapes_h
#define emmy_effects_tool_shapes_h

#include <deal.II/base/tensor.h>

#include <emmy/base/library.h>
#include <emmy/base/section.h>

#include <memory>

namespace emmy
{
  /** A signed distance from a surface, positive outside, and its derivatives.
   */
  template <int dim>
  struct SurfaceDistance
  {
    double                 value;     ///< phi, m
    dealii::Tensor<1, dim> normal;    ///< grad phi, of length 1
    dealii::Tensor<2, dim> curvature; ///< grad grad phi, 1/m
  };

  /** The surface of a rigid tool, in a frame that moves along with it. */
  template <int dim>
  class ToolShape
  {
  public:
    virtual ~ToolShape() = default;

    /** @param r from the tool's reference point, along its own axes, m */
    virtual SurfaceDistance<dim>
    distance(const dealii::Tensor<1, dim> &r) const = 0;

    /** What that is at least, where it costs less. */
    virtual double
    least_distance(const dealii::Tensor<1, dim> &r) const
    {
      return distance(r).value;
    }
  };

  /** A half-space below a plane through the reference point. */
  template <int dim>
  class Plane : public ToolShape<dim>
  {
  public:
    /** @param normal out of the tool, of length 1 */
    explicit Plane(const dealii::Tensor<1, dim> &normal)
      : normal(normal)
    {}

    SurfaceDistance<dim>
    distance(const dealii::Tensor<1, dim> &r) const override
    {
      return {normal * r, normal, dealii::Tensor<2, dim>()};
    }

  private:
    const dealii::Tensor<1, dim> normal;
  };

  /** The section of a tool's shape, e.g. "Effects/Tools/plate/plane". */
  template <int dim>
  class ToolShapeParameters : public Section
  {
  public:
    using Section::Section;

    /** Check and build. Throws ExcParameter. */
    virtual std::unique_ptr<ToolShape<dim>>
    make() const = 0;
  };

  /**
   * All shapes of tools: plane, ball, box with rounded edges, cone with a
   * rounded tip; cylinder and mesh (3D).
   */
  template <int dim>
  Library<ToolShapeParameters<dim>> &
  tool_shape_library();
} // namespace emmy

#endif
