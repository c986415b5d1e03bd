#ifndef emmy_effects_contact_pair_h
#define emmy_effects_contact_pair_h

#include <deal.II/base/tensor.h>

#include <array>

namespace emmy
{
  /** How two contact points of bodies act on one another. */
  struct PairLaw
  {
    double       stiffness; ///< k, N/m
    double       reach;     ///< rho: where they begin to act, m
    unsigned int exponent;  ///< q
    double       share;     ///< alpha: of the reach, that of the first point
    double       friction;  ///< mu of Coulomb's law; 0: smooth
    double       spring_stiffness; ///< k_T of what sticks, N/m
  };

  /** A contact point, and how its particle moves in a step. */
  template <int dim>
  struct PairPoint
  {
    dealii::Tensor<1, dim> particle; ///< at t, m
    dealii::Tensor<1, dim> way;      ///< S u, m
    dealii::Tensor<2, dim> gradient; ///< L
    /** F xi at t, and of the step, m. */
    dealii::Tensor<1, dim> arm_old, arm;
    dealii::Tensor<2, dim> Z;         ///< of the middle, see pair_action()
    bool                   at_middle; ///< whether the arm is Z arm_old

    /** At t, m. */
    dealii::Tensor<1, dim>
    place() const
    {
      return particle + arm_old;
    }
  };

  /** What acts in a step between two contact points. */
  template <int dim>
  struct PairAction
  {
    /** Components of (S u, L), or of (f, f (x) a): [(dim + 1) i + l]. */
    static constexpr unsigned int n_motion = dim * (dim + 1);

    bool acts = false; ///< whether they touch
    /** g at t, and at the end of the step, m. */
    double gap_old = 0., gap_new = 0.;
    /** On the first particle, and behind it on the second, N and N m. */
    std::array<double, 2 * n_motion> value{};
    dealii::Tensor<1, dim>           force;  ///< on the first, N
    dealii::Tensor<1, dim>           spring; ///< at the end, m
    /** Gains in the step, J: of psi, of k_T xi^2 / 2; lost in sliding. */
    double stored = 0., spring_stored = 0., slip = 0.;
  };

  /** How what acts between two particles changes with their motions. */
  template <int dim>
  struct PairDerivative
  {
    /** Of (f, f (x) a) by (S u, L), see PairAction. */
    using Block = std::array<std::array<double, PairAction<dim>::n_motion>,
                             PairAction<dim>::n_motion>;

    /** Of what acts on one of both, by the motion of one of both. */
    std::array<std::array<Block, 2>, 2> of{};
  };

  /** psi of two points with a gap, J. */
  double
  pair_energy(const PairLaw &law, const double gap);

  /**
   * A potential of the distance whose work is exact, and friction. With
   * @f$ g = |x| - \rho @f$, x from the second point to the first, 0 at the
   * start, 1 at the end of the step, x_m the mean of both and w the change,
   * @f[ \psi(g) = \frac kq \langle -g \rangle^q / \rho^{q-2}, \qquad
   *     f = -\frac{2}{|x_0| + |x_1|} \frac{\psi_1 - \psi_0}{g_1 - g_0} x_m,
   *     \qquad f \cdot w = -(\psi_1 - \psi_0) @f]
   * acts on the first point, -f on the second. A force on a point with the arm
   * a has the components f and f (x) a for its particle.
   *
   * Friction acts at one common place of both particles, so that it gives no
   * torque: with @f$ b_1 = -\alpha (I + \tfrac12 H_1)^{-1} x_m @f$ and
   * @f$ b_2 = (1 - \alpha)(I + \tfrac12 H_2)^{-1} x_m @f$ (with arms of the
   * middle without the inverse) what slides is @f$ \Delta = w + L_1 b_1 - L_2
   * b_2 @f$, and the arms are a + b. It is returned in the middle of the step
   * as in contact(), with n along x_m and N = |f|.
   *
   * The derivative of the law, in w and Delta, is that of a number that knows
   * it (Sacado); w and Delta, the arms a and b by the motions of both particles
   * are written out.
   *
   * Pure. Cost: some roots where points are apart; where they touch, some
   * hundred operations, and some thousand with the derivative.
   *
   * @param derivative to which that of what acts is added; null: not wanted
   */
  template <int dim>
  PairAction<dim>
  pair_action(const PairLaw                &law,
              const PairPoint<dim>         &first,
              const PairPoint<dim>         &second,
              const dealii::Tensor<1, dim> &spring,
              PairDerivative<dim> *const    derivative = nullptr);
} // namespace emmy

#endif
