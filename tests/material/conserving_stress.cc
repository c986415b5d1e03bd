// The conserving stress stores exactly what it works, and its tangent is its
// derivative: on random states, for pure rotations, at equal eigenvalues and
// for vanishing increments.

#include <deal.II/base/symmetric_tensor.h>

#include <emmy/material/conserving_stress.h>
#include <emmy/material/hencky.h>

#include <memory>
#include <random>

#include "../check.h"

using namespace emmy;
using dealii::Tensor;

namespace
{
  std::mt19937 generator(7);

  template <int dim>
  Tensor<2, dim>
  random_tensor(const double size)
  {
    std::uniform_real_distribution<double> uniform(-size, size);
    Tensor<2, dim>                         a;
    for (unsigned int i = 0; i < dim; ++i)
      for (unsigned int j = 0; j < dim; ++j)
        a[i][j] = uniform(generator);
    return a;
  }

  template <int dim>
  Tensor<2, dim>
  identity()
  {
    return dealii::unit_symmetric_tensor<dim>();
  }

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

  template <int dim>
  std::unique_ptr<Material<dim>>
  rubber()
  {
    ElasticConstants constants;
    constants.density       = 5.;
    constants.young_modulus = 100.;
    constants.poisson_ratio = 0.3;
    return std::make_unique<Hencky<dim>>(constants.completed("test"));
  }

  /** One point with state b = F F^T that moves by H. */
  template <int dim>
  StressBatch<dim>
  point(const Material<dim>  &material,
        const Tensor<2, dim> &F,
        const double          b33,
        const Tensor<2, dim> &H)
  {
    StressBatch<dim> batch;
    batch.n_points                 = 1;
    batch.displacement_gradient[0] = H;
    batch.left_cauchy_green_old[0] =
      mandel::symmetric_part<dim>(F * transpose(F), b33);

    MaterialBatch<dim> state;
    state.n_points             = 1;
    state.left_cauchy_green[0] = batch.left_cauchy_green_old[0];
    material.evaluate(state);
    batch.kirchhoff_stress_old[0] = state.kirchhoff_stress[0];
    batch.stored_energy_old[0]    = state.stored_energy[0];

    test::check(conserving_stress(material, batch) == 1, "det F > 0");
    return batch;
  }

  template <int dim>
  Tensor<2, dim>
  stress(const Material<dim>  &material,
         const Tensor<2, dim> &F,
         const double          b33,
         const Tensor<2, dim> &H)
  {
    return point<dim>(material, F, b33, H).nominal_stress[0];
  }

