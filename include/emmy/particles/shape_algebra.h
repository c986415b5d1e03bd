#ifndef emmy_particles_shape_algebra_h
#define emmy_particles_shape_algebra_h

#include <emmy/particles/shape.h>

#include <vector>

/** Shapes that are made of shapes. */
namespace emmy
{
  template <int dim>
  using Shapes = std::vector<std::unique_ptr<Shape<dim>>>; ///< owned

  /** What lies in any of them. At least one. */
  template <int dim>
  std::unique_ptr<Shape<dim>>
  make_union(Shapes<dim> shapes);

  /** What lies in all of them. Null if their boxes do not meet. */
  template <int dim>
  std::unique_ptr<Shape<dim>>
  make_intersection(Shapes<dim> shapes);

  /** What lies in the first and in no other; a cut takes its faces away. */
  template <int dim>
  std::unique_ptr<Shape<dim>>
  make_difference(Shapes<dim> shapes);

  /**
   * The points matrix * x + shift of the points x of a shape.
   * @pre det(matrix) is not 0
   */
  template <int dim>
  std::unique_ptr<Shape<dim>>
  make_image(std::unique_ptr<Shape<dim>>   shape,
             const dealii::Tensor<2, dim> &matrix,
             const dealii::Tensor<1, dim> &shift);
} // namespace emmy

#endif
