#include <emmy/material/principal_axes.h>
#include <emmy/material/principal_lanes.h>

#include <algorithm>

// vectors stay within this file
#pragma GCC diagnostic ignored "-Wpsabi"

namespace emmy
{
  namespace
  {
    /** (ln(1 + x) - ln(1 + y))/(x - y) */
    inline double
    divided_logarithm(const double x, const double y)
    {
      const double reciprocal = 1. / (2. + x + y);
      const double z          = (x - y) * reciprocal;
      return 2. * reciprocal *
             (z * z > 1e-3 ? std::log((1. + x) / (1. + y)) / (2. * z)
                           : artanh_quotient(z * z));
    }
  } // namespace

  namespace
  {
    template <int dim>
    EMMY_INLINE void
    turn_side(const PrincipalLanes<dim> &p, double *tangents)
    {
      constexpr auto         ij = mandel::pairs<dim>();
      constexpr unsigned int m  = n_in_plane<dim>;
      constexpr unsigned int n  = n_mandel<dim>;
      const auto            &V  = p.vectors;
      Lanes                  Q[m][m], Qc[m][m]; // as mandel::congruence()
      Lanes                  result[n][n];
      for (unsigned int a = 0; a < m; ++a)
        {
          const unsigned int i = ij[a][0], j = ij[a][1];
          for (unsigned int c = 0; c < dim; ++c)
            Q[a][c] = V[i][c] * V[j][c] * (a < dim ? 1. : mandel::sqrt2);
          for (unsigned int c = dim; c < m; ++c)
            {
              const unsigned int k = ij[c][0], l = ij[c][1];
              Q[a][c] = (V[i][k] * V[j][l] + V[i][l] * V[j][k]) *
                        (a < dim ? 1. / mandel::sqrt2 : 1.);
            }
        }
      for (unsigned int a = 0; a < m; ++a)
        {
          for (unsigned int b = 0; b < dim; ++b)
            {
              Qc[a][b] = Q[a][0] * p.normal[0][b];
              for (unsigned int k = 1; k < dim; ++k)
                Qc[a][b] += Q[a][k] * p.normal[k][b];
            }
          for (unsigned int b = dim; b < m; ++b)
            Qc[a][b] = Q[a][b] * p.shear[b - dim];
        }
      for (unsigned int a = 0; a < m; ++a)
        for (unsigned int b = 0; b <= a; ++b)
          {
            Lanes sum = Qc[a][0] * Q[b][0];
            for (unsigned int k = 1; k < m; ++k)
              sum += Qc[a][k] * Q[b][k];
            result[a][b] = result[b][a] = sum;
          }
      if constexpr (dim == 2)
        {
          for (unsigned int a = 0; a < m; ++a)
            result[3][a] = result[a][3] =
              Q[a][0] * p.normal[0][2] + Q[a][1] * p.normal[1][2];
          result[3][3] = p.normal[2][2];
        }
      write_points<n * n>(result[0], p.points, tangents);
    }
  } // namespace

  namespace principal_axes_kernels
  {
    // no templates: those have no clones
    EMMY_CLONES void
    turn(const PrincipalLanes<2> &lanes, double *tangents)
    {
      turn_side<2>(lanes, tangents);
    }
    EMMY_CLONES void
    turn(const PrincipalLanes<3> &lanes, double *tangents)
    {
      turn_side<3>(lanes, tangents);
    }
  } // namespace principal_axes_kernels

  template <int dim>
  double
  quadratic_energy_change(const PrincipalStep<dim>         &step,
                          const SpectralDecomposition<dim> &start,
                          const MandelVector<dim>          &stress_old,
                          const dealii::Tensor<2, dim>     &H)
  {
    const auto                  &W     = start.vectors;
    const dealii::Tensor<2, dim> HW    = H * W,
                                 tau_W = mandel::block<dim>(stress_old) * W;
    // W^T A W, and X_ij = v_i . Delta F w_j
    const dealii::Tensor<2, dim> WHW = transpose(W) * HW;
    const dealii::Tensor<2, dim> A = WHW + transpose(WHW) + transpose(HW) * HW;
    const dealii::Tensor<2, dim> X = transpose(step.trial.vectors) * (W + HW);

    std::array<double, dim> tau_old{};
    dealii::Tensor<2, dim>  beta_A;
    for (unsigned int j = 0; j < dim; ++j)
      {
        for (unsigned int k = 0; k < dim; ++k)
          tau_old[j] += W[k][j] * tau_W[k][j];
        beta_A[j] = (1. + start.values[j]) * A[j];
      }
    const dealii::Tensor<2, dim> Y = X * beta_A;

    double elastic = 0., plastic = 0.;
    for (unsigned int i = 0; i < dim; ++i)
      {
        const double x             = step.trial.values[i];
        const double inverse_alpha = 1. / (1. + x);
        double       sum = 0., stress_old_i = 0.; // p_i . tau_t p_i
        for (unsigned int j = 0; j < dim; ++j)
          {
            // p_i . w_j is the root of beta_j/alpha_i times X_ij, and
            // p_i . (a - b_t) w_j the same times Y_ij
            const double y     = start.values[j];
            const double share = (1. + y) * X[i][j];
            sum += divided_logarithm(x, y) * (step.stress[i] + tau_old[j]) *
                   share * Y[i][j];
            stress_old_i += tau_old[j] * share * X[i][j];
          }
        elastic += inverse_alpha * sum;
        plastic +=
          step.flow[i] * (step.stress[i] + inverse_alpha * stress_old_i);
      }
    if constexpr (dim == 2)
      plastic += step.flow[2] * (step.stress[2] + stress_old[3]);
    return 0.25 * elastic - 0.5 * plastic;
  }

  template <int dim>
  void
  fill_energy_changes(const PrincipalStep<dim> *steps,
                      MaterialBatch<dim>       &batch)
  {
    std::array<SpectralDecomposition<dim>, max_batch_points> start;
    spectral_decompositions<dim>(batch.step.left_cauchy_green_less_unit_old,
                                 batch.n_points,
                                 start.data());
    for (unsigned int p = 0; p < batch.n_points; ++p)
      batch.stored_energy_change[p] =
        quadratic_energy_change<dim>(steps[p],
                                     start[p],
                                     batch.step.kirchhoff_stress_old[p],
                                     batch.step.displacement_gradient[p]);
    if constexpr (dim == 2)
      if (batch.step.out_of_plane)
        for (unsigned int p = 0; p < batch.n_points; ++p)
          batch.stored_energy_change[p] +=
            0.5 * (steps[p].stress[2] + batch.step.kirchhoff_stress_old[p][3]) *
            std::log1p(batch.step.out_of_plane[p]);
  }

#define INSTANTIATE(dim)                                             \
  template double quadratic_energy_change<dim>(                      \
    const PrincipalStep<dim> &,                                      \
    const SpectralDecomposition<dim> &,                              \
    const MandelVector<dim> &,                                       \
    const dealii::Tensor<2, dim> &);                                 \
  template void fill_energy_changes<dim>(const PrincipalStep<dim> *, \
                                         MaterialBatch<dim> &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
