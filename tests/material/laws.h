#ifndef emmy_tests_material_laws_h
#define emmy_tests_material_laws_h

#include <deal.II/base/symmetric_tensor.h>

#include <emmy/material/drucker_prager.h>
#include <emmy/material/neo_hooke.h>
#include <emmy/material/stress_rules.h>
#include <emmy/material/von_mises.h>
#include <emmy/math/kinematics.h>

#include <memory>
#include <random>

#include "../check.h"

/** What tests of materials and stress rules share: one point, and its steps. */
namespace emmy
{
  namespace test
  {
    inline std::mt19937 generator(7);

    template <int dim>
    dealii::Tensor<2, dim>
    random_tensor(const double size)
    {
      std::uniform_real_distribution<double> uniform(-size, size);
      dealii::Tensor<2, dim>                 a;
      for (unsigned int i = 0; i < dim; ++i)
        for (unsigned int j = 0; j < dim; ++j)
          a[i][j] = uniform(generator);
      return a;
    }

    template <int dim>
    dealii::Tensor<2, dim>
    identity()
    {
      return dealii::unit_symmetric_tensor<dim>();
    }

    template <int dim>
    struct Law
    {
      std::string                    name;
      std::unique_ptr<Material<dim>> material;
    };

    /**
     * Every material, yielding ones at a tenth of their stiffness times
     * @p yield_scale.
     */
    template <int dim>
    std::vector<Law<dim>>
    all_laws(const double yield_scale = 1.)
    {
      ElasticConstants constants;
      constants.density       = 5.;
      constants.young_modulus = 100.;
      constants.poisson_ratio = 0.3;
      constants               = constants.completed("test");

      std::vector<Law<dim>> laws;
      laws.push_back({"Hencky", std::make_unique<Hencky<dim>>(constants)});
      laws.push_back(
        {"von Mises",
         std::make_unique<VonMises<dim>>(constants,
                                         YieldSurface{10. * yield_scale, 0.})});
      laws.push_back(
        {"von Mises, hardening",
         std::make_unique<VonMises<dim>>(constants,
                                         YieldSurface{8. * yield_scale, 20.})});
      laws.push_back({"neo-Hooke", std::make_unique<NeoHooke<dim>>(constants)});
      return laws;
    }

    /** The same, and soils. */
    template <int dim>
    std::vector<Law<dim>>
    all_laws_and_soils()
    {
      std::vector<Law<dim>> laws = all_laws<dim>();
      ElasticConstants      constants;
      constants.density       = 5.;
      constants.young_modulus = 100.;
      constants.poisson_ratio = 0.3;
      constants               = constants.completed("test");
      // little friction: tests stay on the cone, whose apex is far
      for (const double dilation : {0.15, 0.})
        laws.push_back(
          {dilation > 0. ? "Drucker-Prager" : "Drucker-Prager, no dilation",
           std::make_unique<DruckerPrager<dim>>(
             constants, DruckerPragerSurface{0.15, dilation, 7., 45.})});
      return laws;
    }

    /**
     * The state at t of one point that went from rest to b = F F^T in one
     * step: material and yield stress permitting, with flow.
     *
     * @param G   F - I
     * @param b33 in plane strain, b_33 - 1
     */
    template <int dim>
    StressBatch<dim>
    state_at(const Material<dim>          &material,
             const dealii::Tensor<2, dim> &G,
             const double                  b33)
    {
      MandelVector<dim> b = left_cauchy_green_less_unit<dim>(G, {});
      if (dim == 2)
        b[n_mandel<dim> - 1] = b33;

      StressBatch<dim> batch;
      batch.n_points                           = 1;
      batch.is_inelastic                       = !material.history().empty();
      batch.left_cauchy_green_less_unit_old[0] = b;

      MaterialBatch<dim> state;
      state.n_points                       = 1;
      state.left_cauchy_green_less_unit[0] = b;
      state.history.resize(material.history().size());
      material.evaluate(state);
      batch.kirchhoff_stress_old[0] = state.kirchhoff_stress[0];
      batch.stored_energy_old[0]    = state.stored_energy[0];
      batch.material.history        = state.history;
      if (batch.is_inelastic)
        {
          batch.elastic_left_cauchy_green_less_unit_old[0] =
            state.left_cauchy_green_less_unit[0];
          batch.hardening_energy_old[0] = state.hardening_energy[0];
        }
      return batch;
    }

    /** The state after a step H. */
    template <int dim>
    StressBatch<dim>
    moved(const Material<dim>          &material,
          const StressRule<dim>        &rule,
          StressBatch<dim>              batch,
          const dealii::Tensor<2, dim> &H)
    {
      batch.displacement_gradient[0] = H;
      test::check(rule.evaluate(material, batch) == 1, "det F > 0");
      return batch;
    }
  } // namespace test
} // namespace emmy

#endif
