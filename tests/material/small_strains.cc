// Digits: strains and steps of any size, down to 1e-12 and far below, have
// stresses, energies and their changes to round-off of their own size, and the
// stress of a step is smooth enough for Newton.

#include <emmy/material/strain_update.h>
#include <emmy/math/lane_logarithm.h>

#include "laws.h"

// vectors stay within this file
#pragma GCC diagnostic ignored "-Wpsabi"

using namespace emmy;
using dealii::Tensor;
using test::all_laws;
using test::identity;
using test::Law;
using test::moved;
using test::random_tensor;
using test::state_at;

namespace
{
  /** 1/2 ln(I + e) and sqrt(I + e) - I by their series, for |e| below 0.05. */
  Tensor<2, 3>
  series(const Tensor<2, 3> &e, const bool is_root)
  {
    Tensor<2, 3> power = e, sum;
    double       root  = 0.5; // binomial coefficient
    for (unsigned int n = 1; n < 16; ++n)
      {
        sum += (is_root ? root : (n % 2 ? 0.5 : -0.5) / n) * power;
        power = power * e;
        root *= (0.5 - n) / (n + 1.);
      }
    return sum;
  }

  /** The stress of a strain, from the series of the logarithm. */
  void
  check_stress(const double size)
  {
    const auto   laws = all_laws<3>();
    const double K = 100. / (3. * 0.4), G = 100. / 2.6;
    double       error = 0., error_of_energy = 0.;
    for (unsigned int sample = 0; sample < 20; ++sample)
      {
        const auto state =
          state_at<3>(*laws[0].material, random_tensor<3>(size), 0.);
        const Tensor<2, 3> strain =
          series(mandel::block<3>(state.left_cauchy_green_less_unit_old[0]),
                 false);
        const Tensor<2, 3> deviator =
          strain - trace(strain) / 3. * identity<3>();
        const Tensor<2, 3> stress =
          K * trace(strain) * identity<3>() + 2. * G * deviator;
        const double energy =
          0.5 * K * trace(strain) * trace(strain) + G * deviator.norm_square();
        error = std::max(
          error,
          (mandel::block<3>(state.kirchhoff_stress_old[0]) - stress).norm() /
            stress.norm());
        error_of_energy =
          std::max(error_of_energy,
                   std::abs(state.stored_energy_old[0] / energy - 1.));
      }
    std::cout << "strain " << size << ": stress to " << error << ", energy to "
              << error_of_energy << '\n';
    test::check_close(error, 0., 2e-15, "stress of a small strain");
    test::check_close(error_of_energy, 0., 1e-14, "energy of a small strain");
  }

  /**
   * psi + D of a step as the work of the stress, 1/2 int S1 : A ds, along
   * C = I + s A, by Gauss' rule: the derivative of both is this stress.
   */
  double
  work_of_stress(const Material<3>    &material,
                 const StressBatch<3> &state,
                 const Tensor<2, 3>   &A)
  {
    const double points[]  = {0.,
                              0.5384693101056831,
                              -0.5384693101056831,
                              0.9061798459386640,
                              -0.9061798459386640},
                 weights[] = {0.5688888888888889,
                              0.4786286704993665,
                              0.4786286704993665,
                              0.2369268850561891,
                              0.2369268850561891};
    double work            = 0.;
    for (unsigned int q = 0; q < 5; ++q)
      {
        const Tensor<2, 3> H     = series(0.5 * (1. + points[q]) * A, true);
        StressBatch<3>     batch = state;
        batch.displacement_gradient[0] = H;
        update_states(material, batch);
        const Tensor<2, 3> inverse = invert(identity<3>() + H);
        const Tensor<2, 3> S1 =
          inverse * mandel::block<3>(batch.material.kirchhoff_stress[0]) *
          inverse;
        work += 0.25 * weights[q] * scalar_product(S1, A);
      }
    return work;
  }

  /** The change of energy that the stress of the step has worked. */
  void
  check_energy_change(const double strain, const double step)
  {
    const auto   rule      = stress_rule<3>("conserving");
    double       error     = 0.;
    unsigned int n_flowing = 0;
    for (const Law<3> &law : all_laws<3>(strain))
      for (unsigned int sample = 0; sample < 10; ++sample)
        {
          const Material<3> &material = *law.material;
          const auto         state =
            state_at<3>(material, random_tensor<3>(strain), 0.);
          // where flow goes on, and in one direction, the work is smooth
          if (state.is_inelastic && step > 2e-3 * strain)
            continue;
          Tensor<2, 3> H     = random_tensor<3>(step);
          const auto   forth = moved<3>(material, rule, state, 1e-3 * H);
          if (state.is_inelastic && forth.material.dissipation[0] == 0.)
            continue;
          n_flowing += state.is_inelastic;
          const Tensor<2, 3> A    = H + transpose(H) + transpose(H) * H;
          const auto         p    = moved<3>(material, rule, state, H);
          const double       work = work_of_stress(material, state, A);
          double             size = p.kirchhoff_stress_old[0].norm() +
                        p.material.kirchhoff_stress[0].norm();
          size *= A.norm();
          error =
            std::max(error,
                     std::abs(scalar_product(p.nominal_stress[0], H) - work) /
                       size);
        }
    std::cout << "strain " << strain << ", step " << step << ": work to "
              << error << ", " << n_flowing << " flow\n";
    // from steps of a hundredth of the strain on, energies are subtracted
    test::check_close(error,
                      0.,
                      step < 1e-3 * strain ? 1e-15 : 1e-14,
                      "P:H is the change of energy");
    test::check(n_flowing > 3 || step > 2e-3 * strain, "some flow");
  }

