#include <deal.II/base/numbers.h>

#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/effects/tool_mesh.h>
#include <emmy/effects/tool_motion.h>
#include <emmy/effects/tool_shapes.h>

#include <cmath>

namespace emmy
{
  using dealii::Tensor;
  using dealii::Patterns::Double;
  using dealii::Patterns::List;

  namespace
  {
    template <int dim>
    Tensor<2, dim>
    unit()
    {
      Tensor<2, dim> result;
      for (unsigned int d = 0; d < dim; ++d)
        result[d][d] = 1.;
      return result;
    }

    /** Declare a list of numbers. */
    template <int dim>
    void
    declare_vector(Section             &section,
                   const std::string   &entry,
                   std::vector<double> &value,
                   const std::string   &documentation)
    {
      section.add_parameter(
        entry, value, documentation, section.prm, List(Double(), 0, dim));
    }

    void
    declare_length(Section           &section,
                   const std::string &entry,
                   double            &value,
                   const std::string &documentation)
    {
      section.add_parameter(
        entry, value, documentation + " Unit: m.", section.prm, Double());
    }

    void
    require(const bool         fact,
            const Section     &section,
            const std::string &entry,
            const double       value,
            const std::string &what)
    {
      AssertThrow(fact,
                  ExcParameter(section.path(), entry, shortest(value), what));
    }

    template <int dim>
    class PlaneParameters : public ToolShapeParameters<dim>
    {
    public:
      explicit PlaneParameters(const std::string &section)
        : ToolShapeParameters<dim>(section)
      {
        declare_vector<dim>(*this,
                            "Normal",
                            normal,
                            "Direction out of the tool, towards the bodies; "
                            "its length does not matter. The plane goes "
                            "through the reference point. Required.");
      }

      std::unique_ptr<ToolShape<dim>>
      make() const override
      {
        return std::make_unique<Plane<dim>>(
          direction_of<dim>(*this, "Normal", normal));
      }

    private:
      std::vector<double> normal;
    };

    /** phi = |r| - R. */
    template <int dim>
    class Ball : public ToolShape<dim>
    {
    public:
      explicit Ball(const double radius)
        : radius(radius)
      {}

      SurfaceDistance<dim>
      distance(const Tensor<1, dim> &r) const override
      {
        const double         length = r.norm();
        SurfaceDistance<dim> result{};
        result.value     = length - radius;
        result.normal[0] = 1.; // in the middle any direction is as good
        if (length == 0.)
          return result;
        result.normal    = r / length;
        result.curvature = unit<dim>();
        result.curvature -= outer_product(result.normal, result.normal);
        result.curvature /= length;
        return result;
      }

    private:
      const double radius;
    };

    template <int dim>
    class BallParameters : public ToolShapeParameters<dim>
    {
    public:
      explicit BallParameters(const std::string &section)
        : ToolShapeParameters<dim>(section)
      {
        declare_length(*this,
                       "Radius",
                       radius,
                       "Around the reference point. Required, positive.");
      }

      std::unique_ptr<ToolShape<dim>>
      make() const override
      {
        require(radius > 0.,
                *this,
                "Radius",
                radius,
                "it is required and must be positive (m).");
        return std::make_unique<Ball<dim>>(radius);
      }

    private:
      double radius = 0.;
    };

    /**
     * A box whose edges are rounded: the distance from a smaller box, less the
     * rounding. Inside that smaller box its gradient jumps at the diagonals.
     */
    template <int dim>
    class Box : public ToolShape<dim>
    {
    public:
      Box(const Tensor<1, dim> &half_size, const double rounding)
        : half_size(half_size)
        , rounding(rounding)
      {}

      SurfaceDistance<dim>
      distance(const Tensor<1, dim> &r) const override
      {
        Tensor<1, dim> beyond;
        unsigned int   nearest = 0; // side, of a point in the smaller box
        double         depth   = 0.;
        for (unsigned int d = 0; d < dim; ++d)
          {
            const double q = std::abs(r[d]) - half_size[d] + rounding;
            if (d == 0 || q > depth)
              {
                depth   = q;
                nearest = d;
              }
            if (q > 0.)
              beyond[d] = r[d] > 0. ? q : -q;
          }
        SurfaceDistance<dim> result{};
        if (!(depth > 0.))
          {
            result.value           = depth - rounding;
            result.normal[nearest] = r[nearest] < 0. ? -1. : 1.;
            return result;
          }
        const double length = beyond.norm();
        result.value        = length - rounding;
        result.normal       = beyond / length;
        for (unsigned int d = 0; d < dim; ++d)
          result.curvature[d][d] = beyond[d] != 0. ? 1. : 0.;
        result.curvature -= outer_product(result.normal, result.normal);
        result.curvature /= length;
        return result;
      }

