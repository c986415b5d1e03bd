#ifndef emmy_material_stressed_state_h
#define emmy_material_stressed_state_h

#include <emmy/material/material.h>

#include <vector>

namespace emmy
{
  /** A point of a material under a given stress. */
  template <int dim>
  struct StressedState
  {
    MandelVector<dim> left_cauchy_green_less_unit; ///< elastic, b^e - I
    MandelVector<dim> kirchhoff_stress;            ///< Pa
    double            stored_energy = 0.;          ///< J/m^3, reference volume
    double            volume_ratio  = 1.;          ///< J
    bool              is_found      = false;       ///< false: it would flow
    /** Of a material with history, after the given state. */
    std::vector<double> history;
    double              hardening_energy = 0.; ///< J/m^3, reference volume
  };

  /**
   * The elastic strain whose Cauchy stress is given: coaxial with it, as the
   * material is isotropic. Newton on the three logarithmic strains, with
   * differences of the material's own stresses, to 1e-13 of the stress.
   *
   * @param parameters of Material::parameters(), at the point
   * @param stress     Cauchy stress, Pa; of an undeformed point: zero
   */
  template <int dim>
  StressedState<dim>
  stressed_state(const Material<dim>       &material,
                 const std::vector<double> &parameters,
                 const MandelVector<dim>   &stress);

  /** A stress, and in which state it acts. */
  template <int dim>
  struct GivenStress
  {
    MandelVector<dim> stress;               ///< Pa
    bool              is_kirchhoff = false; ///< else it is Cauchy's
    double            volume_ratio = 0.; ///< J; 0: of the elastic strain alone
    std::vector<double> history;         ///< as of Material::history()
  };

  /**
   * The elastic strain of a point that may have flowed before. Of a material
   * with history, whose elastic law must be linear in the logarithmic strain
   * (Hencky); a stress beyond its strength by no more than 1e-6, as rounded
   * numbers in files are, is taken back to it.
   */
  template <int dim>
  StressedState<dim>
  stressed_state(const Material<dim>       &material,
                 const std::vector<double> &parameters,
                 const GivenStress<dim>    &given);

  /** The state of an elastic strain b^e - I; see there. */
  template <int dim>
  StressedState<dim>
  strained_state(const Material<dim>       &material,
                 const std::vector<double> &parameters,
                 const MandelVector<dim>   &left_cauchy_green_less_unit,
                 const std::vector<double> &history);
} // namespace emmy

#endif
