// Drucker-Prager: triaxial and biaxial tests follow their closed forms and end
// at the strength of Mohr and Coulomb, with the dilation that was asked for;
// the apex and the tension cut-off hold; no step gives energy back; what is
// stored and dissipated has the stress that the material states as its
// derivative.

#include <emmy/material/drucker_prager.h>

#include <functional>
#include <random>

#include "../check.h"

using namespace emmy;

namespace
{
  using test::check;
  using test::check_close;

  constexpr double degree = dealii::numbers::PI / 180.;
  constexpr double phi = 30. * degree, psi = 10. * degree;
  constexpr double c = 2e3; // Pa

  ElasticConstants
  soil()
  {
    ElasticConstants constants;
    constants.density       = 2000.;
    constants.young_modulus = 1e7;
    constants.poisson_ratio = 0.3;
    return constants.completed("test");
  }

  /** A point that keeps its state, and is strained along its axes. */
  struct Point
  {
    explicit Point(const DruckerPragerSurface &surface)
      : material(soil(), surface)
    {}

    /** The answer to these changes of logarithmic strain. */
    MaterialBatch<3>
    answer(const std::array<double, 3> &change) const
    {
      MaterialBatch<3> batch;
      batch.n_points = 1;
      for (unsigned int i = 0; i < 3; ++i)
        batch.left_cauchy_green_less_unit[0][i] =
          std::expm1(2. * (elastic[i] + change[i]));
      batch.history = {{{equivalent}}, {{volume}}};
      material.evaluate(batch);
      return batch;
    }

    void
    take(const std::array<double, 3> &change)
    {
      const auto batch = answer(change);
      for (unsigned int i = 0; i < 3; ++i)
        {
          elastic[i] =
            0.5 * std::log1p(batch.left_cauchy_green_less_unit[0][i]);
          stress[i] = batch.kirchhoff_stress[0][i];
          strain[i] += change[i];
        }
      equivalent = batch.history[0][0];
      volume     = batch.history[1][0];
      check(batch.dissipation[0] >= 0., "a step dissipates");
      dissipated += batch.dissipation[0];
    }

    const DruckerPrager<3> material;
    std::array<double, 3>  elastic{}, strain{}, stress{};
    double                 equivalent = 0., volume = 0., dissipated = 0.;
  };

  /** Where a growing function is zero, between two numbers. */
  double
  zero_of(const std::function<double(double)> &function,
          double                               lower,
          double                               upper)
  {
    for (unsigned int i = 0; i < 200; ++i)
      {
        const double middle                     = 0.5 * (lower + upper);
        (function(middle) < 0. ? lower : upper) = middle;
      }
    return 0.5 * (lower + upper);
  }

  constexpr double confinement = 1e4; // Pa

  /** Axial compression or extension with the lateral stress held. */
  void
  check_triaxial(const std::string &fit, const double sign)
  {
    const auto   surface = drucker_prager_fit({c, phi, psi}, fit);
    const auto   elastic = soil();
    const double K = elastic.bulk_modulus, E = elastic.young_modulus;
    Point        point(surface);
    const double e0 = -confinement / (3. * K);
    point.take({{e0, e0, e0}});
    // of Mohr and Coulomb: outer meets it in compression, inner in extension
    const double K_p      = std::pow(std::tan(45. * degree + 0.5 * phi), 2.);
    const double strength = sign < 0.
                              ? -confinement * K_p - 2. * c * std::sqrt(K_p)
                              : -confinement / K_p + 2. * c / std::sqrt(K_p);
    const double yield_strain = (strength + confinement) / E; // from e0
    double       worst = 0., worst_lateral = 0.;
    const double step = 0.3 * yield_strain;
    for (unsigned int i = 1; i <= 10; ++i)
      {
        const double lateral = zero_of(
          [&](const double e) {
            return point.answer({{e, e, step}}).kirchhoff_stress[0][0] +
                   confinement;
          },
          -0.1,
          0.1);
        point.take({{lateral, lateral, step}});
        const double axial = i * step; // from e0
        const double plastic =
          sign * std::max(0., sign * (axial - yield_strain));
        const double stress = -confinement + E * (axial - plastic);
        worst = std::max(worst, std::abs(point.stress[2] - stress));
        // of the flow: gamma (s/(2 t) + eta-bar/3), s_axial = sign 2 t/sqrt(3)
        const double gamma =
          plastic / (sign / std::sqrt(3.) + surface.dilation / 3.);
        const double expected =
          e0 - elastic.poisson_ratio * (axial - plastic) +
          gamma * (-sign * 0.5 / std::sqrt(3.) + surface.dilation / 3.);
        worst_lateral =
          std::max(worst_lateral, std::abs(point.strain[0] - expected));
        check_close(point.volume,
                    gamma * surface.dilation,
                    1e-10 * std::abs(yield_strain),
                    fit + ": plastic volume");
        check_close(point.equivalent,
                    gamma / std::sqrt(3.),
                    1e-10 * std::abs(yield_strain),
                    fit + ": equivalent plastic strain");
      }
    check_close(worst, 0., 1e-10 * confinement, fit + ": axial stress");
    check_close(worst_lateral,
                0.,
                1e-10 * std::abs(yield_strain),
                fit + ": lateral strain");
    check(point.dissipated > 0., fit + ": it has flowed");
  }

