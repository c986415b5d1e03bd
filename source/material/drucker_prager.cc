#include <emmy/material/drucker_prager.h>
#include <emmy/material/principal_axes.h>

#include <deal.II/base/numbers.h>

#include <algorithm>

namespace emmy
{
  namespace
  {
    std::vector<Field>
    history_fields()
    {
      return {{"equivalent_plastic_strain",
               Field::Kind::scalar,
               "1",
               "equivalent plastic strain, sum of sqrt(2/3) |deviator of the "
               "plastic strain of a step|"},
              {"plastic_volume_strain",
               Field::Kind::scalar,
               "1",
               "sum of the traces of the plastic strain, positive where the "
               "volume grows"}};
    }

    /** Where a trial state flows to, in p and t, and how that changes. */
    struct Return
    {
      double p, t;                    ///< Pa
      double shear = 0., volume = 0.; ///< gamma, trace of the plastic strain
      double p_energy, t_energy;      ///< d(psi + D)/d(trial), as p and t, Pa
      /** Derivatives by the trial's p and t. */
      double p_p = 1., p_t = 0., t_p = 0., t_t = 1.;
    };

    /** The formulas of the class. @param p,t of the trial, Pa */
    Return
    return_to(const DruckerPragerSurface &surface,
              const double                K,
              const double                G,
              const double                p,
              const double                t)
    {
      const double eta = surface.friction, eta_bar = surface.dilation;
      const double tension = surface.tension;
      // not below zero by round-off where the apex is
      const double t_edge = std::isinf(tension)
                              ? 0.
                              : std::max(0., surface.cohesion - eta * tension);
      Return       result;
      result.p           = p;
      result.t           = t;
      const double M     = G + K * eta * eta_bar;
      const double gamma = (t + eta * p - surface.cohesion) / M;
      // round-off at the apex must not leave a trial outside
      if (gamma > 0. && p - K * eta_bar * gamma <= tension &&
          (t - G * gamma >= 0. || p <= tension))
        {
          result.p          = p - K * eta_bar * gamma;
          result.t          = std::max(0., t - G * gamma);
          result.shear      = gamma;
          result.volume     = eta_bar * gamma;
          result.p_p        = G / M;
          result.p_t        = -K * eta_bar / M;
          result.t_p        = -G * eta / M;
          result.t_t        = K * eta * eta_bar / M;
          const double lack = K * G * gamma * (eta - eta_bar) / M;
          result.p_energy   = result.p - lack;
          result.t_energy   = result.t + eta_bar * lack;
          return result;
        }
      if (p > tension)
        {
          result.p      = tension;
          result.volume = (p - tension) / K;
          result.p_p    = 0.;
          if (t > t_edge)
            {
              result.t     = t_edge;
              result.shear = (t - t_edge) / G;
              result.t_t   = 0.;
            }
        }
      result.p_energy = result.p;
      result.t_energy = result.t;
      return result;
    }
  } // namespace

  DruckerPragerSurface
  drucker_prager_fit(const MohrCoulombStrength &strength,
                     const std::string         &fit)
  {
    const double sin_phi = std::sin(strength.friction_angle);
    const double cos_phi = std::cos(strength.friction_angle);
    const double sin_psi = std::sin(strength.dilation_angle);

    DruckerPragerSurface surface;
    if (fit == "plane strain")
      {
        const double eta_bar =
          3. * sin_psi / std::sqrt(9. + 3. * sin_psi * sin_psi);
        const double N =
          std::sqrt(1. - eta_bar * eta_bar / 3.) + eta_bar * sin_phi / 3.;
        surface.friction = sin_phi / N;
        surface.dilation = std::min(eta_bar, surface.friction);
        surface.cohesion = strength.cohesion * cos_phi / N;
      }
    else
      {
        const double sign   = fit == "outer" ? -1. : 1.;
        const auto   factor = [sign](const double sine) {
          return 6. / (std::sqrt(3.) * (3. + sign * sine));
        };
        surface.friction = factor(sin_phi) * sin_phi;
        surface.dilation = factor(sin_psi) * sin_psi;
        surface.cohesion = factor(sin_phi) * strength.cohesion * cos_phi;
      }
    if (surface.friction > 0.)
      surface.tension = surface.cohesion / surface.friction;
    return surface;
  }

