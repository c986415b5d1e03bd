#include <emmy/base/exceptions.h>
#include <emmy/material/conserving_stress.h>
#include <emmy/material/static_stress.h>
#include <emmy/material/strain_update.h>
#include <emmy/math/kinematics.h>

#include <memory>

namespace emmy
{
  namespace
  {
    /**
     * Where |C - C_t| is above this part of the elastic strain, a difference of
     * energies is good enough, and cheaper: its error, divided by the step, is
     * at most 1e-14 of the stress.
     */
    constexpr double largest_small_step = 0.01;

    /** Whether a point of the batch strains less than that. */
    template <int dim>
    bool
    has_small_step(const unsigned int       n_points,
                   const double            *squares_of_change,
                   const MandelVector<dim> *elastic_old)
    {
      for (unsigned int p = 0; p < n_points; ++p)
        if (squares_of_change[p] < largest_small_step * largest_small_step *
                                     elastic_old[p].norm_square())
          return true;
      return false;
    }
  } // namespace

  template <int dim>
  unsigned int
  update_states(const Material<dim> &material,
                StressBatch<dim>    &batch,
                const bool           with_energy_change)
  {
    typename StressBatch<dim>::template PerPoint<double> determinants, squares;

    const dealii::Tensor<2, dim> *H = batch.displacement_gradient.data();
    const MandelVector<dim>      *elastic_old =
      (batch.is_inelastic ? batch.elastic_left_cauchy_green_less_unit_old
                          : batch.left_cauchy_green_less_unit_old)
        .data();
    const StrainMeasures measures{determinants.data(), squares.data()};
    if (batch.is_inelastic)
      update_strains<dim>(H,
                          batch.left_cauchy_green_less_unit_old.data(),
                          batch.n_points,
                          batch.left_cauchy_green_less_unit.data(),
                          measures);
    update_strains<dim>(H,
                        elastic_old,
                        batch.n_points,
                        batch.material.left_cauchy_green_less_unit.data(),
                        measures);
    for (unsigned int p = 0; p < batch.n_points; ++p)
      if (!(determinants[p] > 0.)) // also catches NaN
        return p;

    batch.material.n_points     = batch.n_points;
    batch.material.with_tangent = batch.with_tangent;
    batch.material.with_energy_change =
      with_energy_change && material.gives_energy_change() &&
      has_small_step<dim>(batch.n_points, squares.data(), elastic_old);
    batch.material.step = {H, elastic_old, batch.kirchhoff_stress_old.data()};
    material.evaluate(batch.material);
    return batch.n_points;
  }

  template <int dim>
  dealii::Tensor<2, dim * dim>
  nominal_tangent(const dealii::Tensor<2, dim> &Fm,
                  const dealii::Tensor<2, dim> &F,
                  const MandelVector<dim>      &S,
                  const MandelMatrix<dim>      &C)
  {
    constexpr auto         ij = mandel::pairs<dim>();
    constexpr unsigned int m  = n_in_plane<dim>;

    // G maps a symmetric tensor X to (F X)_iJ, for F = Fm and F
    const auto left_product = [&ij](const dealii::Tensor<2, dim> &F) {
      std::array<std::array<double, m>, dim * dim> G{};
      for (unsigned int a = 0; a < m; ++a)
        for (unsigned int i = 0; i < dim; ++i)
          {
            const unsigned int M = ij[a][0], J = ij[a][1];
            if (a < dim)
              G[i * dim + J][a] = F[i][M];
            else
              {
                G[i * dim + J][a] = F[i][M] / mandel::sqrt2;
                G[i * dim + M][a] = F[i][J] / mandel::sqrt2;
              }
          }
      return G;
    };
    const auto row    = left_product(Fm);
    const auto column = left_product(F);

    dealii::Tensor<2, dim * dim> result;
    for (unsigned int r = 0; r < dim * dim; ++r)
      {
        std::array<double, m> row_C{};
        for (unsigned int a = 0; a < m; ++a)
          for (unsigned int b = 0; b < m; ++b)
            row_C[b] += row[r][a] * C[a][b];
        for (unsigned int c = 0; c < dim * dim; ++c)
          {
            double sum = 0.;
            for (unsigned int b = 0; b < m; ++b)
              sum += row_C[b] * column[c][b];
            result[r][c] = sum;
          }
      }
    const auto S_block = mandel::block<dim>(S);
    for (unsigned int i = 0; i < dim; ++i)
      for (unsigned int J = 0; J < dim; ++J)
        for (unsigned int L = 0; L < dim; ++L)
          result[i * dim + J][i * dim + L] += 0.5 * S_block[J][L];
    return result;
  }

  namespace
  {
    template <int dim>
    using Steps = std::array<StepKinematics<dim>, max_batch_points>;

    /**
     * What all rules share: the states at the end, and kinematics.
     * @return index of the first inverted point, n_points if there is none.
     */
    template <int dim>
    unsigned int
    evaluate_end(const Material<dim> &material,
                 StressBatch<dim>    &batch,
                 Steps<dim>          &steps)
    {
      const unsigned int inverted = update_states(material, batch);
      if (inverted == batch.n_points)
        for (unsigned int p = 0; p < batch.n_points; ++p)
          steps[p] = step_kinematics<dim>(batch.displacement_gradient[p]);
      return inverted;
    }