  /** Centred differences of P, whose noise would spoil them. */
  template <int dim>
  void
  check_tangent(const double strain, const double step)
  {
    const auto rule  = stress_rule<dim>("conserving");
    double     error = 0.;
    for (const Law<dim> &law : all_laws<dim>(strain))
      for (unsigned int sample = 0; sample < 3; ++sample)
        {
          const Material<dim> &material = *law.material;
          const auto           state =
            state_at<dim>(material, random_tensor<dim>(strain), 0.);
          const auto H = random_tensor<dim>(step);
          // whether it flows, and would a little earlier and later
          bool n[3];
          for (unsigned int i = 0; i < 3; ++i)
            n[i] = state.is_inelastic &&
                   moved<dim>(material, rule, state, (0.9 + 0.1 * i) * H)
                       .material.dissipation[0] > 0.;
          if (n[0] != n[1] || n[1] != n[2])
            continue;
          const auto dH     = random_tensor<dim>(1e-3 * step);
          const auto at     = moved<dim>(material, rule, state, H);
          const auto plus   = moved<dim>(material, rule, state, H + dH),
                     minus  = moved<dim>(material, rule, state, H - dH);
          Tensor<2, dim> dP = plus.nominal_stress[0] - minus.nominal_stress[0];
          const double   size = dP.norm();
          for (unsigned int i = 0; i < dim; ++i)
            for (unsigned int J = 0; J < dim; ++J)
              for (unsigned int m = 0; m < dim; ++m)
                for (unsigned int L = 0; L < dim; ++L)
                  dP[i][J] -=
                    2. * at.tangent[0][i * dim + J][m * dim + L] * dH[m][L];
          error = std::max(error, dP.norm() / size);
        }
    std::cout << dim << "D strain " << strain << ", step " << step
              << ": tangent to " << error << '\n';
    // the second difference, and what is left of the digits of the stress
    test::check_close(error,
                      0.,
                      5e-6 + 1e-11 * std::max(1., strain / step),
                      "tangent");
  }

  /** A step that is none, or whose square is no number, makes no NaN. */
  void
  check_nothing()
  {
    const auto rule = stress_rule<3>("conserving");
    for (const Law<3> &law : all_laws<3>())
      for (const double strain : {0., 1e-160, 1e-3})
        for (const double step : {0., 1e-200, 1e-150, 1e-100})
          {
            const auto state =
              state_at<3>(*law.material, random_tensor<3>(strain), 0.);
            const auto p =
              moved<3>(*law.material, rule, state, random_tensor<3>(step));
            const double size = 1000. * (10. * strain + 10. * step);
            test::check(p.nominal_stress[0].norm() <= size &&
                          p.tangent[0].norm() < 1e4,
                        law.name + ": a step of nothing");
          }
  }

  /** Points side by side have the strains that each has by itself. */
  template <int dim>
  void
  check_side_by_side()
  {
    constexpr unsigned int n = 11; // not a multiple of the lanes
    for (const double size : {0.3, 1e-6, 1e-12})
      {
        std::vector<Tensor<2, dim>>    H(n);
        std::vector<MandelVector<dim>> old(n), found(n);
        std::vector<double>            determinants(n), squares(n);
        for (unsigned int p = 0; p < n; ++p)
          {
            H[p]              = random_tensor<dim>(size);
            const auto strain = random_tensor<dim>(size);
            old[p]            = mandel::symmetric_part<dim>(strain, 0.1 * size);
          }
        update_strains<dim>(H.data(),
                            old.data(),
                            n,
                            found.data(),
                            {determinants.data(), squares.data()});
        for (unsigned int p = 0; p < n; ++p)
          {
            const auto alone  = left_cauchy_green_less_unit<dim>(H[p], old[p]);
            const auto change = step_kinematics<dim>(H[p]).metric_change;
            test::check((found[p] - alone).norm() <= 1e-15 * alone.norm(),
                        "strain of a point among others");
            test::check_close(determinants[p],
                              determinant(identity<dim>() + H[p]),
                              1e-15,
                              "its determinant");
            test::check_close(squares[p] / change.norm_square(),
                              1.,
                              1e-14,
                              "its change of metric");
          }
      }
  }

