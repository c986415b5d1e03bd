#ifndef emmy_math_divided_volume_h
#define emmy_math_divided_volume_h

#include <deal.II/base/tensor.h>

namespace emmy
{
  /** cof T = det T T^-T, of real and complex tensors. */
  template <class Number>
  dealii::Tensor<2, 2, Number>
  cofactor_of(const dealii::Tensor<2, 2, Number> &T)
  {
    dealii::Tensor<2, 2, Number> result;
    result[0][0] = T[1][1];
    result[0][1] = -T[1][0];
    result[1][0] = -T[0][1];
    result[1][1] = T[0][0];
    return result;
  }
  /** Of the third order: det(T) T^-T, also where T is singular. */
  template <class Number>
  dealii::Tensor<2, 3, Number>
  cofactor_of(const dealii::Tensor<2, 3, Number> &T)
  {
    dealii::Tensor<2, 3, Number> result;
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j)
        {
          const unsigned int k = (i + 1) % 3, l = (i + 2) % 3;
          const unsigned int m = (j + 1) % 3, n = (j + 2) % 3;
          result[i][j] = T[k][m] * T[l][n] - T[k][n] * T[l][m];
        }
    return result;
  }

  /** I + s T */
  template <int dim, class Number>
  dealii::Tensor<2, dim, Number>
  unit_plus(const double s, const dealii::Tensor<2, dim, Number> &T)
  {
    dealii::Tensor<2, dim, Number> result = Number(s) * T;
    for (unsigned int d = 0; d < dim; ++d)
      result[d][d] += Number(1.);
    return result;
  }

  /**
   * The divided difference of the volume in a step: D with D : A = j - 1
   * exactly, where A = dF^T dF - I and j = det dF. It is the mean of
   * cof(I + s A) over s from 0 to 1, whose product with A is
   * det(I + A) - 1 = j^2 - 1, over j + 1: in the plane cof(I + A/2)/(j + 1), in
   * space by Simpson's rule
   * (cof I + 4 cof(I + A/2) + cof(I + A))/(6 (j + 1)).
   * Of real and complex numbers, so that it can be differentiated by a step
   * into the imaginary ones.
   */
  template <int dim, class Number>
  dealii::Tensor<2, dim, Number>
  divided_volume(const dealii::Tensor<2, dim, Number> &A, const Number &j)
  {
    const auto middle = cofactor_of(unit_plus(0.5, A));
    if constexpr (dim == 2)
      return middle / (j + 1.);
    else
      return (unit_plus(4., middle) + cofactor_of(unit_plus(1., A))) /
             (6. * (j + 1.));
  }
} // namespace emmy

#endif