    private:
      const Tensor<1, dim> half_size;
      const double         rounding;
    };

    constexpr const char *rounding_advice =
      "it must be positive (m), and not larger than half the size. Half the "
      "spacing of the particles or more: their corners then slide around the "
      "edge.";

    template <int dim>
    class BoxParameters : public ToolShapeParameters<dim>
    {
    public:
      explicit BoxParameters(const std::string &section)
        : ToolShapeParameters<dim>(section)
      {
        declare_vector<dim>(*this,
                            "Size",
                            size,
                            "Lengths of the edges of the box, whose middle is "
                            "the reference point. Unit: m. Required.");
        declare_length(*this,
                       "Rounding",
                       rounding,
                       "Radius of the edges. Required, positive.");
      }

      std::unique_ptr<ToolShape<dim>>
      make() const override
      {
        Tensor<1, dim> half_size;
        bool           is_given = size.size() == dim;
        for (unsigned int d = 0; is_given && d < dim; ++d)
          {
            half_size[d] = 0.5 * size[d];
            is_given     = size[d] > 0.;
          }
        AssertThrow(is_given,
                    ExcParameter(this->path(),
                                 "Size",
                                 dealii::Patterns::Tools::to_string(size),
                                 "it is required: " + std::to_string(dim) +
                                   " positive lengths in m."));
        bool fits = rounding > 0.;
        for (unsigned int d = 0; d < dim; ++d)
          fits = fits && rounding <= half_size[d];
        require(fits, *this, "Rounding", rounding, rounding_advice);
        return std::make_unique<Box<dim>>(half_size, rounding);
      }

    private:
      std::vector<double> size;
      double              rounding = 0.;
    };

    /**
     * A surface of revolution: with z along the axis and r away from it, a
     * distance in the half-plane (r, z). In plane strain the same, mirrored.
     */
    template <int dim, class Profile>
    class Revolved : public ToolShape<dim>
    {
    public:
      Revolved(const Tensor<1, dim> &axis, const Profile &profile)
        : axis(axis)
        , profile(profile)
      {}

      SurfaceDistance<dim>
      distance(const Tensor<1, dim> &position) const override
      {
        const double         z      = position * axis;
        const Tensor<1, dim> away   = position - z * axis;
        const double         r      = away.norm();
        const Tensor<1, dim> radial = r > 0. ? away / r : Tensor<1, dim>();
        Tensor<1, 2>         in_profile;
        in_profile[0]             = r;
        in_profile[1]             = z;
        const auto           here = profile.distance(in_profile);
        const auto          &n    = here.normal;
        const auto          &k    = here.curvature;
        SurfaceDistance<dim> result;
        result.value  = here.value;
        result.normal = n[0] * radial + n[1] * axis;
        result.curvature =
          k[0][0] * outer_product(radial, radial) +
          k[1][1] * outer_product(axis, axis) +
          k[0][1] * (outer_product(radial, axis) + outer_product(axis, radial));
        // around the axis; on it as across
        const Tensor<2, dim> around = unit<dim>() -
                                      outer_product(radial, radial) -
                                      outer_product(axis, axis);
        result.curvature += (r > 0. ? n[0] / r : k[0][0]) * around;
        return result;
      }

    private:
      const Tensor<1, dim> axis;
      const Profile        profile;
    };

    /** A wall at r = R without ends. */
    struct Wall
    {
      double radius;

      SurfaceDistance<2>
      distance(const Tensor<1, 2> &r) const
      {
        SurfaceDistance<2> result{};
        result.value     = r[0] - radius;
        result.normal[0] = 1.;
        return result;
      }
    };

    template <int dim>
    class CylinderParameters : public ToolShapeParameters<dim>
    {
    public:
      explicit CylinderParameters(const std::string &section)
        : ToolShapeParameters<dim>(section)
      {
        declare_vector<dim>(*this, "Axis", axis, "Direction. Required.");
        declare_length(*this, "Radius", radius, "Required, positive.");
        declare_length(*this,
                       "Length",
                       length,
                       "Of the cylinder, whose middle is the reference point. "
                       "0: without end.");
        declare_length(*this,
                       "Rounding",
                       rounding,
                       "Radius of the edges of a cylinder with ends; "
                       "required there, positive.");
      }

