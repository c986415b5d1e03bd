#include <emmy/material/hencky_kernels.h>
#include <emmy/material/principal_axes.h>
#include <emmy/material/von_mises.h>

// vectors stay within this file
#pragma GCC diagnostic ignored "-Wpsabi"

namespace emmy
{
  namespace
  {
    const double sqrt_two_thirds = std::sqrt(2. / 3.);

    std::vector<Field>
    history_fields()
    {
      return {{"equivalent_plastic_strain",
               Field::Kind::scalar,
               "1",
               "equivalent plastic strain, sum of sqrt(2/3) |plastic strain of "
               "a step|"}};
    }
  } // namespace

  template <int dim>
  VonMises<dim>::VonMises(const ElasticConstants &constants,
                          const YieldSurface     &surface)
    : constants(constants)
    , surface(surface)
  {}

  template <int dim>
  std::vector<Field>
  VonMises<dim>::history() const
  {
    return history_fields();
  }

  template <int dim>
  EffectCard
  VonMisesParameters<dim>::card()
  {
    EffectCard card;
    card.fields = history_fields();
    return card;
  }

  template <int dim>
  void
  VonMises<dim>::evaluate(MaterialBatch<dim> &batch) const
  {
    const double *ratio     = batch.strength_ratio;
    const auto    radius_of = [&](const unsigned int p) {
      return ratio ? ratio[p] * surface.radius : surface.radius;
    };
    SpectralArrays<dim> b;
    spectral_decompositions<dim>(batch.left_cauchy_green_less_unit.data(),
                                 batch.n_points,
                                 b);
    HenckyLanes<dim> law(constants.bulk_modulus, constants.shear_modulus);
    std::vector<PrincipalStep<dim>> steps(
      batch.with_energy_change ? batch.n_points : 0);
    for (unsigned int first = 0; first < batch.n_points; first += n_lanes)
      {
        PrincipalLanes<dim> at(LanePoints(first, batch.n_points));
        at.read(b, first);
        hencky_kernels::find_strain(at, law);
        std::array<Flow, n_lanes> flows;
        const unsigned int        n = std::min(n_lanes, batch.n_points - first);
        for (unsigned int lane = 0; lane < n; ++lane)
          flows[lane] =
            flow(law, lane, radius_of(first + lane), first + lane, batch);
        for (unsigned int lane = n; lane < n_lanes; ++lane)
          flows[lane] = flows[n - 1];
        for (unsigned int lane = 0; lane < n_lanes; ++lane)
          law.kept[lane] = flows[lane].kept;
        hencky_kernels::find_stress(at,
                                    law,
                                    batch.kirchhoff_stress[0].begin_raw());
        for (unsigned int lane = 0; lane < n; ++lane)
          {
            batch.stored_energy[first + lane] = law.energy[lane];
            if (flows[lane].is_plastic)
              batch.left_cauchy_green_less_unit[first + lane] =
                elastic_part<dim>(b.of(first + lane), flows[lane].strain);
            if (batch.with_energy_change)
              {
                PrincipalStep<dim> &step = steps[first + lane];
                step.trial               = b.of(first + lane);
                step.flow                = flows[lane].strain;
                for (unsigned int i = 0; i < 3; ++i)
                  step.stress[i] = law.tau[i][lane];
              }
          }
        if (!batch.with_tangent)
          continue;
        hencky_kernels::find_tangent(at, law);
        // derivative of the return mapping (Pretti et al. 2023, A.31)
        const double G = constants.shear_modulus;
        for (unsigned int lane = 0; lane < n_lanes; ++lane)
          if (const auto &[is_plastic, kept, direction, strain] = flows[lane];
              is_plastic)
            {
              const double softer =
                2. * G / (2. * G + 2. / 3. * surface.hardening_modulus) -
                (1. - kept);
              for (unsigned int i = 0; i < 3; ++i)
                for (unsigned int j = 0; j < 3; ++j)
                  at.normal[i][j][lane] -=
                    2. * G * softer * direction[i] * direction[j];
            }
        principal_axes_kernels::turn(at, batch.spatial_tangent[0].begin_raw());
      }
    if (batch.with_energy_change)
      fill_energy_changes<dim>(steps.data(), batch);
  }

