#ifndef emmy_material_middle_step_h
#define emmy_material_middle_step_h

#include <emmy/material/stress_rules.h>

namespace emmy
{
  /**
   * A step whose grid is undeformed in its middle. Shape functions, and so the
   * displacement gradient L = sum u_A (x) grad S_A, belong to the places of
   * t + dt/2, while stress rules think from t. With Z = (I - L/2)^-1,
   * @f[ \Delta F = (I + \tfrac12 L) Z, \quad H = \Delta F - I = L Z, \quad
   *     \hat S = P Z^T, \qquad \hat S : L = P : H, @f]
   * where P is the nominal stress relative to t that a rule gives for H, and
   * S-hat, symmetric, that of the middle. Derived in doc/method.md.
   *
   * Used by the internal force for each batch of points. Cost: some hundred
   * operations a point, in space with tangent some thousand.
   */
  template <int dim>
  class MiddleStep
  {
  public:
    /**
     * Replace L by H in the batch's displacement gradients.
     * @return index of the first point with det(I - L/2) <= 0; n_points if
     *   there is none
     */
    unsigned int
    to_start(StressBatch<dim> &batch);

    /**
     * Replace what the rule gave by that of the middle: H by L, P by S-hat,
     * dP/dH by dS-hat/dL.
     */
    void
    to_middle(StressBatch<dim> &batch) const;

    /** (I - L/2)^-1: F_mid = Z F_t. */
    const dealii::Tensor<2, dim> &
    from_start(const unsigned int q) const
    {
      return Z[q];
    }

  private:
    std::array<dealii::Tensor<2, dim>, max_batch_points> L, Z;
  };

  /**
   * (I - L/2)^-1, from the configuration at t to that of the middle; empty
   * if its determinant is not positive.
   */
  template <int dim>
  bool
  middle_from_start(const dealii::Tensor<2, dim> &L, dealii::Tensor<2, dim> &Z);
} // namespace emmy

#endif
