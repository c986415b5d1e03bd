#include <emmy/base/formula.h>
#include <emmy/particles/basic_shapes.h>

#include <boost/geometry.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <boost/geometry/geometries/polygon.hpp>

#include <cmath>
#include <limits>

namespace emmy
{
  using dealii::BoundingBox;
  using dealii::Point;
  using dealii::Tensor;

  template <int dim>
  BoundingBox<dim>
  everywhere()
  {
    Point<dim> lower, upper;
    for (unsigned int d = 0; d < dim; ++d)
      {
        lower[d] = std::numeric_limits<double>::lowest();
        upper[d] = std::numeric_limits<double>::max();
      }
    return BoundingBox<dim>({lower, upper});
  }

  template <int dim>
  bool
  is_bounded(const BoundingBox<dim> &box)
  {
    return box.upper_bound(0) < std::numeric_limits<double>::max();
  }

  namespace
  {
    template <int dim>
    class Box : public Shape<dim>
    {
    public:
      Box(const Point<dim> &lower, const Point<dim> &upper)
        : box({lower, upper})
      {}

      bool
      contains(const Point<dim> &position) const override
      {
        return box.point_inside(position, 0.);
      }

      double
      volume() const override
      {
        return box.volume();
      }

      bool
      center(Point<dim> &center) const override
      {
        center = box.center();
        return true;
      }

      bool
      is_box() const override
      {
        return true;
      }

      BoundingBox<dim>
      bounding_box() const override
      {
        return box;
      }

    private:
      const BoundingBox<dim> box;
    };

    template <int dim>
    class Ball : public Shape<dim>
    {
    public:
      Ball(const Point<dim> &center, const double radius)
        : middle(center)
        , radius(radius)
      {}

      bool
      contains(const Point<dim> &position) const override
      {
        return position.distance_square(middle) <= radius * radius;
      }

      double
      volume() const override
      {
        const double disc = dealii::numbers::PI * radius * radius;
        return dim == 2 ? disc : 4. / 3. * disc * radius;
      }

      bool
      center(Point<dim> &center) const override
      {
        center = middle;
        return true;
      }

      BoundingBox<dim>
      bounding_box() const override
      {
        Point<dim> lower = middle, upper = middle;
        for (unsigned int d = 0; d < dim; ++d)
          {
            lower[d] -= radius;
            upper[d] += radius;
          }
        return BoundingBox<dim>({lower, upper});
      }

    private:
      const Point<dim> middle;
      const double     radius;
    };

    /** A cylinder, or a cone that may be cut. */
    class Cone : public Shape<3>
    {
    public:
      Cone(const Point<3> &base,
           const Point<3> &top,
           const double    base_radius,
           const double    top_radius)
        : base(base)
        , axis((top - base) / base.distance(top))
        , length(base.distance(top))
        , radii{{base_radius, top_radius}}
      {}

      bool
      contains(const Point<3> &position) const override
      {
        const auto   from_base = position - base;
        const double along     = from_base * axis;
        const double radius =
          radii[0] + (radii[1] - radii[0]) * (along / length);
        return along >= 0. && along <= length &&
               (from_base - along * axis).norm_square() <= radius * radius;
      }

      double
      volume() const override
      {
        return dealii::numbers::PI * length / 3. *
               (radii[0] * radii[0] + radii[0] * radii[1] +
                radii[1] * radii[1]);
      }

      bool
      center(Point<3> &center) const override
      {
        const double a = radii[0] * radii[0], b = radii[0] * radii[1],
                     c = radii[1] * radii[1];
        center =
          base + (a + 2. * b + 3. * c) / (4. * (a + b + c)) * length * axis;
        return true;
      }

      BoundingBox<3>
      bounding_box() const override
      {
        Point<3> lower, upper;
        for (unsigned int d = 0; d < 3; ++d)
          {
            // extent of the end discs in direction d
            const double part = std::sqrt(std::max(0., 1. - axis[d] * axis[d]));
            const double end  = base[d] + length * axis[d];
            lower[d] =
              std::min(base[d] - part * radii[0], end - part * radii[1]);
            upper[d] =
              std::max(base[d] + part * radii[0], end + part * radii[1]);
          }
        return BoundingBox<3>({lower, upper});
      }

    private:
      const Point<3>              base;
      const Tensor<1, 3>          axis;
      const double                length;
      const std::array<double, 2> radii;
    };

    template <int dim>
    class HalfSpace : public Shape<dim>
    {
    public:
      HalfSpace(const Point<dim> &point, const Tensor<1, dim> &normal)
        : point(point)
        , normal(normal)
      {}

      bool
      contains(const Point<dim> &position) const override
      {
        return (position - point) * normal <= 0.;
      }

      BoundingBox<dim>
      bounding_box() const override
      {
        return everywhere<dim>();
      }

