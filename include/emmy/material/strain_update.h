#ifndef emmy_material_strain_update_h
#define emmy_material_strain_update_h

#include <deal.II/base/tensor.h>

#include <emmy/math/mandel.h>

namespace emmy
{
  /** What update_strains() finds besides, of each point. */
  struct StrainMeasures
  {
    /** det(I + H); not positive, or not a number: turned inside out. */
    double *determinants;
    /** |C - C_t|^2, with C - C_t = H + H^T + H^T H. */
    double *squares_of_change;
  };

  /**
   * What a step makes of left Cauchy-Green tensors, total or elastic: those
   * of left_cauchy_green_less_unit(), for points side by side (math/lanes.h),
   * with the same bits on all instruction sets.
   *
   * @param H        displacement gradients of the step, of each point
   * @param old      b - I at t
   * @param n_points how many there are
   * @param result   b - I at the end
   * @param measures of the step
   */
  template <int dim>
  void
  update_strains(const dealii::Tensor<2, dim> *H,
                 const MandelVector<dim>      *old,
                 const unsigned int            n_points,
                 MandelVector<dim>            *result,
                 const StrainMeasures         &measures);
} // namespace emmy

#endif
