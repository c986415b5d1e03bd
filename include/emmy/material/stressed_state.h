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
} // namespace emmy

#endif
