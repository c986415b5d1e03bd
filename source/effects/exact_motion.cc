#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/effects/exact_motion.h>

#include <cmath>

namespace emmy
{
  using dealii::Point;
  using dealii::Tensor;
  using dealii::numbers::PI;
  using dealii::Patterns::Double;
  using dealii::Patterns::List;

  namespace
  {
    /** The dim components of a list that is required. Throws ExcParameter. */
    template <int dim>
    Point<dim>
    required(const Section             &section,
             const std::string         &entry,
             const std::vector<double> &values)
    {
      AssertThrow(values.size() == dim,
                  ExcParameter(section.path(),
                               entry,
                               dealii::Patterns::Tools::to_string(values),
                               "it is required: " + std::to_string(dim) +
                                 " numbers in m, separated by , or ;."));
      Point<dim> result;
      for (unsigned int d = 0; d < dim; ++d)
        result[d] = values[d];
      return result;
    }

    template <int dim>
    std::string
    text(const Point<dim> &point)
    {
      return "(" + dealii::Patterns::Tools::to_string(point) + ")";
    }

    template <int dim>
    class Vibration : public ExactMotion<dim>
    {
    public:
      Vibration(const Point<dim> &lower,
                const Point<dim> &upper,
                const Point<dim> &amplitude,
                const double      omega)
        : lower(lower)
        , upper(upper)
        , amplitude(amplitude)
        , omega(omega)
      {}

      ExactState<dim>
      at(const Point<dim> &X, const double time) const override
      {
        const double    sine = std::sin(omega * time);
        ExactState<dim> state;
        for (unsigned int i = 0; i < dim; ++i)
          {
            const double k     = PI / (upper[i] - lower[i]);
            const double phase = k * (X[i] - lower[i]);
            const double shape = amplitude[i] * std::sin(phase);

            state.displacement[i] = shape * sine;
            state.velocity[i]     = shape * omega * std::cos(omega * time);
            state.acceleration[i] = -shape * omega * omega * sine;
            state.H[i][i]         = amplitude[i] * k * std::cos(phase) * sine;
            state.F_gradient[i][i][i] = -shape * k * k * sine;
          }
        return state;
      }

      std::string
      body() const override
      {
        return "the box from " + text(lower) + " to " + text(upper) + " m";
      }

      bool
      contains(const Point<dim> &X) const override
      {
        for (unsigned int d = 0; d < dim; ++d)
          if (X[d] < lower[d] || X[d] > upper[d])
            return false;
        return true;
      }

    private:
      const Point<dim> lower, upper, amplitude;
      const double     omega;
    };

    template <int dim>
    class Vortex : public ExactMotion<dim>
    {
    public:
      Vortex(const Point<dim> &center,
             const double      inner_radius,
             const double      outer_radius,
             const double      angle,
             const double      height,
             const double      omega)
        : center(center)
        , inner_radius(inner_radius)
        , outer_radius(outer_radius)
        , angle(angle)
        , height(height)
        , omega(omega)
      {}