      std::unique_ptr<ToolShape<dim>>
      make() const override
      {
        const auto along = direction_of<dim>(*this, "Axis", axis);
        require(radius > 0.,
                *this,
                "Radius",
                radius,
                "it is required and must be positive (m).");
        if (length == 0.)
          return std::make_unique<Revolved<dim, Wall>>(along, Wall{radius});
        require(length > 0.,
                *this,
                "Length",
                length,
                "it must be positive (m), or 0 for a cylinder without end.");
        require(rounding > 0. && rounding <= std::min(radius, 0.5 * length),
                *this,
                "Rounding",
                rounding,
                rounding_advice);
        Tensor<1, 2> half_size;
        half_size[0] = radius;
        half_size[1] = 0.5 * length;
        return std::make_unique<Revolved<dim, Box<2>>>(along,
                                                       Box<2>(half_size,
                                                              rounding));
      }

    private:
      std::vector<double> axis;
      double              radius = 0., length = 0., rounding = 0.;
    };

    /**
     * A cone without end around z > 0 whose tip, a part of a ball, touches the
     * origin.
     */
    struct Cone
    {
      double sine, cosine; ///< of half the angle at the tip
      double tip;          ///< radius, m

      SurfaceDistance<2>
      distance(const Tensor<1, 2> &r) const
      {
        // from the tip of a sharp cone that lies deeper by the tip's radius
        const double       z     = r[1] - tip;
        const double       along = r[0] * sine + z * cosine;
        const double       away  = r[0] * cosine - z * sine;
        SurfaceDistance<2> result{};
        if (along > 0.)
          {
            result.value     = away - tip;
            result.normal[0] = cosine;
            result.normal[1] = -sine;
            return result;
          }
        Tensor<1, 2> from_center;
        from_center[0] = r[0];
        from_center[1] = z;
        return Ball<2>(tip).distance(from_center);
      }
    };

    template <int dim>
    class ConeParameters : public ToolShapeParameters<dim>
    {
    public:
      explicit ConeParameters(const std::string &section)
        : ToolShapeParameters<dim>(section)
      {
        declare_vector<dim>(*this,
                            "Axis",
                            axis,
                            "Direction from the tip, which is the reference "
                            "point, into the tool. Required.");
        this->add_parameter("Half angle",
                            half_angle,
                            "Between axis and surface. Unit: degrees. "
                            "Required, between 0 and 90.",
                            this->prm,
                            Double());
        declare_length(*this,
                       "Tip radius",
                       tip,
                       "Required, positive; half the spacing of the particles "
                       "or more.");
      }

      std::unique_ptr<ToolShape<dim>>
      make() const override
      {
        const auto along = direction_of<dim>(*this, "Axis", axis);
        require(half_angle > 0. && half_angle < 90.,
                *this,
                "Half angle",
                half_angle,
                "it is required and must lie between 0 and 90 degrees.");
        require(tip > 0.,
                *this,
                "Tip radius",
                tip,
                "it is required and must be positive (m).");
        const double angle = half_angle / 180. * dealii::numbers::PI;
        return std::make_unique<Revolved<dim, Cone>>(
          along, Cone{std::sin(angle), std::cos(angle), tip});
      }

    private:
      std::vector<double> axis;
      double              half_angle = 0., tip = 0.;
    };

    template <int dim, class Parameters>
    typename Library<ToolShapeParameters<dim>>::Entry
    entry_of(const std::string &name, const std::string &description)
    {
      return {name, description, [](const std::string &section) {
                return std::make_unique<Parameters>(section);
              }};
    }
  } // namespace

  template <int dim>
  Library<ToolShapeParameters<dim>> &
  tool_shape_library()
  {
    static Library<ToolShapeParameters<dim>> library = [] {
      Library<ToolShapeParameters<dim>> shapes;
      shapes.add(entry_of<dim, PlaneParameters<dim>>("plane", "a half-space"));
      shapes.add(entry_of<dim, BallParameters<dim>>(
        "ball", "ball; in plane strain a cylinder seen from its end"));
      if constexpr (dim == 3)
        shapes.add(entry_of<dim, CylinderParameters<dim>>(
          "cylinder", "circular cylinder, with rounded edges or endless"));
      shapes.add(
        entry_of<dim, BoxParameters<dim>>("box", "box with rounded edges"));
      shapes.add(entry_of<dim, ConeParameters<dim>>(
        "cone", "cone with a rounded tip; in plane strain a wedge"));
      if constexpr (dim == 3)
        shapes.add({"mesh", "closed surface in a file", make_mesh_parameters});
      return shapes;
    }();
    return library;
  }

  template Library<ToolShapeParameters<2>> &
  tool_shape_library<2>();
  template Library<ToolShapeParameters<3>> &
  tool_shape_library<3>();
} // namespace emmy
