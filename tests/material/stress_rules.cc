// The stress rules: conserving stores and dissipates exactly what it works, all
// keep angular momentum, and their tangents are their derivatives, for every
// material, elastic and flowing: on random states, for pure rotations, at
// equal eigenvalues and for vanishing increments.

#include <emmy/material/static_stress.h>

#include "laws.h"

using namespace emmy;
using dealii::Tensor;
using test::all_laws_and_soils;
using test::identity;
using test::Law;
using test::moved;
using test::random_tensor;
using test::state_at;

namespace
{
  /** A proper rotation: the polar factor of a random tensor. */
  template <int dim>
  Tensor<2, dim>
  rotation(const double angle)
  {
    Tensor<2, dim> R = identity<dim>();
    R[0][0] = R[1][1] = std::cos(angle);
    R[0][1]           = -std::sin(angle);
    R[1][0]           = std::sin(angle);
    if (dim == 3)
      {
        Tensor<2, dim> R2    = identity<dim>();
        R2[dim - 2][dim - 2] = R2[dim - 1][dim - 1] = std::cos(2. * angle);
        R2[dim - 2][dim - 1]                        = -std::sin(2. * angle);
        R2[dim - 1][dim - 2]                        = std::sin(2. * angle);
        R                                           = R * R2;
      }
    return R;
  }

  /** Whether a step makes the point flow. */
  template <int dim>
  bool
  flows(const Material<dim>    &material,
        const StressBatch<dim> &state,
        const Tensor<2, dim>   &H)
  {
    return state.is_inelastic &&
           moved<dim>(material, stress_rule<dim>("conserving"), state, H)
               .material.dissipation[0] > 0.;
  }

  /** A random step that flows or not, and would if it were a bit different. */
  template <int dim>
  Tensor<2, dim>
  random_step(const Material<dim>    &material,
              const StressBatch<dim> &state,
              const bool              is_flowing)
  {
    for (unsigned int trial = 0; trial < 10000; ++trial)
      {
        const auto H = random_tensor<dim>(0.2);
        // and so halfway, for the mid-point rule
        bool fits = true;
        for (const double part : {0.49, 0.51, 0.98, 1., 1.02})
          fits = fits && flows<dim>(material, state, part * H) == is_flowing;
        if (fits)
          return H;
      }
    test::check(false, "there is such a step");
    return {};
  }

  /**
   * Tangent against centred differences of size @p delta. The order of their
   * error is two, seen from differences of size 20 and 10 delta.
   */
  template <int dim>
  void
  check_tangent(const Material<dim>    &material,
                const StressRule<dim>  &rule,
                const StressBatch<dim> &state,
                const Tensor<2, dim>   &H,
                const double            delta,
                const double            tolerance,
                const std::string      &what)
  {
    const auto tangent = moved<dim>(material, rule, state, H).tangent[0];
    const auto error   = [&](const double size) {
      Tensor<2, dim * dim> difference;
      for (unsigned int m = 0; m < dim; ++m)
        for (unsigned int L = 0; L < dim; ++L)
          {
            Tensor<2, dim> plus = H, minus = H;
            plus[m][L] += size;
            minus[m][L] -= size;
            const auto dP =
              (moved<dim>(material, rule, state, plus).nominal_stress[0] -
               moved<dim>(material, rule, state, minus).nominal_stress[0]) /
              (2. * size);
            for (unsigned int i = 0; i < dim; ++i)
              for (unsigned int J = 0; J < dim; ++J)
                difference[i * dim + J][m * dim + L] = dP[i][J];
          }
      return (difference - tangent).norm() / tangent.norm();
    };
    test::check_close(error(delta), 0., tolerance, what + ": tangent");
    if (H.norm() > 0.)
      test::check_close(std::log2(error(20. * delta) / error(10. * delta)),
                        2.,
                        0.1,
                        what + ": order");
  }

  /** Work, symmetry, objectivity and tangent on random states. */
  template <int dim>
  void
  check_random(const Material<dim>   &material,
               const StressRule<dim> &rule,
               const bool             is_objective,
               const bool             is_flowing,
               const std::string     &name)
  {
    const auto I = identity<dim>();
    for (unsigned int sample = 0; sample < 20; ++sample)
      {
        const auto state =
          state_at<dim>(material, random_tensor<dim>(0.3), 0.1 * sample / 20.);
        const auto H = random_step<dim>(material, state, is_flowing);
        const auto p = moved<dim>(material, rule, state, H);

        double change = p.material.stored_energy[0] - p.stored_energy_old[0];
        double size   = p.material.stored_energy[0] + p.stored_energy_old[0];
        if (p.is_inelastic)
          {
            change += p.material.hardening_energy[0] -
                      p.hardening_energy_old[0] + p.material.dissipation[0];
            size += p.material.hardening_energy[0] + p.material.dissipation[0];
          }
        if (rule.is_conserving)
          test::check_close(scalar_product(p.nominal_stress[0], H),
                            change,
                            1e-14 * size + 1e-14,
                            name + ": P:H is what is stored and dissipated");

        // (I + H/2)^-1 P is symmetric: angular momentum
        const auto S = invert(I + 0.5 * H) * p.nominal_stress[0];
        test::check_close((S - transpose(S)).norm() / S.norm(),
                          0.,
                          1e-14,
                          name + ": S is symmetric");

        // an observer that turns during the step sees the turned stress
        const auto R      = rotation<dim>(0.7);
        const auto H_turn = R * (I + H) - I;
        const auto turned = moved<dim>(material, rule, state, H_turn);
        const auto S_turn = invert(I + 0.5 * H_turn) * turned.nominal_stress[0];
        if (is_objective)
          test::check_close((S_turn - S).norm() / S.norm(),
                            0.,
                            1e-12,
                            name + ": S does not depend on rotation");
        const auto tau =
          mandel::congruence<dim>(R) * p.material.kirchhoff_stress[0];
        test::check_close((turned.material.kirchhoff_stress[0] - tau).norm(),
                          0.,
                          1e-12 * tau.norm(),
                          name + ": stress at the end turns with the motion");
        if (sample < 3)
          check_tangent<dim>(
            material, rule, state, H, 1e-5, 5e-8, name + " general");
      }
  }

