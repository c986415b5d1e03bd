#include <emmy/material/middle_step.h>

namespace emmy
{
  using dealii::Tensor;

  template <int dim>
  bool
  middle_from_start(const Tensor<2, dim> &L, Tensor<2, dim> &Z)
  {
    Tensor<2, dim> inverse = -0.5 * L;
    for (unsigned int d = 0; d < dim; ++d)
      inverse[d][d] += 1.;
    if (!(determinant(inverse) > 0.))
      return false;
    Z = invert(inverse);
    return true;
  }

  template <int dim>
  unsigned int
  MiddleStep<dim>::to_start(StressBatch<dim> &batch)
  {
    for (unsigned int q = 0; q < batch.n_points; ++q)
      {
        L[q] = batch.displacement_gradient[q];
        if (!middle_from_start(L[q], Z[q]))
          return q;
        batch.displacement_gradient[q] = L[q] * Z[q];
      }
    return batch.n_points;
  }

  namespace
  {
    /**
     * dS-hat/dL = dP/dH[Z dL Z] Z^T + P (Z dL Z/2)^T, row i*dim+J, column
     * m*dim+L.
     */
    template <int dim>
    Tensor<2, dim * dim>
    middle_tangent(const Tensor<2, dim * dim> &tangent,
                   const Tensor<2, dim>       &P,
                   const Tensor<2, dim>       &Z)
    {
      // columns: dP/dL_ab = sum dP/dH_mn Z_ma Z_bn
      Tensor<2, dim * dim> half, by_L, result;
      for (unsigned int row = 0; row < dim * dim; ++row)
        {
          for (unsigned int m = 0; m < dim; ++m)
            for (unsigned int b = 0; b < dim; ++b)
              for (unsigned int n = 0; n < dim; ++n)
                half[row][m * dim + b] += tangent[row][m * dim + n] * Z[b][n];
          for (unsigned int a = 0; a < dim; ++a)
            for (unsigned int b = 0; b < dim; ++b)
              for (unsigned int m = 0; m < dim; ++m)
                by_L[row][a * dim + b] += half[row][m * dim + b] * Z[m][a];
        }
      // P_iK (Z dL Z)_JK / 2 = 1/2 Z_Ja dL_ab (Z P^T)_bi
      const Tensor<2, dim> ZPt = Z * transpose(P);
      for (unsigned int i = 0; i < dim; ++i)
        for (unsigned int J = 0; J < dim; ++J)
          for (unsigned int a = 0; a < dim; ++a)
            for (unsigned int b = 0; b < dim; ++b)
              {
                double sum = 0.5 * Z[J][a] * ZPt[b][i];
                for (unsigned int K = 0; K < dim; ++K)
                  sum += by_L[i * dim + K][a * dim + b] * Z[J][K];
                result[i * dim + J][a * dim + b] = sum;
              }
      return result;
    }
  } // namespace

  template <int dim>
  void
  MiddleStep<dim>::to_middle(StressBatch<dim> &batch) const
  {
    for (unsigned int q = 0; q < batch.n_points; ++q)
      {
        Tensor<2, dim> &P = batch.nominal_stress[q];
        if (batch.with_tangent)
          batch.tangent[q] = middle_tangent<dim>(batch.tangent[q], P, Z[q]);
        P                              = P * transpose(Z[q]);
        batch.displacement_gradient[q] = L[q];
      }
  }

#define INSTANTIATE(dim)                                       \
  template class MiddleStep<dim>;                              \
  template bool middle_from_start<dim>(const Tensor<2, dim> &, \
                                       Tensor<2, dim> &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
