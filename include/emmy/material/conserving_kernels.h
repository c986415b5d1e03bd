#ifndef emmy_material_conserving_kernels_h
#define emmy_material_conserving_kernels_h

#include <emmy/math/lane_points.h>
#include <emmy/math/mandel.h>

namespace emmy
{
  /** Arrays of a batch, one entry a point: what formulas read and write. */
  struct StressArrays
  {
    // in; symmetric tensors as in mandel
    /** Displacement gradient. */
    const double *H;
    /** Strain and stress at t, stress and tangent at the end. */
    const double *b_old, *tau_old, *tau, *c;
    /** MaterialBatch::energy_stress, if the material gives it. */
    const double *energy_stress;
    /** First Piola-Kirchhoff stress and its derivative with respect to H. */
    double *P, *tangent;
  };

  /** Points side by side. */
  template <int dim>
  struct Side
  {
    const StressArrays &arrays; ///< of the batch
    const LanePoints    points; ///< which they are
    /** Whether the material gives what its energy works. */
    const bool has_energy_stress;

    /** Nothing is known of these points yet. */
    Side(const StressArrays &arrays,
         const LanePoints   &points,
         const bool          has_energy_stress)
      : arrays(arrays)
      , points(points)
      , has_energy_stress(has_energy_stress)
    {}

    // from means(); tensors as they are
    /** F, its inverse, the one of the middle, and b at the end. */
    Lanes F[dim][dim], inverse[dim][dim], Fm[dim][dim], b[dim][dim];
    /** Factors of the average stress. */
    Lanes A[dim][dim], B[dim][dim], S1[dim][dim], S[dim][dim];
    Lanes work; ///< S-bar : A
    Lanes nu;   ///< A : B

    // in: beta; and for its derivative, zero where that is left out
    /** Of the correction by energy. */
    Lanes correction, slope_correction, inverse_nu;
  };

  /**
   * The formulas of conserving_stress() for points side by side, with copies
   * for several instruction sets, in this order, the corrections between the
   * first and the second. Stresses are the same bits on all of them; tangents
   * have fused multiplications and additions where there are some.
   */
  namespace conserving_kernels
  {
    /** Kinematics, S-bar (in S), B, and what decides on the correction. */
    void
    means(Side<2> &p);
    /** F, inverse and middle of all lanes. */
    void
    means(Side<3> &p);
    /** S and P. */
    void
    stress(Side<2> &p);
    /** P of all lanes. */
    void
    stress(Side<3> &p);
    /** dP/dH. */
    void
    tangent(Side<2> &p);
    /** dP/dH of all lanes. */
    void
    tangent(Side<3> &p);
  } // namespace conserving_kernels
} // namespace emmy

#endif
