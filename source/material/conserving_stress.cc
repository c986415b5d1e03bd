#include <emmy/material/conserving_stress.h>
#include <emmy/math/kinematics.h>

namespace emmy
{
  namespace
  {
    /** Below this ratio |C - C_t| / |C_t| the energy correction is dropped. */
    constexpr double smallest_increment = 1e-8;

    /**
     * dP/dH from C = 2 dS/d(Delta C) and S:
     * P_iJ = Fm_iM S_MJ, so that
     * dP_iJ/dH_mL = 1/2 delta_im S_JL + Fm_iM C_MJKL Delta F_mK.
     */
    template <int dim>
    dealii::Tensor<2, dim * dim>
    nominal_tangent(const StepKinematics<dim> &step,
                    const MandelVector<dim>   &S,
                    const MandelMatrix<dim>   &C)
    {
      constexpr auto         ij = mandel::pairs<dim>();
      constexpr unsigned int m  = n_in_plane<dim>;

      // G maps a symmetric tensor X to (F X)_iJ, for F = Fm and Delta F
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
      const auto row    = left_product(step.increment_mid);
      const auto column = left_product(step.increment);

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
  } // namespace

  template <int dim>
  unsigned int
  conserving_stress(const Material<dim> &material, StressBatch<dim> &batch)
  {
    std::array<StepKinematics<dim>, max_batch_points> steps;

    batch.material.n_points     = batch.n_points;
    batch.material.with_tangent = batch.with_tangent;
    for (unsigned int p = 0; p < batch.n_points; ++p)
      {
        const auto &H = batch.displacement_gradient[p];
        steps[p]      = step_kinematics<dim>(H);
        // also catches NaN
        if (!(dealii::determinant(steps[p].increment) > 0.))
          return p;
        batch.material.left_cauchy_green[p] =
          mandel::congruence<dim>(steps[p].increment) *
          batch.left_cauchy_green_old[p];
      }

    material.evaluate(batch.material);

    for (unsigned int p = 0; p < batch.n_points; ++p)
      {
        const auto &step  = steps[p];
        const auto &A     = step.metric_change;
        const auto  b_old = mandel::block<dim>(batch.left_cauchy_green_old[p]);
        const auto  Q     = mandel::congruence<dim>(step.increment_inverse);
        const auto  Q_b   = mandel::congruence<dim>(b_old);

        const MandelVector<dim> S1 = Q * batch.material.kirchhoff_stress[p];
        const MandelVector<dim> S_average =
          0.5 * (batch.kirchhoff_stress_old[p] + S1);
        const MandelVector<dim> B  = Q_b * A;
        const double            nu = A * B; // |C - C_t|^2

        // |C_t|^2 = b_t : b_t
        const bool is_corrected =
          nu > smallest_increment * smallest_increment *
                 batch.left_cauchy_green_old[p].norm_square();
        const double energy_change =
          batch.material.stored_energy[p] - batch.stored_energy_old[p];
        const double correction =
          is_corrected ? (2. * energy_change - S_average * A) / nu : 0.;

        const MandelVector<dim> S = S_average + correction * B;
        batch.nominal_stress[p]   = step.increment_mid * mandel::block<dim>(S);

        if (!batch.with_tangent)
          continue;
        const MandelMatrix<dim> dS1 =
          0.5 * mandel::transform<dim>(Q, batch.material.spatial_tangent[p]);
        MandelMatrix<dim> dS = 0.5 * dS1;
        if (is_corrected)
          {
            const MandelVector<dim> gradient =
              (S1 - S_average - 0.5 * (A * dS1) - (2. * correction) * B) / nu;
            dS += correction * Q_b + outer_product(B, gradient);
          }
        batch.tangent[p] = nominal_tangent<dim>(step, S, 2. * dS);
      }
    return batch.n_points;
  }

  template unsigned int
  conserving_stress<2>(const Material<2> &, StressBatch<2> &);
  template unsigned int
  conserving_stress<3>(const Material<3> &, StressBatch<3> &);
} // namespace emmy
