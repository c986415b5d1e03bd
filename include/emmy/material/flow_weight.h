#ifndef emmy_material_flow_weight_h
#define emmy_material_flow_weight_h

#include <emmy/material/material.h>

namespace emmy
{
  /**
   * How much the stress at the end of a step counts in the mean from which an
   * energy-conserving stress is made, as far as its deviator goes:
   * @f[ w = 1 - \tfrac14 x (3 - x), \quad
   *     x = |\mathrm{dev}\,\varepsilon^e| /
   *         |\mathrm{dev}\,\varepsilon^e_{tr}| , @f]
   * with the elastic strains after the flow of the step and without it: 1/2
   * where nothing flows, as in the trapezoidal rule, and towards 1 as flow
   * prevails.
   *
   * Why: let a point flow at the stress Y and turn the direction n of its flow
   * during the step. The trapezoidal rule, made to conserve by a part along the
   * strain A of the step, keeps (tau_t - (n : tau_t) n)/2, which does no work.
   * Its derivative, Y/|A| in size, couples a turn of n with more of the same
   * flow, and only one way: the tangent is indefinite, and a step can have no
   * solution that Newton could find. With the end alone this is so where a
   * point just begins to flow. With this weight the tangent of ideal flow at
   * small strain is positive for all steps and turns (tried for steps from 0.3
   * to 20 elastic strains). At the onset of flow, x = 1, w is continuous.
   *
   * Cost: two spectral decompositions for a point that flows, else nothing.
   */
  template <int dim>
  struct FlowWeight
  {
    /** Components of a symmetric tensor in the dim x dim block. */
    using InPlane = dealii::Tensor<1, n_in_plane<dim>>;

    double  value = 0.5;
    InPlane by_C;        ///< dw/dC
    double  by_log = 0.; ///< dw/d ln theta, see MeanDilatationStress

    /**
     * What happened to a point: elastic b - I of the trial and at the end, the
     * stress with its spatial tangent, and the congruence of Delta F^-1.
     */
    struct Step
    {
      const dealii::Tensor<1, n_mandel<dim>> &trial, &end, &stress;
      const dealii::Tensor<2, n_mandel<dim>> &tangent, &congruence;
    };

    /**
     * Of a step. The derivatives hold where stress follows the elastic strain
     * linearly in the deviator, as with Hencky elasticity.
     */
    FlowWeight(const Step &step, const bool with_derivative);
  };
} // namespace emmy

#endif
