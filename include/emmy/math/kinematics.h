#ifndef emmy_math_kinematics_h
#define emmy_math_kinematics_h

#include <deal.II/base/symmetric_tensor.h>

#include <emmy/math/mandel.h>

namespace emmy
{
  /**
   * What the displacement gradient H of one step says about a point, with the
   * configuration at the start of the step as reference. In plane strain the
   * increment's 33 component is 1.
   */
  template <int dim>
  struct StepKinematics
  {
    dealii::Tensor<2, dim> increment;         ///< Delta F = I + H
    dealii::Tensor<2, dim> increment_inverse; ///< Delta F^-1
    dealii::Tensor<2, dim> increment_mid;     ///< (I + Delta F)/2
    /** Delta F^T Delta F - I = H + H^T + H^T H, without subtraction. */
    MandelVector<dim> metric_change;
  };

  /**
   * Kinematics of one step at one point (formulation of the step relative to
   * the configuration at t; Pretti et al. 2023, eqs 40-46).
   *
   * @param H displacement gradient of the step, d u_i / d x_j at t.
   * @pre   det(I + H) > 0; the caller's point loop checks and reports.
   */
  template <int dim>
  inline StepKinematics<dim>
  step_kinematics(const dealii::Tensor<2, dim> &H)
  {
    const dealii::Tensor<2, dim> I = dealii::unit_symmetric_tensor<dim>();
    StepKinematics<dim>          result;
    result.increment         = I + H;
    result.increment_mid     = I + 0.5 * H;
    result.increment_inverse = dealii::invert(result.increment);
    result.metric_change =
      mandel::symmetric_part<dim>(2. * H + transpose(H) * H);
    return result;
  }
} // namespace emmy

#endif