  /** Plane strain: the strength, and the angle of dilation. */
  void
  check_biaxial(const double dilation_angle)
  {
    const std::string name =
      "biaxial, dilation " + std::to_string(dilation_angle / degree) + ": ";
    Point point(drucker_prager_fit({c, phi, dilation_angle}, "plane strain"));
    const double K  = soil().bulk_modulus;
    const double e0 = -confinement / (3. * K);
    point.take({{e0, e0, e0}});
    std::array<double, 3> before{};
    for (unsigned int i = 0; i < 200; ++i)
      {
        before             = point.strain;
        const double axial = -1e-3, lateral = zero_of(
                                      [&](const double e) {
                                        return point.answer({{e, axial, 0.}})
                                                 .kirchhoff_stress[0][0] +
                                               confinement;
                                      },
                                      -0.1,
                                      0.1);
        point.take({{lateral, axial, 0.}});
      }
    const double K_p = std::pow(std::tan(45. * degree + 0.5 * phi), 2.);
    check_close(point.stress[1],
                -confinement * K_p - 2. * c * std::sqrt(K_p),
                1e-10 * confinement,
                name + "strength");
    const double x = point.strain[0] - before[0],
                 y = point.strain[1] - before[1];
    check_close((x + y) / (x - y),
                std::sin(dilation_angle),
                1e-10,
                name + "volume by shear");
  }

  /** What no friction is: the undrained strength, in plane strain. */
  void
  check_undrained()
  {
    const auto surface = drucker_prager_fit({c, 0., 0.}, "plane strain");
    check(surface.friction == 0. && surface.dilation == 0. &&
            surface.cohesion == c && std::isinf(surface.tension),
          "without friction: t = c");
  }

  template <int dim>
  void
  check_tension()
  {
    const auto           elastic = soil();
    const double         K       = elastic.bulk_modulus;
    DruckerPragerSurface surface = drucker_prager_fit({c, phi, psi}, "outer");
    const double         apex    = surface.cohesion / surface.friction;
    check_close(surface.tension, apex, 1e-12 * apex, "tension of the apex");
    check_close(apex, c / std::tan(phi), 1e-12 * apex, "c cot(phi)");
    for (const double tension : {apex, 0.4 * apex, 0.})
      {
        surface.tension = tension;
        const DruckerPrager<dim> material(elastic, surface);
        MaterialBatch<dim>       batch;
        batch.n_points   = 2;
        constexpr auto n = mandel::normal_components<dim>();
        // even expansion, and with shear
        const double e = 1e-2, shear = 2e-2;
        for (unsigned int i = 0; i < 3; ++i)
          {
            batch.left_cauchy_green_less_unit[0][n[i]] = std::expm1(2. * e);
            batch.left_cauchy_green_less_unit[1][n[i]] =
              std::expm1(2. * (e + (i == 0   ? shear
                                    : i == 1 ? -shear
                                             : 0.)));
          }
        batch.history = {{{0., 0.}}, {{0., 0.}}};
        material.evaluate(batch);
        const auto I = mandel::unit<dim>();
        for (unsigned int q = 0; q < 2; ++q)
          {
            check_close(batch.kirchhoff_stress[q] * I / 3.,
                        tension,
                        1e-10 * apex,
                        "mean stress at the cut-off");
            const auto s = batch.kirchhoff_stress[q] - tension * I;
            check_close(s.norm() / std::sqrt(2.),
                        q == 0 ? 0.
                               : surface.cohesion - surface.friction * tension,
                        1e-10 * apex,
                        "shear at the cut-off: none, and that of the cone");
            check_close(batch.history[1][q],
                        3. * e - tension / K,
                        1e-14,
                        "plastic volume at the cut-off");
            check(batch.dissipation[q] >= 0., "dissipation at the cut-off");
          }
      }
  }