  template <int dim>
  typename VonMises<dim>::Flow
  VonMises<dim>::flow(const HenckyLanes<dim> &trial,
                      const unsigned int      lane,
                      const double            radius,
                      const unsigned int      p,
                      MaterialBatch<dim>     &batch) const
  {
    const double G = constants.shear_modulus, H = surface.hardening_modulus;
    double      &xi            = batch.history[0][p];
    const double deviator_norm = std::sqrt(trial.deviator_squared[lane]);
    const double excess =
      2. * G * deviator_norm - (radius + sqrt_two_thirds * H * xi);
    const double size = std::max(0., excess / (2. * G + 2. / 3. * H));
    Flow         result;
    result.is_plastic = size > 0.;
    if (result.is_plastic)
      {
        result.kept = 1. - size / deviator_norm;
        for (unsigned int i = 0; i < 3; ++i)
          {
            result.direction[i] = trial.deviator[i][lane] / deviator_norm;
            result.strain[i]    = size * result.direction[i];
          }
      }
    const double xi_old = xi;
    xi += sqrt_two_thirds * size;
    batch.hardening_energy[p] = 0.5 * H * xi * xi;
    batch.dissipation[p]      = radius * size;
    batch.hardening_energy_change[p] =
      0.5 * H * (xi_old + xi) * sqrt_two_thirds * size;
    return result;
  }

  template <int dim>
  bool
  VonMises<dim>::gives_energy_change() const
  {
    return true;
  }

  template <int dim>
  double
  VonMises<dim>::density() const
  {
    return constants.density;
  }

  template <int dim>
  double
  VonMises<dim>::p_wave_modulus() const
  {
    return constants.bulk_modulus + 4. / 3. * constants.shear_modulus;
  }

  template <int dim>
  double
  VonMises<dim>::shear_wave_modulus() const
  {
    return constants.shear_modulus;
  }

  template <int dim>
  VonMisesParameters<dim>::VonMisesParameters(const std::string &section)
    : MaterialParameters<dim>(section)
  {
    using namespace dealii::Patterns;
    constants.add_to(*this);
    this->add_parameter("Yield stress",
                        yield_stress,
                        "Where flow starts, see <Yield measure>. Unit: Pa. "
                        "Required, positive.",
                        this->prm,
                        Double());
    this->add_parameter("Hardening modulus",
                        hardening_modulus,
                        "Rise of the uniaxial yield stress with the equivalent "
                        "plastic strain. Unit: Pa. Not negative; 0: no "
                        "hardening.",
                        this->prm,
                        Double());
    this->add_parameter("Yield measure",
                        yield_measure,
                        "What <Yield stress> is. uniaxial: the stress of a "
                        "tension test, flow starts at sqrt(3/2) |s| = Yield "
                        "stress (eq. 63; s: deviator of the Kirchhoff "
                        "stress). deviatoric: flow starts at |s| = Yield "
                        "stress (eq. 62), without hardening. undrained: it is "
                        "the undrained strength s_u of a clay, flow starts at "
                        "sqrt(1/2) |s| = s_u, without hardening; in plane "
                        "strain this is Tresca's condition.",
                        this->prm,
                        Selection("uniaxial|deviatoric|undrained"));
  }

  template <int dim>
  std::unique_ptr<Material<dim>>
  VonMisesParameters<dim>::make() const
  {
    const auto require = [this](const bool         condition,
                                const std::string &name,
                                const double       value,
                                const std::string &advice) {
      AssertThrow(condition,
                  ExcParameter(this->path(), name, shortest(value), advice));
    };
    const ElasticConstants elastic = constants.completed(this->path());
    require(yield_stress > 0.,
            "Yield stress",
            yield_stress,
            "required, and must be positive (Pa). For a material that never "
            "flows use Model = Hencky.");
    require(hardening_modulus >= 0.,
            "Hardening modulus",
            hardening_modulus,
            "must not be negative (Pa): softening would depend on the grid. "
            "Use 0 for no hardening.");
    const bool is_uniaxial  = yield_measure == "uniaxial";
    const bool is_undrained = yield_measure == "undrained";
    require(is_uniaxial || hardening_modulus == 0.,
            "Hardening modulus",
            hardening_modulus,
            "must be 0 with Yield measure = " + yield_measure +
              ". To harden, use Yield measure = uniaxial and " +
              (is_undrained ? "sqrt(3) times the undrained strength."
                            : "sqrt(3/2) times the deviatoric Yield stress."));
    return std::make_unique<VonMises<dim>>(
      elastic,
      YieldSurface{(is_uniaxial    ? sqrt_two_thirds
                    : is_undrained ? mandel::sqrt2
                                   : 1.) *
                     yield_stress,
                   hardening_modulus});
  }

  template class VonMises<2>;
  template class VonMises<3>;
  template class VonMisesParameters<2>;
  template class VonMisesParameters<3>;
} // namespace emmy
