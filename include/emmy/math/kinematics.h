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

  /**
   * What a step makes of a left Cauchy-Green tensor, total or elastic:
   * b = (I + H) b_t (I + H)^T, from b_t - I to b - I, without forming and
   * subtracting the unit tensor, so that small strains keep all their digits.
   */
  template <int dim>
  inline MandelVector<dim>
  left_cauchy_green_less_unit(const dealii::Tensor<2, dim> &H,
                              const MandelVector<dim>      &less_unit_old)
  {
    // M = H b_t; b - b_t = M + M^T + M H^T, and the last is symmetric
    const dealii::Tensor<2, dim> M = H + H * mandel::block<dim>(less_unit_old);
    return less_unit_old +
           mandel::symmetric_part<dim>(2. * M + M * transpose(H));
  }
} // namespace emmy

#endif
