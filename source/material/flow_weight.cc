#include <emmy/material/flow_weight.h>
#include <emmy/material/principal_axes.h>

namespace emmy
{
  namespace
  {
    template <int dim>
    double
    deviator_norm(const MandelVector<dim> &b_less_unit)
    {
      return std::sqrt(
        principal_strain(spectral_decomposition<dim>(b_less_unit))
          .deviator_squared);
    }
  } // namespace

  template <int dim>
  FlowWeight<dim>::FlowWeight(const Step &step, const bool with_derivative)
  {
    if (step.trial == step.end)
      return;
    const double trial = deviator_norm<dim>(step.trial);
    if (!(trial > 0.))
      return;
    const double x = deviator_norm<dim>(step.end) / trial;
    value          = 1. - 0.25 * x * (3. - x);

    const auto   unit   = mandel::unit<dim>();
    const double mean   = unit * step.stress / 3.;
    const auto   s      = step.stress - mean * unit;
    const double s_norm = s.norm();
    if (!with_derivative || !(s_norm > 0.))
      return;
    // Strain and stress have the same axes. With N = s/|s|, d as in EndSlope of
    // the mean dilatation, d|dev e_tr| = N : d and
    // d|s| = N : (c : (d + g I) + 2 tau (d + g I))
    const auto N     = s / s_norm;
    const auto N_tau = mandel::symmetric_part<dim>(
      mandel::block<dim>(N) * mandel::block<dim>(step.stress));
    const auto   rate   = N * step.tangent + 2. * N_tau;
    const double g_rate = (N * step.tangent * unit + 2. * s_norm) / 3.;
    const auto   of_d   = rate / s_norm - N / trial;
    const double x_by_w = -0.25 * (3. - 2. * x) * x; // x dw/dx
    const MandelVector<dim> by_C =
      0.5 * x_by_w *
      (step.congruence * of_d - g_rate / s_norm * (step.congruence * unit));
    for (unsigned int i = 0; i < n_in_plane<dim>; ++i)
      this->by_C[i] = by_C[i];
    by_log = x_by_w * g_rate / s_norm;
  }

  template struct FlowWeight<2>;
  template struct FlowWeight<3>;
} // namespace emmy
