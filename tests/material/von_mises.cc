// Von Mises plasticity: the return ends on the yield surface, with the flow,
// stress and dissipation of closed forms; what is stored and dissipated has
// the stress as its derivative.

#include <emmy/material/von_mises.h>

#include <random>

#include "../check.h"

using namespace emmy;

namespace
{
  using test::check;
  using test::check_close;

  const double sqrt_two_thirds = std::sqrt(2. / 3.);

  ElasticConstants
  metal()
  {
    ElasticConstants constants;
    constants.density       = 5.;
    constants.young_modulus = 100.;
    constants.poisson_ratio = 0.3;
    return constants.completed("test");
  }

  /** The answer to a trial b^e with equivalent plastic strain @p xi. */
  template <int dim>
  MaterialBatch<dim>
  answer(const Material<dim>     &material,
         const MandelVector<dim> &b_trial,
         const double             xi = 0.)
  {
    MaterialBatch<dim> batch;
    batch.n_points                       = 1;
    batch.left_cauchy_green_less_unit[0] = b_trial - mandel::unit<dim>();
    batch.history.resize(material.history().size());
    for (auto &field : batch.history)
      field[0] = xi;
    material.evaluate(batch);
    return batch;
  }

  /** b^e with these principal logarithmic strains, along the axes. */
  template <int dim>
  MandelVector<dim>
  stretched(const std::array<double, 3> &strain)
  {
    constexpr auto    normal = mandel::normal_components<dim>();
    MandelVector<dim> b;
    for (unsigned int i = 0; i < 3; ++i)
      b[normal[i]] = std::exp(2. * strain[i]);
    return b;
  }

  /** |dev tau| */
  template <int dim>
  double
  deviator_norm(const MandelVector<dim> &tau)
  {
    const auto I = mandel::unit<dim>();
    return (tau - (tau * I / 3.) * I).norm();
  }

  template <int dim>
  MandelVector<dim>
  random_b(std::mt19937 &generator, const double size)
  {
    std::uniform_real_distribution<double> uniform(-size, size);
    dealii::Tensor<2, dim> F = dealii::unit_symmetric_tensor<dim>();
    for (unsigned int i = 0; i < dim; ++i)
      for (unsigned int j = 0; j < dim; ++j)
        F[i][j] += uniform(generator);
    return mandel::symmetric_part<dim>(F * transpose(F),
                                       std::exp(uniform(generator)));
  }

  /** Tension and pure shear, in both measures. */
  template <int dim>
  void
  check_closed_forms()
  {
    const std::string   name      = std::to_string(dim) + "D: ";
    const auto          constants = metal();
    const double        G = constants.shear_modulus, H = 20., yield = 10.;
    const VonMises<dim> uniaxial(constants, {sqrt_two_thirds * yield, H});
    const VonMises<dim> deviatoric(constants, {yield, 0.});

    // tension without change of volume: sqrt(3/2)|s| = 3 G e
    const double e = 0.3, xi_old = 0.1;
    const auto   b = stretched<dim>({{e, -0.5 * e, -0.5 * e}});
    {
      const auto   p    = answer<dim>(uniaxial, b, xi_old);
      const double flow = (3. * G * e - (yield + H * xi_old)) / (3. * G + H);
      const double xi   = xi_old + flow;
      check_close(p.history[0][0], xi, 1e-15, name + "tension, xi");
      check_close(p.kirchhoff_stress[0][0],
                  2. / 3. * (yield + H * xi),
                  1e-13,
                  name + "tension, stress");
      check_close(p.dissipation[0],
                  yield * flow,
                  1e-14,
                  name + "tension, dissipation");
      check_close(p.hardening_energy[0],
                  0.5 * H * xi * xi,
                  1e-15,
                  name + "tension, hardening energy");
      check_close(std::log1p(p.left_cauchy_green_less_unit[0][0]),
                  2. * (e - flow),
                  1e-14,
                  name + "tension, elastic strain");
    }
    {
      const auto   p    = answer<dim>(deviatoric, b);
      const double norm = std::sqrt(1.5) * e;
      const double flow = norm - yield / (2. * G);
      check_close(p.history[0][0],
                  sqrt_two_thirds * flow,
                  1e-15,
                  name + "deviatoric, xi");
      check_close(deviator_norm<dim>(p.kirchhoff_stress[0]),
                  yield,
                  1e-13,
                  name + "deviatoric, radius");
      check_close(p.dissipation[0],
                  yield * flow,
                  1e-14,
                  name + "deviatoric, dissipation");
      check(p.hardening_energy[0] == 0., name + "deviatoric does not harden");
    }
    // shear in its principal axes: yields at yield/sqrt(3), yield/sqrt(2)
    const double        g       = 0.2;
    const auto          sheared = stretched<dim>({{g, -g, 0.}});
    const VonMises<dim> perfect(constants, {sqrt_two_thirds * yield, 0.});
    check_close(answer<dim>(perfect, sheared).kirchhoff_stress[0][0],
                yield / std::sqrt(3.),
                1e-13,
                name + "shear, uniaxial measure");
    check_close(answer<dim>(deviatoric, sheared).kirchhoff_stress[0][0],
                yield / std::sqrt(2.),
                1e-13,
                name + "shear, deviatoric measure");

    // unload and reload
    const auto   loaded = answer<dim>(uniaxial, b);
    const double xi     = loaded.history[0][0];
    const double left =
      0.5 * std::log1p(loaded.left_cauchy_green_less_unit[0][0]);
    const auto unloaded_b =
      stretched<dim>({{0.5 * left, -0.25 * left, -0.25 * left}});
    const auto unloaded = answer<dim>(uniaxial, unloaded_b, xi);
    check(unloaded.dissipation[0] == 0. && unloaded.history[0][0] == xi &&
            unloaded.left_cauchy_green(0) == unloaded_b,
          name + "unloading is elastic");
    const auto reloaded =
      answer<dim>(uniaxial, loaded.left_cauchy_green(0), xi);
    check_close(reloaded.history[0][0], xi, 1e-15, name + "reloaded to yield");
    const double more = 1.01 * left;
    check(answer<dim>(uniaxial,
                      stretched<dim>({{more, -0.5 * more, -0.5 * more}}),
                      xi)
              .dissipation[0] > 0.,
          name + "flows when loaded further");
  }

