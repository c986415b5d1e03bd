#ifndef emmy_material_stress_rules_h
#define emmy_material_stress_rules_h

#include <emmy/base/effect_card.h>
#include <emmy/material/material.h>

#include <string>

namespace emmy
{
  /** One step of a batch of points of one material: state, motion, answer. */
  template <int dim>
  struct StressBatch
  {
    template <typename T>
    using PerPoint = std::array<T, max_batch_points>; ///< one value a point

    // in
    unsigned int n_points     = 0;    ///< at most max_batch_points
    bool         with_tangent = true; ///< whether Newton asks for the tangent
    /** Whether the material has history. */
    bool is_inelastic = false;
    /** Displacement gradient of the step, with respect to positions at t. */
    PerPoint<dealii::Tensor<2, dim>> displacement_gradient;
    /** State at t: b - I, tau (Pa), psi (elastic, J/m^3, reference volume). */
    PerPoint<MandelVector<dim>> left_cauchy_green_less_unit_old;
    /** At the start of the step, Pa. */
    PerPoint<MandelVector<dim>> kirchhoff_stress_old;
    /** At the start of the step, J/m^3. */
    PerPoint<double> stored_energy_old;
    /** The rest of the state at t, only if is_inelastic: b^e - I, energy
     * stored by hardening (J/m^3). The history at t stands in
     * material.history. */
    PerPoint<MandelVector<dim>> elastic_left_cauchy_green_less_unit_old;
    /** At the start of the step, J/m^3. */
    PerPoint<double> hardening_energy_old;

    // out
    /** State at t + dt: material.left_cauchy_green_less_unit (of b^e, which is
     * b in an elastic material), .kirchhoff_stress, ... */
    MaterialBatch<dim> material;
    /** b - I at t + dt, only if is_inelastic. */
    PerPoint<MandelVector<dim>> left_cauchy_green_less_unit;
    /** Nominal stress P at mid-step, relative to positions at t, Pa. */
    PerPoint<dealii::Tensor<2, dim>> nominal_stress;
    /** dP_iJ / dH_mL at row i*dim+J, column m*dim+L. Only if with_tangent. */
    PerPoint<dealii::Tensor<2, dim * dim>> tangent;
  };

  /**
   * The states of a batch at t + dt: deformation, and what the material says
   * of it. The nominal stress is left.
   *
   * @param with_energy_change whether to ask the material for the changes of
   *   its energies, if it gives them
   * @return index of the first point with det(I + H) <= 0, where the batch was
   *   left unfinished; n_points if there is none.
   */
  template <int dim>
  unsigned int
  update_states(const Material<dim> &material,
                StressBatch<dim>    &batch,
                const bool           with_energy_change = false);

  /**
   * dP/dH of P = F_m S, from S and a matrix C with dS = C : sym(F^T dH), where
   * F_m = I + H/2:
   * dP_iJ/dH_mL = 1/2 delta_im S_JL + F_m,iM C_MJKL F_mK.
   * For an S that depends on Delta C alone, F = Delta F and
   * C = 2 dS/d(Delta C).
   * @return dP_iJ/dH_mL at row i*dim+J, column m*dim+L
   */
  template <int dim>
  dealii::Tensor<2, dim * dim>
  nominal_tangent(const dealii::Tensor<2, dim> &Fm,
                  const dealii::Tensor<2, dim> &F,
                  const MandelVector<dim>      &S,
                  const MandelMatrix<dim>      &C);

  /**
   * A rule for the stress that acts during a step, for any material. With the
   * configuration at t as the reference of the step, every rule has the form
   * @f$ P = \tfrac12 (I + \Delta F) S @f$ with a symmetric S, so that linear
   * and angular momentum are exact. The rules differ in what S makes of the
   * stress tau_t at t and @f$ S_1 = \Delta F^{-1}\tau\Delta F^{-T} @f$ at the
   * end, and so in the energy that they lose. All come with their exact
   * tangent.
   *
   * conserving (Gonzalez 2000; Meng & Laursen 2002; Pretti et al. 2023, eqs
   * 47-52): with A = Delta F^T Delta F - I,
   * @f[ \bar S = \tfrac12(\tau_t + S_1),\quad B = b_t A b_t,\quad
   *     S = \bar S + B\,\frac{2(\Delta\psi + \Delta D) - \bar S : A}{A : B},
   * @f]
   * so that P : H equals the change of psi (elastic and hardening energy)
   * plus the dissipation Delta D to round-off. Of materials that give the
   * change of their energy this has all digits, however small strains and step
   * (1e-14 from steps of a hundredth of the elastic strain on, where energies
   * are subtracted); the energies at t + dt are those at t plus these changes.
   * Of other materials the change is a difference. Where the numerator of the
   * correction is below its round-off, the correction is zero and the change of
   * energy what this stress works.
   *
   * trapezoidal: S is the mean without the correction.
   *
   * end-point: S = S_1.
   *
   * mid-point: P = tau_mid (I + H/2)^-T with the stress tau_mid of the
   * material at the mid-point of the motion, from the state at t; one more
   * call of the material. The state at t + dt is that of the full step.
   */
  template <int dim>
  struct StressRule
  {
    /**
     * Fill the out fields of a batch from its in fields.
     *
     * @return index of the first point with det(I + H) <= 0, or for mid-point
     *   det(I + H/2) <= 0, where the batch was left unfinished; n_points if
     *   there is none.
     */
    unsigned int (*evaluate)(const Material<dim> &material,
                             StressBatch<dim>    &batch);
    /** Whether P : H is the change of psi plus the dissipation. */
    bool is_conserving;
  };

  /** The name of a rule that does not conserve, in the table of times. */
  constexpr const char *stress_rule_effect = "stress rule";

  /** What such a rule costs; present unless @p name is the conserving one. */
  EffectCard
  stress_rule_card(const std::string &name);

  /** The names of the rules, separated by |. */
  std::string
  stress_rule_names();

  /** The rule of that name, one of stress_rule_names(). */
  template <int dim>
  StressRule<dim>
  stress_rule(const std::string &name);
} // namespace emmy

#endif
