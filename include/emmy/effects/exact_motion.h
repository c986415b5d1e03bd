#ifndef emmy_effects_exact_motion_h
#define emmy_effects_exact_motion_h

#include <deal.II/base/point.h>

#include <emmy/base/section.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace emmy
{
  /** What a motion x = phi(X, t) does at one point and time. */
  template <int dim>
  struct ExactState
  {
    dealii::Tensor<1, dim> displacement; ///< x - X, m
    dealii::Tensor<1, dim> velocity;     ///< m/s
    dealii::Tensor<1, dim> acceleration; ///< m/s^2
    dealii::Tensor<2, dim> H;            ///< du/dX = F - I
    /** dF/dX_J, 1/m, J = 0 ... dim - 1. */
    std::array<dealii::Tensor<2, dim>, dim> F_gradient;
  };

  /**
   * A motion in closed form, of a body that is undeformed, but moves, at t = 0.
   * Owned by the manufactured solution that it is of.
   */
  template <int dim>
  class ExactMotion
  {
  public:
    virtual ~ExactMotion() = default;

    /** @param X position at t = 0, m; @param time t, s */
    virtual ExactState<dim>
    at(const dealii::Point<dim> &X, const double time) const = 0;

    /** The body that it is of, in words. */
    virtual std::string
    body() const = 0;

    /** Whether X belongs to that body. */
    virtual bool
    contains(const dealii::Point<dim> &X) const = 0;
  };

  /**
   * Section `Effects/Manufactured solution/vibration`: a box between rollers on
   * all its sides, whose material vibrates along the axes,
   *   u_i = A_i sin(pi (X_i - l_i)/L_i) sin(omega t),
   * with l the lower corner and L the edges. F is diagonal.
   */
  template <int dim>
  class VibrationParameters : public Section
  {
  public:
    /** Declares the entries of a section. */
    explicit VibrationParameters(const std::string &path);

    /** @param omega 1/s. Throws ExcParameter. */
    std::unique_ptr<const ExactMotion<dim>>
    make(const double omega) const;

  private:
    std::vector<double> lower, upper, amplitude; // m
  };

  /**
   * Section `Effects/Manufactured solution/vortex`: a ring, in 3D a tube along
   * z, each point of which turns about the axis by the angle
   *   alpha = A sin(omega t) (1 - s^2)^2 cos(pi (Z - c_z)/H),
   * with s = (R - R_m)/w from -1 at the inner to 1 at the outer radius; the
   * cosine is there in 3D only. alpha and its gradient vanish at both radii,
   * and dalpha/dZ at both ends, Z = c_z and c_z + H: so the ring is free of
   * tractions, and the ends are rollers. (In the plane this is the generalised
   * vortex of the literature on the material point method.)
   */
  template <int dim>
  class VortexParameters : public Section
  {
  public:
    /** Declares the entries of a section. */
    explicit VortexParameters(const std::string &path);

    /** @param omega 1/s. Throws ExcParameter. */
    std::unique_ptr<const ExactMotion<dim>>
    make(const double omega) const;

  private:
    std::vector<double> center;                               // m
    double              inner_radius = 0., outer_radius = 0.; // m
    double              angle  = 0.;                          // A, 1
    double              height = 0.;                          // H, m
  };
} // namespace emmy

#endif