      ExactState<dim>
      at(const Point<dim> &X, const double time) const override
      {
        // alpha = G(t) profile(X)
        const double         G       = angle * std::sin(omega * time);
        const double         G_dot   = angle * omega * std::cos(omega * time);
        const Profile        profile = profile_at(X);
        const double         alpha   = G * profile.value;
        const Tensor<1, dim> slope   = G * profile.gradient;
        const double         c = std::cos(alpha), s = std::sin(alpha);
        Tensor<2, dim>       Q_slope; // dQ/dalpha
        ExactState<dim>      state;
        Tensor<2, dim>      &H = state.H; // Q - I so far, without cancellation
        H[0][0] = H[1][1] = -2. * std::pow(std::sin(0.5 * alpha), 2);
        H[1][0]           = s;
        H[0][1]           = -s;
        Q_slope[0][0] = Q_slope[1][1] = -s;
        Q_slope[1][0]                 = c;
        Q_slope[0][1]                 = -c;

        // arm = Q X in the plane, d arm/d alpha = side, d side/d alpha = -arm
        Tensor<1, dim> in_plane = X - center;
        if (dim == 3)
          in_plane[dim - 1] = 0.;
        const Tensor<1, dim> side = Q_slope * in_plane;
        const Tensor<1, dim> arm  = in_plane + H * in_plane;

        state.displacement = H * in_plane;
        state.velocity     = G_dot * profile.value * side;
        state.acceleration = -omega * omega * alpha * side -
                             std::pow(G_dot * profile.value, 2) * arm;
        H += outer_product(side, slope);
        for (unsigned int K = 0; K < dim; ++K)
          {
            Tensor<1, dim> Q_slope_K;
            for (unsigned int i = 0; i < dim; ++i)
              Q_slope_K[i] = Q_slope[i][K];
            state.F_gradient[K] =
              slope[K] * Q_slope +
              outer_product(Q_slope_K - slope[K] * arm, slope) +
              outer_product(side, G * profile.hessian[K]);
          }
        return state;
      }

      std::string
      body() const override
      {
        return std::string(dim == 2 ? "the ring" : "the tube") + " about " +
               text(center) + " m between the radii " + shortest(inner_radius) +
               " and " + shortest(outer_radius) + " m" +
               (dim == 2 ? "" : " and " + shortest(height) + " m high");
      }

      bool
      contains(const Point<dim> &X) const override
      {
        const double R = std::hypot(X[0] - center[0], X[1] - center[1]);
        if (R < inner_radius || R > outer_radius)
          return false;
        const double Z = X[dim - 1] - center[dim - 1];
        return dim == 2 || (Z >= 0. && Z <= height);
      }

    private:
      /** (1 - s^2)^2 cos(pi Z/H) with its derivatives. */
      struct Profile
      {
        double         value;
        Tensor<1, dim> gradient;
        Tensor<2, dim> hessian;
      };

      Profile
      profile_at(const Point<dim> &X) const
      {
        const double   w = 0.5 * (outer_radius - inner_radius);
        Tensor<1, dim> direction; // dR/dX
        direction[0]   = X[0] - center[0];
        direction[1]   = X[1] - center[1];
        const double R = direction.norm();
        direction /= R;
        const double s  = (R - inner_radius) / w - 1.;
        const double f  = (1. - s * s) * (1. - s * s);
        const double f1 = -4. * s * (1. - s * s) / w; // df/dR
        const double f2 = -4. * (1. - 3. * s * s) / (w * w);

        const double k  = dim == 3 ? PI / height : 0.;
        const double Z  = X[dim - 1] - center[dim - 1];
        const double g  = dim == 3 ? std::cos(k * Z) : 1.;
        const double g1 = dim == 3 ? -k * std::sin(k * Z) : 0.; // dg/dZ

        Profile result;
        result.value    = f * g;
        result.gradient = f1 * g * direction;
        result.hessian =
          (f2 - f1 / R) * g * outer_product(direction, direction);
        for (unsigned int d = 0; d < 2; ++d)
          result.hessian[d][d] += f1 / R * g;
        if (dim == 3)
          {
            constexpr unsigned int z = dim - 1;
            result.gradient[z]       = f * g1;
            result.hessian[z][z]     = -k * k * f * g;
            for (unsigned int d = 0; d < 2; ++d)
              result.hessian[d][z] = result.hessian[z][d] =
                f1 * g1 * direction[d];
          }
        return result;
      }

      const Point<dim> center;
      const double     inner_radius, outer_radius, angle, height, omega;
    };
  } // namespace