  template <int dim>
  void
  check_random_states()
  {
    const std::string   name      = std::to_string(dim) + "D: ";
    const auto          constants = metal();
    const Hencky<dim>   elastic(constants);
    const VonMises<dim> never(constants, {1e10, 20.});
    std::mt19937        generator(11);

    for (const YieldSurface &surface :
         {YieldSurface{10., 0.}, YieldSurface{8., 20.}})
      {
        const VonMises<dim> material(constants, surface);
        const double        H         = surface.hardening_modulus;
        unsigned int        n_flowing = 0;
        for (unsigned int sample = 0; sample < 100; ++sample)
          {
            const double xi_old = 0.002 * sample;
            const auto   b      = random_b<dim>(generator, 0.003 * sample);
            const auto   p      = answer<dim>(material, b, xi_old);
            const double xi     = p.history[0][0];
            const double radius = surface.radius + sqrt_two_thirds * H * xi;
            const double norm   = deviator_norm<dim>(p.kirchhoff_stress[0]);
            check(norm <= radius * (1. + 1e-14), name + "within the surface");
            check(p.dissipation[0] >= 0. && xi >= xi_old,
                  name + "dissipation is not negative");

            // the stress and energy of the elastic deformation that is left
            const auto q = answer<dim>(elastic, p.left_cauchy_green(0));
            check_close((q.kirchhoff_stress[0] - p.kirchhoff_stress[0]).norm(),
                        0.,
                        1e-13 * constants.bulk_modulus,
                        name + "stress belongs to b^e");
            check_close(q.stored_energy[0],
                        p.stored_energy[0],
                        1e-13 * constants.bulk_modulus,
                        name + "energy belongs to b^e");

            if (p.dissipation[0] > 0.)
              {
                ++n_flowing;
                check_close(norm,
                            radius,
                            1e-13 * radius,
                            name + "on the surface");
                // flow times (tau : normal + hardening stress times its own)
                const double flow = (xi - xi_old) / sqrt_two_thirds;
                check_close(p.dissipation[0],
                            flow * (norm - sqrt_two_thirds * H * xi),
                            1e-13 * surface.radius,
                            name + "dissipation of the general formula");
              }
            else
              check(q.kirchhoff_stress[0] == p.kirchhoff_stress[0] &&
                      p.left_cauchy_green_less_unit[0] ==
                        b - mandel::unit<dim>(),
                    name + "elastic: as Hencky, to the last bit");
            const auto r = answer<dim>(never, b);
            const auto h = answer<dim>(elastic, b);
            check(r.kirchhoff_stress[0] == h.kirchhoff_stress[0] &&
                    r.stored_energy[0] == h.stored_energy[0] &&
                    r.spatial_tangent[0] == h.spatial_tangent[0],
                  name + "a high yield stress: Hencky to the last bit");
          }
        check(n_flowing > 20 && n_flowing < 100, name + "both regimes");
        std::cout << name << n_flowing << " of 100 states flow\n";
      }
  }

  /** d(psi + dissipation) = tau : d, for b -> (I + s L) b (I + s L)^T. */
  template <int dim>
  void
  check_stress_is_derivative()
  {
    const std::string                      name = std::to_string(dim) + "D: ";
    const VonMises<dim>                    material(metal(), {5., 20.});
    std::mt19937                           generator(13);
    std::uniform_real_distribution<double> uniform(-1., 1.);
    unsigned int                           n_differentiated = 0;
    for (unsigned int sample = 0; sample < 20; ++sample)
      {
        const auto             b = random_b<dim>(generator, 0.3);
        dealii::Tensor<2, dim> L;
        for (unsigned int i = 0; i < dim; ++i)
          for (unsigned int j = 0; j < dim; ++j)
            L[i][j] = uniform(generator);
        const auto moved = [&](const double s) {
          const dealii::Tensor<2, dim> I = dealii::unit_symmetric_tensor<dim>();
          return answer<dim>(material,
                             mandel::congruence<dim>(I + s * L) * b,
                             0.05);
        };
        const auto total = [&](const double s) {
          const auto p = moved(s);
          return p.stored_energy[0] + p.hardening_energy[0] + p.dissipation[0];
        };
        const auto   at_b = moved(0.);
        const double work =
          at_b.kirchhoff_stress[0] * mandel::symmetric_part<dim>(L);
        const auto error = [&](const double s) {
          return std::abs((total(s) - total(-s)) / (2. * s) - work);
        };
        if (at_b.dissipation[0] > 0.05) // differences stay in one regime
          {
            ++n_differentiated;
            check_close(error(1e-5),
                        0.,
                        1e-6,
                        name + "stress is the derivative of the energies");
            check_close(error(2e-3) / error(1e-3), 4., 0.3, name + "order");
          }
      }
    check(n_differentiated >= 15,
          name + "only " + std::to_string(n_differentiated) +
            " of 20 states flow enough to be differentiated");
  }
} // namespace

int
main()
{
  check_closed_forms<2>();
  check_closed_forms<3>();
  check_random_states<2>();
  check_random_states<3>();
  check_stress_is_derivative<2>();
  check_stress_is_derivative<3>();
  return test::report();
}
