#ifndef emmy_particles_basic_shapes_h
#define emmy_particles_basic_shapes_h

#include <emmy/particles/shape.h>

#include <string>
#include <vector>

/** Shapes that are made of numbers. All lengths in m. */
namespace emmy
{
  /** The bounding box of a shape that has no end. */
  template <int dim>
  dealii::BoundingBox<dim>
  everywhere();

  /** Whether a bounding box is not that one. */
  template <int dim>
  bool
  is_bounded(const dealii::BoundingBox<dim> &box);

  /** Axis-parallel. */
  template <int dim>
  std::unique_ptr<Shape<dim>>
  make_box(const dealii::Point<dim> &lower, const dealii::Point<dim> &upper);

  /** In plane strain a disc. */
  template <int dim>
  std::unique_ptr<Shape<dim>>
  make_ball(const dealii::Point<dim> &center, const double radius);

  /** What lies below a plane. @param normal out of the shape, of any length */
  template <int dim>
  std::unique_ptr<Shape<dim>>
  make_half_space(const dealii::Point<dim>     &point,
                  const dealii::Tensor<1, dim> &normal);

  /** A cone cut at its top, round its axis; with equal radii a cylinder. */
  std::unique_ptr<Shape<3>>
  make_cone(const dealii::Point<3> &base,
            const dealii::Point<3> &top,
            const double            base_radius,
            const double            top_radius);

  /**
   * @param corners in either direction of turn
   * @return null if edges cross or meet. Cost of contains(): the edges.
   */
  std::unique_ptr<Shape<2>>
  make_polygon(const std::vector<dealii::Point<2>> &corners);

  /**
   * Where a formula is positive, inside a box. Throws ExcParameter for
   * @p section and @p entry if it cannot be read.
   */
  template <int dim>
  std::unique_ptr<Shape<dim>>
  make_expression(const std::string              &section,
                  const std::string              &entry,
                  const std::string              &text,
                  const dealii::BoundingBox<dim> &box);
} // namespace emmy

#endif