    private:
      const Point<dim>     point;
      const Tensor<1, dim> normal;
    };

    /** Boost's words for a polygon in the plane. */
    using Corner  = boost::geometry::model::d2::point_xy<double>;
    using Outline = boost::geometry::model::polygon<Corner>;

    class Polygon : public Shape<2>
    {
    public:
      explicit Polygon(const std::vector<Point<2>> &corners)
      {
        for (const Point<2> &corner : corners)
          boost::geometry::append(outline, Corner(corner[0], corner[1]));
        boost::geometry::correct(outline); // closed and clockwise
      }

      bool
      is_simple() const
      {
        return boost::geometry::is_valid(outline);
      }

      bool
      contains(const Point<2> &position) const override
      {
        return boost::geometry::covered_by(Corner(position[0], position[1]),
                                           outline);
      }

      double
      volume() const override
      {
        return boost::geometry::area(outline);
      }

      bool
      center(Point<2> &center) const override
      {
        Corner middle(0., 0.);
        boost::geometry::centroid(outline, middle);
        center = Point<2>(middle.x(), middle.y());
        return true;
      }

      BoundingBox<2>
      bounding_box() const override
      {
        boost::geometry::model::box<Corner> box;
        boost::geometry::envelope(outline, box);
        return BoundingBox<2>(
          {Point<2>(box.min_corner().x(), box.min_corner().y()),
           Point<2>(box.max_corner().x(), box.max_corner().y())});
      }

    private:
      Outline outline;
    };

    template <int dim>
    class Expression : public Shape<dim>
    {
    public:
      Expression(const std::string      &section,
                 const std::string      &entry,
                 const std::string      &text,
                 const BoundingBox<dim> &box)
        : box(box)
        , function(read_formulas<dim>(
            text,
            1,
            section,
            entry,
            "Write a formula in " +
              dealii::FunctionParser<dim>::default_variable_names() +
              " that is positive inside the body, e.g. 1 - x^2 - y^2."))
      {}

      bool
      contains(const Point<dim> &position) const override
      {
        // not point_inside(): it computes with the size, which can be infinite
        for (unsigned int d = 0; d < dim; ++d)
          if (position[d] < box.lower_bound(d) ||
              position[d] > box.upper_bound(d))
            return false;
        return function->value(position) > 0.;
      }

      BoundingBox<dim>
      bounding_box() const override
      {
        return box;
      }

    private:
      const BoundingBox<dim>                       box;
      std::unique_ptr<dealii::FunctionParser<dim>> function;
    };
  } // namespace

  template <int dim>
  std::unique_ptr<Shape<dim>>
  make_box(const Point<dim> &lower, const Point<dim> &upper)
  {
    return std::make_unique<Box<dim>>(lower, upper);
  }

  template <int dim>
  std::unique_ptr<Shape<dim>>
  make_ball(const Point<dim> &center, const double radius)
  {
    return std::make_unique<Ball<dim>>(center, radius);
  }

  template <int dim>
  std::unique_ptr<Shape<dim>>
  make_half_space(const Point<dim> &point, const Tensor<1, dim> &normal)
  {
    return std::make_unique<HalfSpace<dim>>(point, normal);
  }

  std::unique_ptr<Shape<3>>
  make_cone(const Point<3> &base,
            const Point<3> &top,
            const double    base_radius,
            const double    top_radius)
  {
    return std::make_unique<Cone>(base, top, base_radius, top_radius);
  }

  std::unique_ptr<Shape<2>>
  make_polygon(const std::vector<Point<2>> &corners)
  {
    auto polygon = std::make_unique<Polygon>(corners);
    if (!polygon->is_simple())
      return nullptr;
    return polygon;
  }

  template <int dim>
  std::unique_ptr<Shape<dim>>
  make_expression(const std::string      &section,
                  const std::string      &entry,
                  const std::string      &text,
                  const BoundingBox<dim> &box)
  {
    return std::make_unique<Expression<dim>>(section, entry, text, box);
  }

#define INSTANTIATE(dim)                                                     \
  template BoundingBox<dim>            everywhere<dim>();                    \
  template bool                        is_bounded(const BoundingBox<dim> &); \
  template std::unique_ptr<Shape<dim>> make_box(const Point<dim> &,          \
                                                const Point<dim> &);         \
  template std::unique_ptr<Shape<dim>> make_ball(const Point<dim> &,         \
                                                 const double);              \
  template std::unique_ptr<Shape<dim>> make_half_space(                      \
    const Point<dim> &, const Tensor<1, dim> &);                             \
  template std::unique_ptr<Shape<dim>> make_expression(                      \
    const std::string &,                                                     \
    const std::string &,                                                     \
    const std::string &,                                                     \
    const BoundingBox<dim> &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