  /** Point 0 of a batch, as point p of another. */
  template <int dim>
  void
  put(const StressBatch<dim> &one, const unsigned int p, StressBatch<dim> &all)
  {
    all.displacement_gradient[p] = one.displacement_gradient[0];
    all.left_cauchy_green_less_unit_old[p] =
      one.left_cauchy_green_less_unit_old[0];
    all.elastic_left_cauchy_green_less_unit_old[p] =
      one.elastic_left_cauchy_green_less_unit_old[0];
    all.kirchhoff_stress_old[p] = one.kirchhoff_stress_old[0];
    all.stored_energy_old[p]    = one.stored_energy_old[0];
    all.hardening_energy_old[p] = one.hardening_energy_old[0];
    all.material.history.resize(one.material.history.size());
    for (unsigned int k = 0; k < one.material.history.size(); ++k)
      all.material.history[k][p] = one.material.history[k][0];
  }

  /** Points of a batch, elastic ones among plastic ones, have the stress and
   * the tangent that each has by itself. */
  template <int dim>
  void
  check_batches()
  {
    const auto rule = stress_rule<dim>("conserving");
    for (const Law<dim> &law : test::all_laws_and_soils<dim>())
      for (unsigned int n = 1; n <= max_batch_points;
           n              = n < 9 ? n + 1 : n + 23)
        {
                       StressBatch<dim>              all;
                       std::vector<StressBatch<dim>> alone;
                       all.n_points = n;
                       for (unsigned int p = 0; p < n; ++p)
            {
                           auto one = state_at<dim>(*law.material,
                                       random_tensor<dim>(p % 3 ? 0.1 : 1e-3),
                                       0.);
                           one.displacement_gradient[0] =
                             random_tensor<dim>(p % 2 ? 0.1 : 1e-4);
                           all.is_inelastic = one.is_inelastic;
                           put(one, p, all);
                           test::check(rule.evaluate(*law.material, one) == 1, "a step");
                           alone.push_back(one);
            }
          test::check(rule.evaluate(*law.material, all) == n, "all steps");
                       for (unsigned int p = 0; p < n; ++p)
            {
                           const auto &one = alone[p];
                           test::check_close(
                (all.nominal_stress[p] - one.nominal_stress[0]).norm() /
                  one.nominal_stress[0].norm(),
                0.,
                1e-12,
                law.name + ": stress of a point among others");
                           test::check_close((all.tangent[p] - one.tangent[0]).norm() /
                                  one.tangent[0].norm(),
                                0.,
                                1e-9,
                                law.name + ": its tangent");
            }
        }
  }

  /** Logarithms of four numbers at once, of any size. */
  void
  check_logarithms()
  {
    double error = 0.;
    for (double size = 1e-300; size < 1e15; size *= 1.07)
      {
        const double below = -size / (1. + size); // 1 + below: also near 0
        const Lanes  x     = {size, -std::min(size, 0.3), below, 0.};
        Lanes        result;
        log_one_plus(x, result);
        for (unsigned int lane = 0; lane < 3; ++lane)
          error =
            std::max(error, std::abs(result[lane] / std::log1p(x[lane]) - 1.));
        test::check(result[3] == 0., "ln 1 = 0");
      }
    test::check_close(error, 0., 1e-15, "logarithms of four numbers");
    const double none = std::numeric_limits<double>::quiet_NaN();
    const Lanes  x    = {-1. - 4e-16, -1., -1.5, none};
    Lanes        result;
    log_one_plus(x, result);
    for (unsigned int lane = 0; lane < n_lanes; ++lane)
      test::check(std::isnan(result[lane]), "no logarithm of what has none");
  }
} // namespace

int
main()
{
  check_logarithms();
  check_batches<2>();
  check_batches<3>();
  check_side_by_side<2>();
  check_side_by_side<3>();
  for (const double size : {1e-2, 1e-4, 1e-8, 1e-12, 1e-30, 1e-100})
    check_stress(size);
  for (const double strain : {0.1, 1e-3, 1e-6, 1e-12})
    for (const double step : {3e-3, 3e-5, 1e-5, 1e-8, 1e-12, 1e-16})
      check_energy_change(strain, step);
  for (const double strain : {0.1, 1e-3, 1e-6, 1e-12})
    for (const double step : {1e-3, 1e-5, 1e-8, 1e-12})
      {
        check_tangent<2>(strain, step);
        check_tangent<3>(strain, step);
      }
  check_nothing();
  return test::report();
}
