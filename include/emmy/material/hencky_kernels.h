#ifndef emmy_material_hencky_kernels_h
#define emmy_material_hencky_kernels_h

#include <emmy/material/principal_lanes.h>

namespace emmy
{
  /** What Hencky's law makes of points side by side. */
  template <int dim>
  struct HenckyLanes
  {
    double bulk_modulus, shear_modulus; ///< Pa

    // out
    double *stress; ///< Kirchhoff's, of the batch
    Lanes   energy; ///< J/m^3
    Lanes   tau[3]; ///< principal, Pa
  };

  /** With copies for several instruction sets, which give the same bits. */
  namespace hencky_kernels
  {
    /** Stress and energy, and the tangent in principal axes. */
    void
    evaluate(PrincipalLanes<2> &at, HenckyLanes<2> &law);
    /** The same in space. */
    void
    evaluate(PrincipalLanes<3> &at, HenckyLanes<3> &law);
  } // namespace hencky_kernels
} // namespace emmy

#endif
