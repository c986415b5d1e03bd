#include <emmy/base/formula.h>
#include <emmy/particles/shape.h>

#include <limits>

namespace emmy
{
  using dealii::BoundingBox;
  using dealii::Point;

  namespace
  {
    /** Radius of balls and cylinders. */
    void
    require_positive(const Section     &section,
                     const std::string &entry,
                     const double       value)
    {
      AssertThrow(value > 0.,
                  ExcParameter(section.path(),
                               entry,
                               shortest(value),
                               "it is required and must be positive (m)."));
    }

    /** List of coordinates in the words of a parameter file. */
    template <int dim>
    class Coordinates
    {
    public:
      /** Empty unless given, which ParameterHandler can print. */
      std::vector<double> values;

      void
      add_to(Section           &section,
             const std::string &name,
             const std::string &doc,
             const std::string &when = "Required")
      {
        section.add_parameter(name,
                              values,
                              doc + " Unit: m. " + when + ": " +
                                std::to_string(dim) + " coordinates.",
                              section.prm,
                              dealii::Patterns::List(dealii::Patterns::Double(),
                                                     0,
                                                     dim));
      }

      Point<dim>
      point(const Section &section, const std::string &name) const
      {
        AssertThrow(values.size() == dim,
                    ExcParameter(section.path(),
                                 name,
                                 dealii::Patterns::Tools::to_string(values),
                                 "it is required: " + std::to_string(dim) +
                                   " coordinates in m, separated by , or ;."));
        Point<dim> result;
        for (unsigned int d = 0; d < dim; ++d)
          result[d] = values[d];
        return result;
      }
    };

    template <int dim>
    void
    require_above(const Section    &section,
                  const Point<dim> &lower,
                  const Point<dim> &upper)
    {
      for (unsigned int d = 0; d < dim; ++d)
        AssertThrow(upper[d] > lower[d],
                    ExcParameter(section.path(),
                                 "Upper corner",
                                 dealii::Patterns::Tools::to_string(upper),
                                 "must lie above the lower corner in each "
                                 "direction."));
    }

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
    class BoxParameters : public ShapeParameters<dim>
    {
    public:
      explicit BoxParameters(const std::string &section)
        : ShapeParameters<dim>(section)
      {
        lower.add_to(*this, "Lower corner", "Lower corner of the box.");
        upper.add_to(*this, "Upper corner", "Upper corner of the box.");
      }

      std::unique_ptr<Shape<dim>>
      make() const override
      {
        const auto from = lower.point(*this, "Lower corner");
        const auto to   = upper.point(*this, "Upper corner");
        require_above(*this, from, to);
        return std::make_unique<Box<dim>>(from, to);
      }

    private:
      Coordinates<dim> lower, upper;
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

    template <int dim>
    class BallParameters : public ShapeParameters<dim>
    {
    public:
      explicit BallParameters(const std::string &section)
        : ShapeParameters<dim>(section)
      {
        center.add_to(*this, "Center", "Center of the ball.");
        this->add_parameter("Radius",
                            radius,
                            "Radius of the ball. Unit: m. Required, positive.",
                            this->prm,
                            dealii::Patterns::Double(0.));
      }

      std::unique_ptr<Shape<dim>>
      make() const override
      {
        require_positive(*this, "Radius", radius);
        return std::make_unique<Ball<dim>>(center.point(*this, "Center"),
                                           radius);
      }

    private:
      Coordinates<dim> center;
      double           radius = 0.;
    };

    template <int dim>
    class Cylinder : public Shape<dim>
    {
    public:
      Cylinder(const Point<dim> &base,
               const Point<dim> &top,
               const double      radius)
        : base(base)
        , axis((top - base) / base.distance(top))
        , length(base.distance(top))
        , radius(radius)
      {}

      bool
      contains(const Point<dim> &position) const override
      {
        const auto   from_base = position - base;
        const double along     = from_base * axis;
        return along >= 0. && along <= length &&
               (from_base - along * axis).norm_square() <= radius * radius;
      }

      double
      volume() const override
      {
        return dealii::numbers::PI * radius * radius * length;
      }

      bool
      center(Point<dim> &center) const override
      {
        center = base + 0.5 * length * axis;
        return true;
      }