  template <int dim>
  DruckerPrager<dim>::DruckerPrager(const ElasticConstants     &constants,
                                    const DruckerPragerSurface &surface)
    : constants(constants)
    , surface(surface)
  {}

  template <int dim>
  std::vector<Field>
  DruckerPrager<dim>::history() const
  {
    return history_fields();
  }

  template <int dim>
  EffectCard
  DruckerPragerParameters<dim>::card()
  {
    EffectCard card;
    card.fields = history_fields();
    return card;
  }

  template <int dim>
  void
  DruckerPrager<dim>::evaluate(MaterialBatch<dim> &batch) const
  {
    const double *const ratio = batch.strength_ratio;
    if (ratio)
      evaluate_points(
        [this, ratio](const unsigned int p) {
          DruckerPragerSurface result = surface;
          result.cohesion *= ratio[p];
          result.tension *= ratio[p];
          return result;
        },
        batch);
    else
      evaluate_points(
        [this](const unsigned int) -> const auto & { return surface; }, batch);
  }

  template <int dim>
  template <class Surface>
  void
  DruckerPrager<dim>::evaluate_points(const Surface      &surface_of,
                                      MaterialBatch<dim> &batch) const
  {
    const double K = constants.bulk_modulus, G = constants.shear_modulus;
    const double sqrt_2 = std::sqrt(2.);
    const auto   b      = spectral_decompositions(batch);

    std::vector<PrincipalStep<dim>> steps(
      batch.with_energy_change ? batch.n_points : 0);
    for (unsigned int q = 0; q < batch.n_points; ++q)
      {
        const auto   e    = principal_strain(b[q]);
        const double norm = std::sqrt(e.deviator_squared);
        const Return end =
          return_to(surface_of(q), K, G, K * e.trace, sqrt_2 * G * norm);

        // the direction of the deviator: zero where there is none
        std::array<double, 3> n{}, tau, tau_energy, flow;
        for (unsigned int i = 0; i < 3; ++i)
          {
            if (norm > 0.)
              n[i] = e.deviator[i] / norm;
            tau[i]        = end.p + sqrt_2 * end.t * n[i];
            tau_energy[i] = end.p_energy + sqrt_2 * end.t_energy * n[i];
            flow[i]       = end.shear * n[i] / sqrt_2 + end.volume / 3.;
          }
        if (end.shear > 0. || end.volume > 0.)
          batch.left_cauchy_green_less_unit[q] = elastic_part<dim>(e.b, flow);
        batch.history[0][q] += end.shear / std::sqrt(3.);
        batch.history[1][q] += end.volume;
        batch.kirchhoff_stress[q] = from_principal(e.b, tau);
        batch.stored_energy[q] =
          0.5 * end.p * end.p / K + 0.5 * end.t * end.t / G;
        batch.dissipation[q]      = end.t * end.shear + end.p * end.volume;
        batch.hardening_energy[q] = 0.;
        batch.hardening_energy_change[q] = 0.;
        if (batch.with_energy_change)
          steps[q] = {e.b, tau, flow};

        if (!batch.with_tangent)
          continue;
        batch.energy_stress[q] = from_principal(e.b, tau_energy);
        constexpr auto normal  = mandel::normal_components<dim>();
        const double   kept = norm > 0. ? end.t / (sqrt_2 * G * norm) : end.t_t;
        auto c = principal_tangent<dim>(e, tau, end.p_p * K, G * kept);
        for (unsigned int i = 0; i < 3; ++i)
          for (unsigned int j = 0; j < 3; ++j)
            c[normal[i]][normal[j]] += 2. * G * (end.t_t - kept) * n[i] * n[j] +
                                       sqrt_2 * G * end.p_t * n[j] +
                                       sqrt_2 * K * end.t_p * n[i];
        batch.spatial_tangent[q] =
          mandel::transform<dim>(mandel::congruence<dim>(e.b.vectors), c);
      }
    if (batch.with_energy_change)
      fill_energy_changes<dim>(steps.data(), batch);
  }

