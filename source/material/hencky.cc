#include <emmy/material/hencky.h>
#include <emmy/material/hencky_kernels.h>
#include <emmy/material/principal_axes.h>

namespace emmy
{
  using dealii::Patterns::Double;

  void
  ElasticConstants::add_to(Section &section)
  {
    auto &prm = dealii::ParameterAcceptor::prm;
    section.add_parameter("Density",
                          density,
                          "Mass per undeformed volume. Unit: kg/m^3. Required.",
                          prm,
                          Double(0.));
    section.add_parameter("Young's modulus",
                          young_modulus,
                          "Unit: Pa. Goes with <Poisson's ratio>. 0: not "
                          "given.",
                          prm,
                          Double(0.));
    section.add_parameter("Poisson's ratio",
                          poisson_ratio,
                          "Between -1 and 0.5, both excluded; dimensionless. "
                          "-2: not given.",
                          prm,
                          Double());
    section.add_parameter("Bulk modulus",
                          bulk_modulus,
                          "Unit: Pa. Goes with <Shear modulus>, instead of "
                          "Young's modulus and Poisson's ratio. 0: not given.",
                          prm,
                          Double(0.));
    section.add_parameter("Shear modulus",
                          shear_modulus,
                          "Unit: Pa. See <Bulk modulus>. 0: not given.",
                          prm,
                          Double(0.));
  }

  ElasticConstants
  ElasticConstants::completed(const std::string &section) const
  {
    const auto require = [&section](const bool         condition,
                                    const std::string &name,
                                    const double       value,
                                    const std::string &advice) {
      AssertThrow(condition,
                  ExcParameter(section, name, shortest(value), advice));
    };
    require(density > 0.,
            "Density",
            density,
            "a density is required and must be positive (kg/m^3). Set it in "
            "this section.");

    ElasticConstants result     = *this;
    const bool       engineers  = young_modulus != 0. || poisson_ratio != -2.;
    const bool       invariants = bulk_modulus != 0. || shear_modulus != 0.;
    require(!(engineers && invariants),
            "Bulk modulus",
            bulk_modulus,
            "two pairs of elastic constants are mixed. Give either Young's "
            "modulus and Poisson's ratio, or bulk modulus and shear modulus.");
    if (invariants)
      {
        require(bulk_modulus > 0.,
                "Bulk modulus",
                bulk_modulus,
                "required with <Shear modulus>, and must be positive (Pa).");
        require(shear_modulus > 0.,
                "Shear modulus",
                shear_modulus,
                "required with <Bulk modulus>, and must be positive (Pa).");
        result.young_modulus = 9. * bulk_modulus * shear_modulus /
                               (3. * bulk_modulus + shear_modulus);
        result.poisson_ratio = (3. * bulk_modulus - 2. * shear_modulus) /
                               (2. * (3. * bulk_modulus + shear_modulus));
        return result;
      }
    require(young_modulus > 0.,
            "Young's modulus",
            young_modulus,
            "an elastic constant is missing or not positive. Set Young's "
            "modulus (Pa) and Poisson's ratio, or bulk modulus and shear "
            "modulus, in this section.");
    require(poisson_ratio > -1. && poisson_ratio < 0.5,
            "Poisson's ratio",
            poisson_ratio,
            "must lie between -1 and 0.5, both excluded. For a nearly "
            "incompressible solid use 0.49 and watch for locking.");
    result.bulk_modulus  = young_modulus / (3. * (1. - 2. * poisson_ratio));
    result.shear_modulus = young_modulus / (2. * (1. + poisson_ratio));
    return result;
  }

  bool
  ElasticConstants::are_nearly_incompressible() const
  {
    const double K = bulk_modulus, G = shear_modulus,
                 nu = K > 0. && G > 0. ? (3. * K - 2. * G) / (6. * K + 2. * G)
                                       : poisson_ratio;
    // A fluid: G is less than 1e-6 K. With a treatment only G resists changes
    // of shape in a cell, and the round-off of the mean stress, 1e-16 K, is
    // then more than Newton may leave of it.
    constexpr double fluid = 0.4999995;
    return nu > 0.4 && nu < fluid;
  }

  template <int dim>
  Hencky<dim>::Hencky(const ElasticConstants &constants)
    : reference_density(constants.density)
    , bulk_modulus(constants.bulk_modulus)
    , shear_modulus(constants.shear_modulus)
  {}

  template <int dim>
  void
  Hencky<dim>::evaluate(MaterialBatch<dim> &batch) const
  {
    SpectralArrays<dim> b;
    spectral_decompositions<dim>(batch.left_cauchy_green_less_unit.data(),
                                 batch.n_points,
                                 b);
    HenckyLanes<dim> law(bulk_modulus, shear_modulus);
    law.kept = Lanes{} + 1.;
    std::vector<PrincipalStep<dim>> steps(
      batch.with_energy_change ? batch.n_points : 0);
    for (unsigned int first = 0; first < batch.n_points; first += n_lanes)
      {
        PrincipalLanes<dim> at(LanePoints(first, batch.n_points));
        at.read(b, first);
        hencky_kernels::find_strain(at, law);
        hencky_kernels::find_stress(at,
                                    law,
                                    batch.kirchhoff_stress[0].begin_raw());
        if (batch.with_tangent)
          {
            hencky_kernels::find_tangent(at, law);
            principal_axes_kernels::turn(at,
                                         batch.spatial_tangent[0].begin_raw());
          }
        for (unsigned int lane = 0; lane < n_lanes; ++lane)
          batch.stored_energy[at.points.of_lane[lane]] = law.energy[lane];
        if (batch.with_energy_change)
          for (unsigned int lane = 0; lane < n_lanes; ++lane)
            {
              PrincipalStep<dim> &step = steps[at.points.of_lane[lane]];
              step.trial               = b.of(first + lane);
              step.stress              = {
                             {law.tau[0][lane], law.tau[1][lane], law.tau[2][lane]}};
              step.flow = {};
            }
      }
    if (batch.with_energy_change)
      fill_energy_changes<dim>(steps.data(), batch);
  }

  template <int dim>
  bool
  Hencky<dim>::gives_energy_change() const
  {
    return true;
  }

  template <int dim>
  double
  Hencky<dim>::density() const
  {
    return reference_density;
  }

  template <int dim>
  double
  Hencky<dim>::p_wave_modulus() const
  {
    return bulk_modulus + 4. / 3. * shear_modulus;
  }

  template <int dim>
  double
  Hencky<dim>::shear_wave_modulus() const
  {
    return shear_modulus;
  }

  template <int dim>
  HenckyParameters<dim>::HenckyParameters(const std::string &section)
    : MaterialParameters<dim>(section)
  {
    constants.add_to(*this);
  }

  template <int dim>
  std::unique_ptr<Material<dim>>
  HenckyParameters<dim>::make() const
  {
    return std::make_unique<Hencky<dim>>(constants.completed(this->path()));
  }

  template class Hencky<2>;
  template class Hencky<3>;
  template class HenckyParameters<2>;
  template class HenckyParameters<3>;
} // namespace emmy
