#ifndef emmy_material_conserving_kernels_h
#define emmy_material_conserving_kernels_h

#include <emmy/math/lanes.h>
#include <emmy/math/mandel.h>

namespace emmy
{
  /** Points side by side: what the formulas read, and what they make. */
  template <int dim>
  struct Side
  {
    /** Components of a symmetric tensor. */
    static constexpr unsigned int m = n_in_plane<dim>;

    // in; symmetric tensors as in mandel, in the plane
    /**
     * Displacement gradient, strain and stress at t, stress and tangent at the
     * end.
     */
    Lanes H[dim][dim], b_old[m], tau_old[m], tau[m], c[m][m];
    /** MaterialBatch::energy_stress, where the material gives it. */
    Lanes energy_stress[m];
    /** Whether the rule corrects the stress by the energy. */
    bool has_energy_stress = false;

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

    // from stress() and tangent()
    /** First Piola-Kirchhoff stress and its derivative with respect to H. */
    Lanes P[dim][dim], tangent[dim * dim][dim * dim];
  };

  /**
   * The formulas of conserving_stress() for points side by side, with copies
   * for several instruction sets, which give the same bits. In this order, the
   * corrections between the first and the second.
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