  template <int dim>
  bool
  DruckerPrager<dim>::gives_energy_change() const
  {
    return true;
  }

  template <int dim>
  bool
  DruckerPrager<dim>::gives_energy_stress() const
  {
    return surface.dilation < surface.friction;
  }

  template <int dim>
  double
  DruckerPrager<dim>::density() const
  {
    return constants.density;
  }

  template <int dim>
  double
  DruckerPrager<dim>::p_wave_modulus() const
  {
    return constants.bulk_modulus + 4. / 3. * constants.shear_modulus;
  }

  template <int dim>
  double
  DruckerPrager<dim>::shear_wave_modulus() const
  {
    return constants.shear_modulus;
  }

  template <int dim>
  DruckerPragerParameters<dim>::DruckerPragerParameters(
    const std::string &section)
    : MaterialParameters<dim>(section)
  {
    using namespace dealii::Patterns;
    constants.add_to(*this);
    this->add_parameter("Cohesion",
                        cohesion,
                        "c of Mohr and Coulomb. Unit: Pa. Required, not "
                        "negative; 0 with a friction angle only: such a soil "
                        "bears no tension at all.",
                        this->prm,
                        Double());
    this->add_parameter("Friction angle",
                        friction_angle,
                        "phi of Mohr and Coulomb. Unit: degrees. Required, "
                        "from 0 to below 90.",
                        this->prm,
                        Double());
    this->add_parameter("Dilation angle",
                        dilation_angle,
                        "psi: how much the volume grows when the soil shears. "
                        "Unit: degrees. Required, from 0 to the friction "
                        "angle, which makes flow associated.",
                        this->prm,
                        Double());
    this->add_parameter("Fit",
                        fit,
                        "Where the cone meets Mohr and Coulomb. plane strain: "
                        "where it flows in plane strain. outer: in triaxial "
                        "compression, which is too strong elsewhere. inner: in "
                        "triaxial extension, which is too weak elsewhere.",
                        this->prm,
                        Selection("plane strain|outer|inner"));
    this->add_parameter("Tension cut-off",
                        tension,
                        "The mean stress that the soil bears at most. Unit: "
                        "Pa, at most that of the apex of the cone. -1: that of "
                        "the apex.",
                        this->prm,
                        Double());
  }

  template <int dim>
  std::unique_ptr<Material<dim>>
  DruckerPragerParameters<dim>::make() const
  {
    const auto require = [this](const bool         condition,
                                const std::string &name,
                                const double       value,
                                const std::string &advice) {
      AssertThrow(condition,
                  ExcParameter(this->path(), name, shortest(value), advice));
    };
    const ElasticConstants elastic = constants.completed(this->path());
    require(cohesion >= 0.,
            "Cohesion",
            cohesion,
            "required, and must not be negative (Pa).");
    require(friction_angle >= 0. && friction_angle < 90.,
            "Friction angle",
            friction_angle,
            "required, from 0 to below 90 degrees.");
    require(dilation_angle >= 0. && dilation_angle <= friction_angle,
            "Dilation angle",
            dilation_angle,
            "required, from 0 to the friction angle (degrees): with more, flow "
            "would create energy.");
    require(cohesion > 0. || friction_angle > 0.,
            "Cohesion",
            cohesion,
            "a soil without friction and cohesion has no strength. Give it a "
            "cohesion, which without friction is its undrained strength (Pa).");
    const double degree  = dealii::numbers::PI / 180.;
    auto         surface = drucker_prager_fit(
      {cohesion, friction_angle * degree, dilation_angle * degree}, fit);
    require(tension == -1. || tension >= 0.,
            "Tension cut-off",
            tension,
            "must not be negative (Pa). -1 is for the apex of the cone.");
    require(tension <= surface.tension,
            "Tension cut-off",
            tension,
            "the cone ends at a mean stress of " + shortest(surface.tension) +
              " Pa. Use at most that, or -1.");
    if (tension >= 0.)
      surface.tension = tension;
    return std::make_unique<DruckerPrager<dim>>(elastic, surface);
  }

  template class DruckerPrager<2>;
  template class DruckerPrager<3>;
  template class DruckerPragerParameters<2>;
  template class DruckerPragerParameters<3>;
} // namespace emmy