    /** S = (1 - weight) tau_t + weight S1. */
    template <int dim>
    unsigned int
    weighted(const double         weight,
             const Material<dim> &material,
             StressBatch<dim>    &batch)
    {
      Steps<dim>         steps;
      const unsigned int inverted = evaluate_end(material, batch, steps);
      if (inverted < batch.n_points)
        return inverted;

      for (unsigned int p = 0; p < batch.n_points; ++p)
        {
          const auto &step = steps[p];
          const auto  Q    = mandel::congruence<dim>(step.increment_inverse);
          const MandelVector<dim> S =
            (1. - weight) * batch.kirchhoff_stress_old[p] +
            weight * (Q * batch.material.kirchhoff_stress[p]);
          batch.nominal_stress[p] = step.increment_mid * mandel::block<dim>(S);
          if (batch.with_tangent)
            batch.tangent[p] = nominal_tangent<dim>(
              step.increment_mid,
              step.increment,
              S,
              weight *
                mandel::transform<dim>(Q, batch.material.spatial_tangent[p]));
        }
      return batch.n_points;
    }

    template <int dim>
    unsigned int
    trapezoidal(const Material<dim> &material, StressBatch<dim> &batch)
    {
      return weighted(0.5, material, batch);
    }

    template <int dim>
    unsigned int
    end_point(const Material<dim> &material, StressBatch<dim> &batch)
    {
      return weighted(1., material, batch);
    }

    template <int dim>
    unsigned int
    at_rest(const Material<dim> &material, StressBatch<dim> &batch)
    {
      Steps<dim>         steps;
      const unsigned int inverted = evaluate_end(material, batch, steps);
      if (inverted < batch.n_points)
        return inverted;

      for (unsigned int p = 0; p < batch.n_points; ++p)
        {
          const auto &step = steps[p];
          const auto  Q    = mandel::congruence<dim>(step.increment_inverse);
          const MandelVector<dim> S = Q * batch.material.kirchhoff_stress[p];
          batch.nominal_stress[p]   = step.increment * mandel::block<dim>(S);
          // the increment grows with dH, not dH/2 as that of the middle: its
          // share, 1/2 S, is wanted twice
          if (batch.with_tangent)
            batch.tangent[p] =
              nominal_tangent<dim>(
                step.increment,
                step.increment,
                S,
                mandel::transform<dim>(Q, batch.material.spatial_tangent[p])) +
              nominal_tangent<dim>(step.increment, step.increment, S, {});
        }
      return batch.n_points;
    }

    template <int dim>
    unsigned int
    mid_point(const Material<dim> &material, StressBatch<dim> &batch)
    {
      // the step to the mid-point, as if it were a step
      const auto mid        = std::make_unique<StressBatch<dim>>();
      mid->n_points         = batch.n_points;
      mid->with_tangent     = batch.with_tangent;
      mid->is_inelastic     = batch.is_inelastic;
      mid->material.history = batch.material.history;
      mid->left_cauchy_green_less_unit_old =
        batch.left_cauchy_green_less_unit_old;
      mid->elastic_left_cauchy_green_less_unit_old =
        batch.elastic_left_cauchy_green_less_unit_old;
      for (unsigned int p = 0; p < batch.n_points; ++p)
        mid->displacement_gradient[p] = 0.5 * batch.displacement_gradient[p];

      Steps<dim>   steps;
      unsigned int inverted = evaluate_end(material, batch, steps);
      if (inverted == batch.n_points)
        inverted = evaluate_end(material, *mid, steps);
      if (inverted < batch.n_points)
        return inverted;

      for (unsigned int p = 0; p < batch.n_points; ++p)
        {
          const auto &step = steps[p];
          const auto  Q    = mandel::congruence<dim>(step.increment_inverse);
          const MandelVector<dim> S = Q * mid->material.kirchhoff_stress[p];
          batch.nominal_stress[p]   = step.increment * mandel::block<dim>(S);
          // S depends on the mid-point's C, and d(mid-point's F) = dH/2
          if (batch.with_tangent)
            batch.tangent[p] = nominal_tangent<dim>(
              step.increment,
              step.increment,
              S,
              0.5 *
                mandel::transform<dim>(Q, mid->material.spatial_tangent[p]));
        }
      return batch.n_points;
    }
  } // namespace

  EffectCard
  stress_rule_card(const std::string &name)
  {
    EffectCard card;
    card.is_present = name != "conserving";
    card.name       = stress_rule_effect;
    card.setting    = "Method/Stress rule other than conserving";
    card.enters     = "Newton: " + (card.is_present ? name : "another") +
                  " stress in place of the conserving one";
    card.ledger_columns = {"stress_rule_loss"};
    return card;
  }

  std::string
  stress_rule_names()
  {
    return "conserving|mid-point|trapezoidal|end-point";
  }

  template <int dim>
  StressRule<dim>
  stress_rule(const std::string &name)
  {
    if (name == "conserving")
      return {&conserving_stress<dim>, true};
    if (name == "mid-point")
      return {&mid_point<dim>, false};
    if (name == "trapezoidal")
      return {&trapezoidal<dim>, false};
    AssertThrow(name == "end-point",
                ExcParameter("Method",
                             "Stress rule",
                             name,
                             "it must be one of " + stress_rule_names() + "."));
    return {&end_point<dim>, false};
  }

  template <int dim>
  StressRule<dim>
  static_stress_rule()
  {
    return {&at_rest<dim>, false};
  }

#define INSTANTIATE(dim)                                      \
  template dealii::Tensor<2, dim * dim> nominal_tangent<dim>( \
    const dealii::Tensor<2, dim> &,                           \
    const dealii::Tensor<2, dim> &,                           \
    const MandelVector<dim> &,                                \
    const MandelMatrix<dim> &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE

  template StressRule<2>
  static_stress_rule<2>();
  template StressRule<3>
  static_stress_rule<3>();
  template StressRule<2>
  stress_rule<2>(const std::string &);
  template StressRule<3>
  stress_rule<3>(const std::string &);

  template unsigned int
  update_states<2>(const Material<2> &, StressBatch<2> &, const bool);
  template unsigned int
  update_states<3>(const Material<3> &, StressBatch<3> &, const bool);
} // namespace emmy