      BoundingBox<dim>
      bounding_box() const override
      {
        Point<dim> lower, upper;
        for (unsigned int d = 0; d < dim; ++d)
          {
            // extent of the end discs in direction d
            const double disc =
              radius * std::sqrt(std::max(0., 1. - axis[d] * axis[d]));
            const double end = base[d] + length * axis[d];
            lower[d]         = std::min(base[d], end) - disc;
            upper[d]         = std::max(base[d], end) + disc;
          }
        return BoundingBox<dim>({lower, upper});
      }

    private:
      const Point<dim>             base;
      const dealii::Tensor<1, dim> axis;
      const double                 length, radius;
    };

    template <int dim>
    class CylinderParameters : public ShapeParameters<dim>
    {
    public:
      explicit CylinderParameters(const std::string &section)
        : ShapeParameters<dim>(section)
      {
        base.add_to(*this, "Base", "Center of one end disc.");
        top.add_to(*this, "Top", "Center of the other end disc.");
        this->add_parameter("Radius",
                            radius,
                            "Radius of the cylinder. Unit: m. Required, "
                            "positive.",
                            this->prm,
                            dealii::Patterns::Double(0.));
      }

      std::unique_ptr<Shape<dim>>
      make() const override
      {
        require_positive(*this, "Radius", radius);
        const auto from = base.point(*this, "Base");
        const auto to   = top.point(*this, "Top");
        AssertThrow(from.distance(to) > 0.,
                    ExcParameter(this->path(),
                                 "Top",
                                 dealii::Patterns::Tools::to_string(to),
                                 "must differ from <Base>."));
        return std::make_unique<Cylinder<dim>>(from, to, radius);
      }

    private:
      Coordinates<dim> base, top;
      double           radius = 0.;
    };

    template <int dim>
    class Expression : public Shape<dim>
    {
    public:
      Expression(const std::string      &section,
                 const std::string      &text,
                 const BoundingBox<dim> &box)
        : box(box)
        , function(read_formulas<dim>(
            text,
            1,
            section,
            "Expression",
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

    template <int dim>
    class ExpressionParameters : public ShapeParameters<dim>
    {
    public:
      explicit ExpressionParameters(const std::string &section)
        : ShapeParameters<dim>(section)
      {
        this->add_parameter("Expression",
                            text,
                            "A formula in x, y (and z), in m, that is positive "
                            "inside the body. Required.");
        const std::string both = "Optional, but then both corners";
        lower.add_to(*this,
                     "Lower corner",
                     "Lower corner of a box; the body is what lies in it. "
                     "Without one the formula is tried all over the grid, "
                     "which takes long where the grid is large.",
                     both);
        upper.add_to(*this, "Upper corner", "Upper corner of that box.", both);
      }

      std::unique_ptr<Shape<dim>>
      make() const override
      {
        Point<dim> from, to;
        for (unsigned int d = 0; d < dim; ++d)
          {
            from[d] = std::numeric_limits<double>::lowest();
            to[d]   = std::numeric_limits<double>::max();
          }
        if (!lower.values.empty() || !upper.values.empty())
          {
            from = lower.point(*this, "Lower corner");
            to   = upper.point(*this, "Upper corner");
            require_above(*this, from, to);
          }
        return std::make_unique<Expression<dim>>(this->path(),
                                                 text,
                                                 BoundingBox<dim>({from, to}));
      }

    private:
      std::string      text;
      Coordinates<dim> lower, upper;
    };

    template <int dim>
    Library<ShapeParameters<dim>>
    built_in_shapes()
    {
      Library<ShapeParameters<dim>> shapes;
      shapes.add({"box", "axis-parallel box", [](const std::string &section) {
                    return std::make_unique<BoxParameters<dim>>(section);
                  }});
      shapes.add({"ball",
                  "ball; in plane strain a cylinder seen from its end",
                  [](const std::string &section) {
                    return std::make_unique<BallParameters<dim>>(section);
                  }});
      if (dim == 3)
        shapes.add({"cylinder",
                    "circular cylinder between two points",
                    [](const std::string &section) {
                      return std::make_unique<CylinderParameters<dim>>(section);
                    }});
      shapes.add({"expression",
                  "where a formula is positive",
                  [](const std::string &section) {
                    return std::make_unique<ExpressionParameters<dim>>(section);
                  }});
      return shapes;
    }
  } // namespace

  template <int dim>
  Library<ShapeParameters<dim>> &
  shape_library()
  {
    static Library<ShapeParameters<dim>> library = built_in_shapes<dim>();
    return library;
  }

  template Library<ShapeParameters<2>> &
  shape_library<2>();
  template Library<ShapeParameters<3>> &
  shape_library<3>();
} // namespace emmy