  /** d(psi + D) = energy stress : de, along principal axes. */
  void
  check_energy_stress()
  {
    std::mt19937                           generator(3);
    std::uniform_real_distribution<double> uniform(-1., 1.);
    DruckerPragerSurface surface = drucker_prager_fit({c, phi, psi}, "outer");
    unsigned int         n_cone = 0, n_other = 0;
    double               worst = 0., largest_gap = 0., worst_tangent = 0.;
    for (const double tension : {surface.tension, 0.3 * surface.tension})
      {
        surface.tension = tension;
        const Point point(surface);
        for (unsigned int trial = 0; trial < 400; ++trial)
          {
            std::array<double, 3> e;
            const double          mean = 2e-3 * (uniform(generator) - 0.4);
            for (double &e_i : e)
              e_i = mean + 2e-3 * uniform(generator);
            const auto   at      = point.answer(e);
            const double delta   = 1e-7;
            bool         is_same = true;
            const auto   type    = [&surface](const MaterialBatch<3> &batch) {
              const auto I = mandel::unit<3>();
              return (batch.dissipation[0] > 0.) +
                     2 * (batch.kirchhoff_stress[0] * I / 3. >=
                          surface.tension * (1. - 1e-12)) +
                     4 * (batch.history[0][0] > 0.);
            };
            std::array<double, 3> slope;
            double                tangent_error = 0.;
            for (unsigned int i = 0; i < 3; ++i)
              {
                auto up = e, down = e;
                up[i] += delta;
                down[i] -= delta;
                const auto above = point.answer(up), below = point.answer(down);
                is_same =
                  is_same && type(above) == type(at) && type(below) == type(at);
                slope[i] = (above.stored_energy[0] + above.dissipation[0] -
                            below.stored_energy[0] - below.dissipation[0]) /
                           (2. * delta);
                // of the Lie derivative: d tau_j/d e_i - 2 tau_i delta_ij
                for (unsigned int j = 0; j < 3; ++j)
                  tangent_error =
                    std::max(tangent_error,
                             std::abs(
                               (above.kirchhoff_stress[0][j] -
                                below.kirchhoff_stress[0][j]) /
                                 (2. * delta) -
                               at.spatial_tangent[0][j][i] -
                               (i == j ? 2. * at.kirchhoff_stress[0][i] : 0.)));
              }
            if (!is_same)
              continue;
            worst_tangent =
              std::max(worst_tangent, tangent_error / soil().young_modulus);
            const double scale = at.kirchhoff_stress[0].norm() + c;
            for (unsigned int i = 0; i < 3; ++i)
              {
                worst =
                  std::max(worst,
                           std::abs(slope[i] - at.energy_stress[0][i]) / scale);
                largest_gap = std::max(largest_gap,
                                       std::abs(at.energy_stress[0][i] -
                                                at.kirchhoff_stress[0][i]) /
                                         scale);
              }
            (type(at) == 5 ? n_cone : n_other) += 1;
          }
      }
    check(n_cone > 50 && n_other > 50, "the cone and other cases are tried");
    check_close(worst, 0., 1e-6, "d(psi + D)/de is the energy stress");
    check_close(worst_tangent, 0., 1e-6, "the tangent is the derivative");
    check(largest_gap > 0.05,
          "which is not the stress where flow is not "
          "associated");
  }
} // namespace

int
main()
{
  check_triaxial("outer", -1.);
  check_triaxial("inner", 1.);
  for (const double angle : {0., psi, phi})
    check_biaxial(angle);
  check_undrained();
  check_tension<2>();
  check_tension<3>();
  check_energy_stress();
  return test::report();
}