  template <int dim>
  VibrationParameters<dim>::VibrationParameters(const std::string &path)
    : Section(path)
  {
    const List coordinates(Double(), 0, dim);
    this->add_parameter("Lower corner",
                        lower,
                        "Lower corner of the box that vibrates. All its sides "
                        "must be rollers. Unit: m. Required.",
                        this->prm,
                        coordinates);
    this->add_parameter("Upper corner",
                        upper,
                        "Upper corner of the box. Unit: m. Required.",
                        this->prm,
                        coordinates);
    this->add_parameter("Amplitude",
                        amplitude,
                        "Largest displacement in each direction, in the "
                        "middle of the box; 1/pi of the edge, where the box "
                        "would be turned inside out, is too much. Negative: "
                        "it starts the other way. Unit: m. Required.",
                        this->prm,
                        coordinates);
  }

  template <int dim>
  std::unique_ptr<const ExactMotion<dim>>
  VibrationParameters<dim>::make(const double omega) const
  {
    const Point<dim> from = required<dim>(*this, "Lower corner", lower),
                     to   = required<dim>(*this, "Upper corner", upper),
                     A    = required<dim>(*this, "Amplitude", amplitude);
    for (unsigned int d = 0; d < dim; ++d)
      {
        AssertThrow(to[d] > from[d],
                    ExcParameter(this->path(),
                                 "Upper corner",
                                 dealii::Patterns::Tools::to_string(upper),
                                 "must lie above the lower corner in each "
                                 "direction."));
        const double limit = (to[d] - from[d]) / PI;
        AssertThrow(std::abs(A[d]) < limit,
                    ExcParameter(this->path(),
                                 "Amplitude",
                                 dealii::Patterns::Tools::to_string(amplitude),
                                 "component " + std::string(1, "xyz"[d]) +
                                   " must be below " + brief(limit) +
                                   " m in size, the edge over pi: there the "
                                   "material has no volume left."));
      }
    return std::make_unique<const Vibration<dim>>(from, to, A, omega);
  }

  template <int dim>
  VortexParameters<dim>::VortexParameters(const std::string &path)
    : Section(path)
  {
    this->add_parameter("Center",
                        center,
                        std::string("Center of the ring.") +
                          (dim == 3 ? " Its z is that of the lower end." : "") +
                          " Unit: m. Required.",
                        this->prm,
                        List(Double(), 0, dim));
    this->add_parameter("Inner radius",
                        inner_radius,
                        "Of the ring. Unit: m. Required, positive.",
                        this->prm,
                        Double(0.));
    this->add_parameter("Outer radius",
                        outer_radius,
                        "Of the ring. Unit: m. Required, above the inner one.",
                        this->prm,
                        Double(0.));
    this->add_parameter("Angle",
                        angle,
                        "Largest angle by which points half-way between the "
                        "radii turn. Unit: rad. Required, not zero.",
                        this->prm,
                        Double());
    if (dim == 3)
      this->add_parameter("Height",
                          height,
                          "Length in z, over which the angle changes as half "
                          "a wave of the cosine. Both ends must be rollers. "
                          "Unit: m. Required, positive.",
                          this->prm,
                          Double(0.));
  }

  template <int dim>
  std::unique_ptr<const ExactMotion<dim>>
  VortexParameters<dim>::make(const double omega) const
  {
    const auto require = [this](const bool         condition,
                                const std::string &entry,
                                const double       value,
                                const std::string &advice) {
      AssertThrow(condition,
                  ExcParameter(this->path(), entry, shortest(value), advice));
    };
    const Point<dim> at = required<dim>(*this, "Center", center);
    require(inner_radius > 0.,
            "Inner radius",
            inner_radius,
            "it is required and must be positive (m).");
    require(outer_radius > inner_radius,
            "Outer radius",
            outer_radius,
            "it is required and must be above the inner one (m).");
    require(angle != 0.,
            "Angle",
            angle,
            "it is required and must not be zero (rad).");
    require(dim == 2 || height > 0.,
            "Height",
            height,
            "it is required and must be positive (m).");
    return std::make_unique<const Vortex<dim>>(
      at, inner_radius, outer_radius, angle, height, omega);
  }

  template class VibrationParameters<2>;
  template class VibrationParameters<3>;
  template class VortexParameters<2>;
  template class VortexParameters<3>;
} // namespace emmy