  /**
   * Tangent against centred differences of size @p delta. The order of their
   * error is two, seen from differences of size 20 and 10 delta.
   */
  template <int dim>
  void
  check_tangent(const Material<dim>  &material,
                const Tensor<2, dim> &F,
                const double          b33,
                const Tensor<2, dim> &H,
                const double          delta,
                const double          tolerance,
                const std::string    &what)
  {
    const auto tangent = point<dim>(material, F, b33, H).tangent[0];
    const auto error   = [&](const double size) {
      Tensor<2, dim * dim> difference;
      for (unsigned int m = 0; m < dim; ++m)
        for (unsigned int L = 0; L < dim; ++L)
          {
            Tensor<2, dim> plus = H, minus = H;
            plus[m][L] += size;
            minus[m][L] -= size;
            const auto dP = (stress<dim>(material, F, b33, plus) -
                             stress<dim>(material, F, b33, minus)) /
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

  template <int dim>
  void
  check_all()
  {
    const std::string name     = std::to_string(dim) + "D";
    const auto        material = rubber<dim>();
    const auto        I        = identity<dim>();

    for (unsigned int sample = 0; sample < 20; ++sample)
      {
        const Tensor<2, dim> F   = I + random_tensor<dim>(0.3);
        const Tensor<2, dim> H   = random_tensor<dim>(0.2);
        const double         b33 = 1. + 0.1 * sample / 20.;
        const auto           p   = point<dim>(*material, F, b33, H);

        const double stored =
          p.material.stored_energy[0] - p.stored_energy_old[0];
        test::check_close(scalar_product(p.nominal_stress[0], H),
                          stored,
                          1e-14 * p.material.stored_energy[0] + 1e-14,
                          name + ": work of P equals the stored energy");

        // (I + H/2)^-1 P is symmetric: angular momentum
        const auto S = invert(I + 0.5 * H) * p.nominal_stress[0];
        test::check_close((S - transpose(S)).norm() / S.norm(),
                          0.,
                          1e-14,
                          name + ": S is symmetric");

        // an observer that turns during the step sees the turned stress
        const auto R      = rotation<dim>(0.7);
        const auto turned = point<dim>(*material, F, b33, R * (I + H) - I);
        test::check_close(
          (invert(I + 0.5 * (R * (I + H) - I)) * turned.nominal_stress[0] - S)
              .norm() /
            S.norm(),
          0.,
          1e-12,
          name + ": S does not depend on rotation");
      }

    // states with different, equal and nearly equal eigenvalues
    const Tensor<2, dim> F = I + random_tensor<dim>(0.2);
    const Tensor<2, dim> H = random_tensor<dim>(0.1);
    check_tangent<dim>(*material, F, 1.05, H, 1e-5, 2e-8, name + " general");
    check_tangent<dim>(*material, I, 1., H, 1e-5, 2e-8, name + " from rest");
    check_tangent<dim>(
      *material, I, 1., 0.05 * I, 1e-5, 2e-8, name + " equal eigenvalues");
    // the energy difference that the stress divides by |Delta C|^2 carries the
    // round-off of psi, so differences must not be too small
    check_tangent<dim>(
      *material, F, 1.05, 1e-2 * H, 1e-5, 2e-7, name + " small step");

    // zero increments: the limit of the tangent. A centred difference of the
    // corrected stress, which is smooth there
    {
      const auto           at_rest = point<dim>(*material, F, 1.05, 0. * H);
      const Tensor<2, dim> tau =
        mandel::block<dim>(at_rest.kirchhoff_stress_old[0]);
      test::check_close((at_rest.nominal_stress[0] - tau).norm(),
                        0.,
                        1e-13 * tau.norm(),
                        name + ": P = tau without motion");
      check_tangent<dim>(
        *material, F, 1.05, 0. * H, 1e-4, 1e-7, name + " zero increment");
    }

    // a rotation makes no new stress
    for (const double angle : {1e-9, 1e-3, 0.5, 2.})
      {
        const auto rest =
          point<dim>(*material, I, 1., rotation<dim>(angle) - I);
        test::check_close(rest.material.kirchhoff_stress[0].norm(),
                          0.,
                          2e-13,
                          name + ": rotation at rest");
        test::check_close(rest.nominal_stress[0].norm(),
                          0.,
                          2e-13,
                          name + ": rotation at rest, P");
        const auto turned =
          point<dim>(*material, F, 1.05, rotation<dim>(angle) - I);
        const auto R = rotation<dim>(angle);
        const auto expected =
          mandel::congruence<dim>(R) * turned.kirchhoff_stress_old[0];
        test::check_close(
          (turned.material.kirchhoff_stress[0] - expected).norm(),
          0.,
          1e-12,
          name + ": rotation turns the stress");
      }

    // a point that is turned inside out is reported, not computed
    StressBatch<dim> inverted         = point<dim>(*material, I, 1., 0. * H);
    inverted.displacement_gradient[0] = 0. * H;
    inverted.displacement_gradient[0][0][0] = -1.5;
    test::check(conserving_stress(*material, inverted) == 0,
                name + ": an inverted point is reported");
  }
} // namespace

int
main()
{
  check_all<2>();
  check_all<3>();
  return test::report();
}
