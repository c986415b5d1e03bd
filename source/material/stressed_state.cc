#include <emmy/material/principal_axes.h>
#include <emmy/material/stressed_state.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace emmy
{
  using dealii::Tensor;

  namespace
  {
    /** Relative to the stress; what the material may flow, to the strain. */
    constexpr double       tolerance       = 1e-13;
    constexpr unsigned int most_iterations = 50;

    /** Four points at once: a strain, and one beside it along each axis. */
    template <int dim>
    struct Probe
    {
      const Material<dim>                &material;
      SpectralDecomposition<dim>          axes;
      std::unique_ptr<MaterialBatch<dim>> batch =
        std::make_unique<MaterialBatch<dim>>();

      Probe(const Material<dim>       &material,
            const std::vector<double> &parameters,
            const MandelVector<dim>   &stress)
        : material(material)
      {
        axes                = spectral_decomposition<dim>(stress);
        batch->with_tangent = false;
        for (const double value : parameters)
          {
            batch->parameters.emplace_back();
            batch->parameters.back().fill(value);
          }
      }

      /** @param strain logarithmic, @param shift between the points */
      void
      evaluate(const Tensor<1, 3> &strain, const double shift)
      {
        batch->n_points = shift > 0. ? 4 : 1;
        for (unsigned int q = 0; q < batch->n_points; ++q)
          {
            std::array<double, 3> b_less_unit;
            for (unsigned int i = 0; i < 3; ++i)
              b_less_unit[i] =
                std::expm1(2. * (strain[i] + (q == i + 1 ? shift : 0.)));
            batch->left_cauchy_green_less_unit[q] =
              from_principal(axes, b_less_unit);
          }
        batch->history.clear();
        batch->history.resize(material.history().size());
        for (auto &history : batch->history)
          history.fill(0.);
        batch->dissipation.fill(0.);
        material.evaluate(*batch);
      }

      /** Cauchy stress of a point along the axes, Pa. */
      Tensor<1, 3>
      stress(const unsigned int q, const Tensor<1, 3> &strain) const
      {
        const auto  &tau   = batch->kirchhoff_stress[q];
        const auto   block = mandel::block<dim>(tau);
        const double J     = std::exp(strain[0] + strain[1] + strain[2]);
        Tensor<1, 3> result;
        for (unsigned int i = 0; i < dim; ++i)
          for (unsigned int j = 0; j < dim; ++j)
            for (unsigned int k = 0; k < dim; ++k)
              result[i] +=
                axes.vectors[j][i] * block[j][k] * axes.vectors[k][i] / J;
        if (dim == 2)
          result[2] = tau[n_mandel<dim> - 1] / J;
        return result;
      }

      bool
      flows() const
      {
        return std::any_of(batch->history.begin(),
                           batch->history.end(),
                           [](const auto &history) {
                             return history[0] != 0.;
                           });
      }
    };

    /** Of linear elasticity, from the moduli of the undeformed material. */
    template <int dim>
    Tensor<1, 3>
    first_guess(const Material<dim> &material, const Tensor<1, 3> &stress)
    {
      const double M    = material.p_wave_modulus();
      const double G    = material.shear_wave_modulus() > 0.
                            ? material.shear_wave_modulus()
                            : M / 4.;
      const double K    = M - 4. / 3. * G;
      const double mean = (stress[0] + stress[1] + stress[2]) / 3.;
      Tensor<1, 3> strain;
      for (unsigned int i = 0; i < 3; ++i)
        strain[i] = (stress[i] - mean) / (2. * G) + mean / (3. * K);
      return strain;
    }
  } // namespace

  template <int dim>
  StressedState<dim>
  stressed_state(const Material<dim>       &material,
                 const std::vector<double> &parameters,
                 const MandelVector<dim>   &stress)
  {
    StressedState<dim> result;
    result.is_found = stress.norm() == 0.;
    if (result.is_found)
      return result;
    Probe<dim>   probe(material, parameters, stress);
    Tensor<1, 3> target;
    for (unsigned int i = 0; i < 3; ++i)
      target[i] = probe.axes.values[i];

    Tensor<1, 3> strain = first_guess(material, target);
    // the factor of moduli that vary
    probe.evaluate(strain, 0.);
    if (const double along = probe.stress(0, strain) * target; along > 0.)
      strain *= target.norm_square() / along;
    double last = std::numeric_limits<double>::max();
    for (unsigned int k = 0; k < most_iterations; ++k)
      {
        const double shift = 1e-6 * strain.norm();
        probe.evaluate(strain, shift);
        const Tensor<1, 3> here = probe.stress(0, strain);
        const Tensor<1, 3> gap  = target - here;
        const double       size = gap.norm() / target.norm();
        // to round-off, or as far as it goes
        if (size < 1e-15 || (size < tolerance && size >= 0.5 * last))
          {
            result.left_cauchy_green_less_unit =
              probe.batch->left_cauchy_green_less_unit[0];
            result.kirchhoff_stress = probe.batch->kirchhoff_stress[0];
            result.stored_energy    = probe.batch->stored_energy[0];
            result.volume_ratio = std::exp(strain[0] + strain[1] + strain[2]);
            result.is_found     = !probe.flows();
            return result;
          }
        last = size;
        Tensor<2, 3> slope; // d stress/d strain
        for (unsigned int j = 0; j < 3; ++j)
          {
            Tensor<1, 3> beside = strain;
            beside[j] += shift;
            const auto change = probe.stress(j + 1, beside) - here;
            for (unsigned int i = 0; i < 3; ++i)
              slope[i][j] = change[i] / shift;
          }
        if (!(std::abs(determinant(slope)) > 0.))
          return result;
        strain += invert(slope) * gap;
      }
    return result;
  }

  namespace
  {
    /** By how much flow may take back a stress that was rounded. */
    constexpr double rounded = 1e-6;

    /** Of a linear elastic law; zero stress: zero. */
    template <int dim>
    StressedState<dim>
    state_after_flow(const Material<dim>       &material,
                     const std::vector<double> &parameters,
                     const GivenStress<dim>    &given)
    {
      Tensor<1, 3> target;
      const auto   axes = spectral_decomposition<dim>(given.stress);
      for (unsigned int i = 0; i < 3; ++i)
        target[i] = axes.values[i];
      Probe<dim>         probe(material, parameters, given.stress);
      const Tensor<1, 3> guess = first_guess(material, target);
      double             scale = 1.; // of moduli that vary
      if (target.norm() > 0.)
        {
          constexpr double small = 1e-6;
          probe.evaluate(small * guess, 0.);
          scale = target.norm_square() * small /
                  (probe.stress(0, Tensor<1, 3>()) * target);
        }
      // the stress that the law knows is J times this one
      const double trace = scale * (guess[0] + guess[1] + guess[2]);
      double       J     = given.volume_ratio > 0. ? given.volume_ratio : 1.;
      for (unsigned int k = 0; k < most_iterations && given.volume_ratio == 0.;
           ++k)
        J = std::exp((given.is_kirchhoff ? 1. : J) * trace);
      const double          factor = given.is_kirchhoff ? 1. : J;
      std::array<double, 3> b_less_unit;
      for (unsigned int i = 0; i < 3; ++i)
        b_less_unit[i] = std::expm1(2. * factor * scale * guess[i]);
      auto result         = strained_state(material,
                                   parameters,
                                   from_principal(probe.axes, b_less_unit),
                                   given.history);
      result.volume_ratio = J;
      result.is_found &=
        (result.kirchhoff_stress - factor * given.stress).norm() <=
        rounded * factor * given.stress.norm();
      return result;
    }
  } // namespace

  template <int dim>
  StressedState<dim>
  strained_state(const Material<dim>       &material,
                 const std::vector<double> &parameters,
                 const MandelVector<dim>   &left_cauchy_green_less_unit,
                 const std::vector<double> &history)
  {
    const auto batch    = std::make_unique<MaterialBatch<dim>>();
    batch->n_points     = 1;
    batch->with_tangent = false;
    batch->left_cauchy_green_less_unit[0] = left_cauchy_green_less_unit;
    batch->dissipation.fill(0.);
    batch->hardening_energy.fill(0.);
    for (const double value : parameters)
      {
        batch->parameters.emplace_back();
        batch->parameters.back().fill(value);
      }
    for (const double value : history)
      {
        batch->history.emplace_back();
        batch->history.back().fill(value);
      }
    material.evaluate(*batch);
    StressedState<dim> result;
    result.left_cauchy_green_less_unit = batch->left_cauchy_green_less_unit[0];
    result.kirchhoff_stress            = batch->kirchhoff_stress[0];
    result.stored_energy               = batch->stored_energy[0];
    result.volume_ratio = std::sqrt(1. + mandel::determinant_less_one<dim>(
                                           result.left_cauchy_green_less_unit));
    for (const auto &value : batch->history)
      result.history.push_back(value[0]);
    if (!history.empty())
      result.hardening_energy = batch->hardening_energy[0];
    result.is_found =
      (result.left_cauchy_green_less_unit - left_cauchy_green_less_unit)
        .norm() <= rounded * left_cauchy_green_less_unit.norm();
    return result;
  }

  template <int dim>
  StressedState<dim>
  stressed_state(const Material<dim>       &material,
                 const std::vector<double> &parameters,
                 const GivenStress<dim>    &given)
  {
    if (!given.history.empty())
      return state_after_flow(material, parameters, given);
    double             J = given.volume_ratio > 0. ? given.volume_ratio : 1.;
    StressedState<dim> result;
    for (unsigned int k = 0; k < most_iterations; ++k)
      {
        result =
          stressed_state(material,
                         parameters,
                         MandelVector<dim>(given.stress /
                                           (given.is_kirchhoff ? J : 1.)));
        if (!given.is_kirchhoff || given.volume_ratio > 0. ||
            std::abs(result.volume_ratio - J) <= tolerance)
          return result;
        J = result.volume_ratio;
      }
    return result;
  }

#define INSTANTIATE(dim)                                                       \
  template StressedState<dim> stressed_state<dim>(const Material<dim> &,       \
                                                  const std::vector<double> &, \
                                                  const GivenStress<dim> &);   \
  template StressedState<dim> strained_state<dim>(                             \
    const Material<dim> &,                                                     \
    const std::vector<double> &,                                               \
    const MandelVector<dim> &,                                                 \
    const std::vector<double> &);                                              \
  template StressedState<dim> stressed_state<dim>(const Material<dim> &,       \
                                                  const std::vector<double> &, \
                                                  const MandelVector<dim> &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
