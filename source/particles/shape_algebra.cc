#include <emmy/particles/basic_shapes.h>
#include <emmy/particles/shape_algebra.h>

#include <algorithm>
#include <cmath>

namespace emmy
{
  using dealii::BoundingBox;
  using dealii::Point;
  using dealii::Tensor;

  namespace
  {
    template <int dim>
    using Rule = bool (*)(const Shapes<dim> &, const Point<dim> &);

    template <int dim>
    bool
    in_any(const Shapes<dim> &shapes, const Point<dim> &position)
    {
      return std::any_of(shapes.begin(), shapes.end(), [&](const auto &shape) {
        return shape->contains(position);
      });
    }

    template <int dim>
    bool
    in_all(const Shapes<dim> &shapes, const Point<dim> &position)
    {
      return std::all_of(shapes.begin(), shapes.end(), [&](const auto &shape) {
        return shape->contains(position);
      });
    }

    template <int dim>
    bool
    in_first_alone(const Shapes<dim> &shapes, const Point<dim> &position)
    {
      return shapes.front()->contains(position) &&
             std::none_of(shapes.begin() + 1,
                          shapes.end(),
                          [&](const auto &shape) {
                            return shape->contains(position);
                          });
    }

    /** Of several shapes. It does not know its volume and centre. */
    template <int dim>
    class Composed : public Shape<dim>
    {
    public:
      Composed(Shapes<dim>             shapes,
               const Rule<dim>         rule,
               const BoundingBox<dim> &box,
               const bool              is_tight)
        : shapes(std::move(shapes))
        , rule(rule)
        , box(box)
        , is_tight(is_tight)
      {}

      bool
      contains(const Point<dim> &position) const override
      {
        return rule(shapes, position);
      }

      bool
      has_tight_box() const override
      {
        return is_tight;
      }

      BoundingBox<dim>
      bounding_box() const override
      {
        return box;
      }

    private:
      const Shapes<dim>      shapes;
      const Rule<dim>        rule;
      const BoundingBox<dim> box;
      const bool             is_tight;
    };

    template <int dim>
    class Image : public Shape<dim>
    {
    public:
      Image(std::unique_ptr<Shape<dim>> shape,
            const Tensor<2, dim>       &matrix,
            const Tensor<1, dim>       &shift)
        : shape(std::move(shape))
        , matrix(matrix)
        , inverse(invert(matrix))
        , shift(shift)
      {}

      bool
      contains(const Point<dim> &position) const override
      {
        return shape->contains(Point<dim>(inverse * (position - shift)));
      }

      double
      volume() const override
      {
        return std::abs(determinant(matrix)) * shape->volume();
      }

      bool
      center(Point<dim> &center) const override
      {
        if (!shape->center(center))
          return false;
        center = Point<dim>(matrix * center + shift);
        return true;
      }

      bool
      is_box() const override
      {
        return shape->is_box() && keeps_axes();
      }

      bool
      has_tight_box() const override
      {
        return shape->has_tight_box() && (shape->is_box() || keeps_axes());
      }

      BoundingBox<dim>
      bounding_box() const override
      {
        const auto box = shape->bounding_box();
        if (!is_bounded(box))
          return box;
        // each coordinate has its ends where the terms of its sum have theirs
        Point<dim> lower(shift), upper(shift);
        for (unsigned int i = 0; i < dim; ++i)
          for (unsigned int j = 0; j < dim; ++j)
            {
              const double a = matrix[i][j] * box.lower_bound(j),
                           b = matrix[i][j] * box.upper_bound(j);
              lower[i] += std::min(a, b);
              upper[i] += std::max(a, b);
            }
        return BoundingBox<dim>({lower, upper});
      }

    private:
      /** Whether the matrix is diagonal: no turn. */
      bool
      keeps_axes() const
      {
        for (unsigned int i = 0; i < dim; ++i)
          for (unsigned int j = 0; j < dim; ++j)
            if (i != j && matrix[i][j] != 0.)
              return false;
        return true;
      }

      const std::unique_ptr<Shape<dim>> shape;
      const Tensor<2, dim>              matrix, inverse;
      const Tensor<1, dim>              shift;
    };
  } // namespace

  template <int dim>
  std::unique_ptr<Shape<dim>>
  make_union(Shapes<dim> shapes)
  {
    auto box      = shapes.front()->bounding_box();
    bool is_tight = true;
    for (const auto &shape : shapes)
      {
        box.merge_with(shape->bounding_box());
        is_tight = is_tight && shape->has_tight_box();
      }
    return std::make_unique<Composed<dim>>(std::move(shapes),
                                           &in_any<dim>,
                                           box,
                                           is_tight);
  }

  template <int dim>
  std::unique_ptr<Shape<dim>>
  make_intersection(Shapes<dim> shapes)
  {
    auto       box = shapes.front()->bounding_box();
    Point<dim> lower, upper;
    for (const auto &shape : shapes)
      {
        const auto other = shape->bounding_box();
        for (unsigned int d = 0; d < dim; ++d)
          {
            lower[d] = std::max(box.lower_bound(d), other.lower_bound(d));
            upper[d] = std::min(box.upper_bound(d), other.upper_bound(d));
            if (lower[d] > upper[d])
              return nullptr;
          }
        box = BoundingBox<dim>({lower, upper});
      }
    return std::make_unique<Composed<dim>>(std::move(shapes),
                                           &in_all<dim>,
                                           box,
                                           false);
  }

  template <int dim>
  std::unique_ptr<Shape<dim>>
  make_difference(Shapes<dim> shapes)
  {
    const auto box = shapes.front()->bounding_box();
    return std::make_unique<Composed<dim>>(std::move(shapes),
                                           &in_first_alone<dim>,
                                           box,
                                           false);
  }

  template <int dim>
  std::unique_ptr<Shape<dim>>
  make_image(std::unique_ptr<Shape<dim>> shape,
             const Tensor<2, dim>       &matrix,
             const Tensor<1, dim>       &shift)
  {
    return std::make_unique<Image<dim>>(std::move(shape), matrix, shift);
  }

#define INSTANTIATE(dim)                                                       \
  template std::unique_ptr<Shape<dim>> make_union(Shapes<dim>);                \
  template std::unique_ptr<Shape<dim>> make_intersection(Shapes<dim>);         \
  template std::unique_ptr<Shape<dim>> make_difference(Shapes<dim>);           \
  template std::unique_ptr<Shape<dim>> make_image(std::unique_ptr<Shape<dim>>, \
                                                  const Tensor<2, dim> &,      \
                                                  const Tensor<1, dim> &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
