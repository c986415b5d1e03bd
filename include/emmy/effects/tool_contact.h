#ifndef emmy_effects_tool_contact_h
#define emmy_effects_tool_contact_h

#include <emmy/effects/tool_shapes.h>

namespace emmy
{
  /** How a contact point and a tool act on one another. */
  struct ContactLaw
  {
    double stiffness;        ///< k of psi = k <-phi>^2 / 2, N/m
    double friction;         ///< mu of Coulomb's law; 0: smooth
    double spring_stiffness; ///< k_T of what sticks, N/m
  };

  /** A contact point at the start of a step, in the tool's frame. */
  template <int dim>
  struct ContactPoint
  {
    dealii::Tensor<1, dim> place;           ///< m
    dealii::Tensor<1, dim> spring;          ///< xi, what it is stretched by, m
    bool                   is_held = false; ///< psi = k phi^2 / 2, both ways
  };

  /** What acts in a step on a contact point, in the tool's frame. */
  template <int dim>
  struct Contact
  {
    bool acts = false; ///< whether they touch
    /** phi at t, and at the end of the step, m. */
    double                 gap_old = 0., gap_new = 0.;
    dealii::Tensor<1, dim> force;      ///< on the point, N
    dealii::Tensor<2, dim> derivative; ///< df/dw, N/m
    dealii::Tensor<1, dim> spring;     ///< at the end, m
    /** Gains in the step, J: of psi, of k_T xi^2 / 2; lost in sliding. */
    double stored = 0., spring_stored = 0., slip = 0.;
  };

  /**
   * A penalty whose work is exact, and friction. With phi at both ends and in
   * the middle of the way w,
   * @f[ e = (\phi_1 - \phi_0 - n_m \cdot w)/w^2, \quad \bar g = n_m + e\,w,
   *     \quad f = -\frac{\psi_1 - \psi_0}{\phi_1 - \phi_0}\,\bar g,
   *     \quad f \cdot w = -(\psi_1 - \psi_0) @f]
   * (the discrete gradient of Gonzalez 1996). Coulomb friction is returned in
   * the middle of the step: with P = I - n n^T, n along g,
   * @f[ T = k_T (\tilde\xi + \tfrac12 P w) \text{ of at most } \mu |f|, \quad
   *     \xi_1 = 2T/k_T - \tilde\xi @f]
   * acts as -T; xi~ is xi laid into the plane of P with its length kept. What
   * xi_1 has beyond mu |f| / k_T is lost too, and all of it where the point
   * lets go. So
   * T.w = gain of k_T xi^2 / 2 + slip, and slip >= 0.
   *
   * Pure. Cost: three distances where they touch, two elsewhere.
   */
  template <int dim>
  Contact<dim>
  contact(const ToolShape<dim>         &shape,
          const ContactLaw             &law,
          const ContactPoint<dim>      &point,
          const dealii::Tensor<1, dim> &way);

  /** psi of a point where it is, J. */
  double
  contact_energy(const double stiffness, const double gap, const bool is_held);

  /**
   * How deep a way that begins and ends outside of a tool goes through it, m;
   * 0: not at all. Steps of the size of the distance miss nothing that is
   * deeper than @p resolution.
   */
  template <int dim>
  double
  depth_on_way(const ToolShape<dim>         &shape,
               const dealii::Tensor<1, dim> &place,
               const dealii::Tensor<1, dim> &way,
               const double                  resolution);
} // namespace emmy

#endif