  /** Special states: from rest, equal eigenvalues, little or no motion. */
  template <int dim>
  void
  check_special(const Material<dim>   &material,
                const StressRule<dim> &rule,
                const bool             is_objective,
                const std::string     &name)
  {
    const auto I     = identity<dim>();
    const auto rest  = state_at<dim>(material, {}, 0.);
    const auto state = state_at<dim>(material, random_tensor<dim>(0.2), 0.05);
    const auto H     = random_step<dim>(material, state, false);

    check_tangent<dim>(
      material, rule, rest, 0.1 * H, 1e-5, 2e-8, name + " from rest");
    check_tangent<dim>(
      material, rule, rest, 0.05 * I, 1e-5, 2e-8, name + " equal eigenvalues");
    // the energy difference that the stress divides by |Delta C|^2 carries the
    // round-off of psi, so differences must not be too small
    check_tangent<dim>(
      material, rule, state, 0.1 * H, 1e-5, 2e-7, name + " small step");

    // zero increments: the limit of the tangent, where elastic. A centred
    // difference of the corrected stress, which is smooth there
    const auto           at_rest = moved<dim>(material, rule, state, 0. * H);
    const Tensor<2, dim> tau =
      mandel::block<dim>(at_rest.kirchhoff_stress_old[0]);
    test::check_close((at_rest.nominal_stress[0] - tau).norm(),
                      0.,
                      1e-13 * tau.norm(),
                      name + ": P = tau without motion");
    if (!state.is_inelastic)
      check_tangent<dim>(
        material, rule, state, 0. * H, 1e-4, 1e-7, name + " zero increment");

    // a rotation makes no new stress
    for (const double angle : {1e-9, 1e-3, 0.5, 2.})
      {
        const auto R      = rotation<dim>(angle);
        const auto turned = moved<dim>(material, rule, rest, R - I);
        test::check_close(turned.material.kirchhoff_stress[0].norm(),
                          0.,
                          2e-13,
                          name + ": rotation at rest");
        if (is_objective)
          test::check_close(turned.nominal_stress[0].norm(),
                            0.,
                            2e-13,
                            name + ": rotation at rest, P");
        const auto stressed = moved<dim>(material, rule, state, R - I);
        const auto expected =
          mandel::congruence<dim>(R) * stressed.kirchhoff_stress_old[0];
        test::check_close(
          (stressed.material.kirchhoff_stress[0] - expected).norm(),
          0.,
          1e-12,
          name + ": rotation turns the stress");
      }
  }

  /** A point that is turned inside out is reported, not computed. */
  template <int dim>
  void
  check_inverted(const Material<dim>   &material,
                 const StressRule<dim> &rule,
                 const bool             needs_mid_point,
                 const std::string     &name)
  {
    StressBatch<dim> batch               = state_at<dim>(material, {}, 0.);
    batch.displacement_gradient[0]       = Tensor<2, dim>();
    batch.displacement_gradient[0][0][0] = -1.5;
    test::check(rule.evaluate(material, batch) == 0,
                name + ": an inverted point is reported");
    // inverted halfway only
    batch.displacement_gradient[0][1][1] = -2.5;
    test::check(rule.evaluate(material, batch) == (needs_mid_point ? 0 : 1),
                name + ": a point that is inverted halfway");
  }

  template <int dim>
  void
  check_all()
  {
    for (const Law<dim> &law : all_laws_and_soils<dim>())
      for (const std::string rule_name :
           {"conserving", "mid-point", "trapezoidal", "end-point"})
        {
          const std::string name =
            std::to_string(dim) + "D " + law.name + ", " + rule_name;
          const Material<dim>  &material     = *law.material;
          const StressRule<dim> rule         = stress_rule<dim>(rule_name);
          const bool            is_mid_point = rule_name == "mid-point";
          check_random<dim>(material, rule, !is_mid_point, false, name);
          if (!material.history().empty())
            check_random<dim>(
              material, rule, !is_mid_point, true, name + ", flowing");
          check_special<dim>(material, rule, !is_mid_point, name);
          check_inverted<dim>(material, rule, is_mid_point, name);
        }
    for (const Law<dim> &law : all_laws_and_soils<dim>())
      for (const bool is_flowing : {false, true})
        if (!is_flowing || !law.material->history().empty())
          {
            const auto state =
              state_at<dim>(*law.material, random_tensor<dim>(0.3), 0.05);
            const auto H = random_step<dim>(*law.material, state, is_flowing);
            check_tangent<dim>(*law.material,
                               static_stress_rule<dim>(),
                               state,
                               H,
                               1e-5,
                               5e-8,
                               law.name + ", static steps");
            const auto p =
              moved<dim>(*law.material, static_stress_rule<dim>(), state, H);
            const auto F = identity<dim>() + H;
            test::check_close(
              (p.nominal_stress[0] * transpose(F) -
               mandel::block<dim>(p.material.kirchhoff_stress[0]))
                .norm(),
              0.,
              1e-12 * p.material.kirchhoff_stress[0].norm(),
              law.name + ", static steps: the stress at the end");
          }
  }
} // namespace

int
main()
{
  check_all<2>();
  check_all<3>();
  return test::report();
}
