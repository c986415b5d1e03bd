#include <emmy/material/principal_axes.h>

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
    const dealii::Tensor<2, dim> X = transpose(step.trial.b.vectors) * (W + HW);

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
        const double x             = step.trial.b.values[i];
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
