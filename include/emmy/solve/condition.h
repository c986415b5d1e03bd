#ifndef emmy_solve_condition_h
#define emmy_solve_condition_h

#include <deal.II/lac/affine_constraints.h>

#include <emmy/base/linear_algebra.h>

namespace emmy
{
  /** How close a matrix is to a singular one, and where. */
  struct ConditionEstimate
  {
    /** Largest and smallest singular value of the scaled matrix. */
    double largest = 0., smallest = 0.;
    /**
     * The unknowns that the matrix sees least: the right singular vector y of
     * the smallest singular value as D^-1/2 y, its largest entry +-1, and zero
     * on constrained unknowns.
     */
    Vector weakest;

    /**
     * largest / smallest, at most 1e16: beyond 1e15 round-off alone decides.
     * NaN if the matrix holds no numbers.
     */
    double
    condition() const;

    /** Whether the matrix is singular to round-off: condition() > 1e15. */
    bool
    is_singular() const;
  };

  /**
   * The condition number of D^-1/2 A D^-1/2 with D = |diag A|, on the
   * unconstrained unknowns. The scaling is what the size of a node's share of
   * particles alone would do; what is left is what no scaling can cure.
   *
   * Both singular values are found with Lanczos' method, on A^T A and, with
   * one LU factorisation, on its inverse: to about six digits, or to
   * 1e-15 times the condition number, whichever is worse.
   *
   * Collective. Cost: a factorisation, and usually less than 20 products and 20
   * solves with the matrix and with its transpose.
   *
   * @param matrix square, of any symmetry, with or without the constraints
   *   worked in
   * @param start  a first guess of the singular vectors: without symmetry,
   *   and the same for every partition if the estimate is to be so.
   *   condition_estimate() of step/small_cuts.h makes one.
   */
  ConditionEstimate
  condition_estimate(const Matrix                            &matrix,
                     const dealii::AffineConstraints<double> &constraints,
                     const Vector                            &start);
} // namespace emmy

#endif
