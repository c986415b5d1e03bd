#ifndef emmy_material_hencky_kernels_h
#define emmy_material_hencky_kernels_h

#include <emmy/material/principal_lanes.h>

namespace emmy
{
  /** The logarithmic strain e of points side by side, and its energy. */
  template <int dim>
  struct HenckyLanes
  {
    const double bulk_modulus, shear_modulus; ///< Pa

    // from find_strain()
    Lanes log_b[3];         ///< ln(1 + values)
    Lanes deviator[3];      ///< dev e
    Lanes trace;            ///< tr e
    Lanes deviator_squared; ///< |dev e|^2

    /** In: the part of the deviator that flow leaves; one in elasticity. */
    Lanes kept;

    // from find_stress()
    Lanes tau[3]; ///< principal Kirchhoff stress, Pa
    Lanes energy; ///< J/m^3

    /** With these moduli, of points of which nothing is known yet. */
    HenckyLanes(const double bulk_modulus, const double shear_modulus)
      : bulk_modulus(bulk_modulus)
      , shear_modulus(shear_modulus)
    {}
  };

  /** With copies for several instruction sets, which give the same bits. */
  namespace hencky_kernels
  {
    /** Three logarithms. */
    void
    find_strain(const PrincipalLanes<2> &at, HenckyLanes<2> &law);
    /** The same in space. */
    void
    find_strain(const PrincipalLanes<3> &at, HenckyLanes<3> &law);
    /**
     * tau = K tr e I + 2 G kept dev e and its energy.
     * @param stress of a batch, Pa
     */
    void
    find_stress(const PrincipalLanes<2> &at,
                HenckyLanes<2>          &law,
                double                  *stress);
    /** The same in space. */
    void
    find_stress(const PrincipalLanes<3> &at,
                HenckyLanes<3>          &law,
                double                  *stress);
    /** Behind it: its tangent, as principal_tangent() has it. */
    void
    find_tangent(PrincipalLanes<2> &at, const HenckyLanes<2> &law);
    /** The same in space. */
    void
    find_tangent(PrincipalLanes<3> &at, const HenckyLanes<3> &law);
  } // namespace hencky_kernels
} // namespace emmy

#endif
