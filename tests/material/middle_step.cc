// A step whose grid is undeformed in its middle: the stress of the middle is
// symmetric, works as that of the start does, and its tangent is its
// derivative; Delta F of the middle and of the start are one.

#include <emmy/material/hencky.h>
#include <emmy/material/middle_step.h>

#include <memory>
#include <random>

#include "../check.h"

using namespace emmy;
using dealii::Tensor;

namespace
{
  template <int dim>
  Tensor<2, dim>
  random_tensor(std::mt19937 &generator, const double size)
  {
    std::uniform_real_distribution<double> uniform(-size, size);
    Tensor<2, dim>                         a;
    for (unsigned int i = 0; i < dim; ++i)
      for (unsigned int j = 0; j < dim; ++j)
        a[i][j] = uniform(generator);
    return a;
  }

  template <int dim>
  class Point
  {
  public:
    explicit Point(const unsigned int seed)
      : generator(seed)
    {
      ElasticConstants constants;
      constants.density       = 1.;
      constants.young_modulus = 10.;
      constants.poisson_ratio = 0.3;
      material = std::make_unique<Hencky<dim>>(constants.completed("test"));
      F        = random_tensor<dim>(generator, 0.2);
      for (unsigned int d = 0; d < dim; ++d)
        F[d][d] += 1.;
      // the state at t is that of a first step from rest
      StressBatch<dim> &first        = *batch;
      first.n_points                 = 1;
      first.with_tangent             = false;
      first.displacement_gradient[0] = F;
      for (unsigned int d = 0; d < dim; ++d)
        first.displacement_gradient[0][d][d] -= 1.;
      first.left_cauchy_green_less_unit_old[0] = MandelVector<dim>();
      first.kirchhoff_stress_old[0]            = MandelVector<dim>();
      first.stored_energy_old[0]               = 0.;
      test::check(rule.evaluate(*material, first) == 1, "a step from rest");
      state  = first.material.left_cauchy_green_less_unit[0];
      stress = first.material.kirchhoff_stress[0];
      energy = first.material.stored_energy[0];
    }

    /** S-hat of a displacement gradient of the middle; work and P : H too. */
    Tensor<2, dim>
    evaluate(const Tensor<2, dim> &L, const bool with_tangent)
    {
      batch->with_tangent                       = with_tangent;
      batch->n_points                           = 1;
      batch->displacement_gradient[0]           = L;
      batch->left_cauchy_green_less_unit_old[0] = state;
      batch->kirchhoff_stress_old[0]            = stress;
      batch->stored_energy_old[0]               = energy;
      test::check(middle.to_start(*batch) == 1, "not turned inside out");
      H = batch->displacement_gradient[0];
      test::check(rule.evaluate(*material, *batch) == 1, "a step");
      work = scalar_product(batch->nominal_stress[0], H);
      middle.to_middle(*batch);
      return batch->nominal_stress[0];
    }

    std::mt19937                      generator;
    std::unique_ptr<Material<dim>>    material;
    const StressRule<dim>             rule = stress_rule<dim>("conserving");
    std::unique_ptr<StressBatch<dim>> batch =
      std::make_unique<StressBatch<dim>>();
    MiddleStep<dim>   middle;
    Tensor<2, dim>    F, H;
    MandelVector<dim> state, stress;
    double            energy = 0., work = 0.;
  };

  template <int dim>
  void
  check_point(const unsigned int seed)
  {
    Point<dim>           point(seed);
    const Tensor<2, dim> L       = random_tensor<dim>(point.generator, 0.3);
    const Tensor<2, dim> S       = point.evaluate(L, true);
    const auto           tangent = point.batch->tangent[0];
    const double         energy  = point.batch->material.stored_energy[0];
    const double         size    = S.norm();
    test::check_close((S - transpose(S)).norm(),
                      0.,
                      1e-14 * size,
                      "the stress of the middle is symmetric");
    test::check_close(scalar_product(S, L),
                      point.work,
                      1e-14 * size,
                      "it works as that of the start");
    test::check_close(scalar_product(S, L),
                      energy - point.energy,
                      1e-12 * size,
                      "its work is stored");
    // Delta F (I - L/2) = I + L/2
    Tensor<2, dim> increment = point.H, low = -0.5 * L, high = 0.5 * L;
    for (unsigned int d = 0; d < dim; ++d)
      {
        increment[d][d] += 1.;
        low[d][d] += 1.;
        high[d][d] += 1.;
      }
    test::check_close((increment * low - high).norm(),
                      0.,
                      1e-14,
                      "both halves of the step are one");
    for (unsigned int column = 0; column < dim * dim; ++column)
      {
        const double   step   = 1e-6;
        Tensor<2, dim> before = L, after = L;
        before[column / dim][column % dim] -= step;
        after[column / dim][column % dim] += step;
        const Tensor<2, dim> difference =
          (point.evaluate(after, false) - point.evaluate(before, false)) /
          (2. * step);
        for (unsigned int row = 0; row < dim * dim; ++row)
          test::check_close(tangent[row][column],
                            difference[row / dim][row % dim],
                            1e-8 * (size + 10.),
                            "the tangent is the derivative");
      }
  }
} // namespace

int
main()
{
  for (unsigned int seed = 1; seed <= 20; ++seed)
    {
      check_point<2>(seed);
      check_point<3>(seed);
    }
  return test::report();
}
