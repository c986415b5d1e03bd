#ifndef emmy_material_lane_tensors_h
#define emmy_material_lane_tensors_h

#include <emmy/math/lanes.h>
#include <emmy/math/mandel.h>

/** Tensors of points side by side, for functions with clones. */
namespace emmy
{
  /** result = X Y */
  template <int dim>
  EMMY_INLINE void
  product(const Lanes (&X)[dim][dim],
          const Lanes (&Y)[dim][dim],
          Lanes (&result)[dim][dim])
  {
    for (int i = 0; i < dim; ++i)
      for (int j = 0; j < dim; ++j)
        {
          Lanes sum = X[i][0] * Y[0][j];
          for (int k = 1; k < dim; ++k)
            sum += X[i][k] * Y[k][j];
          result[i][j] = sum;
        }
  }

  /** result = X Y^T */
  template <int dim>
  EMMY_INLINE void
  product_transposed(const Lanes (&X)[dim][dim],
                     const Lanes (&Y)[dim][dim],
                     Lanes (&result)[dim][dim])
  {
    for (int i = 0; i < dim; ++i)
      for (int j = 0; j < dim; ++j)
        {
          Lanes sum = X[i][0] * Y[j][0];
          for (int k = 1; k < dim; ++k)
            sum += X[i][k] * Y[j][k];
          result[i][j] = sum;
        }
  }

  /** result = X Y X^T for a symmetric Y: exactly symmetric. */
  template <int dim>
  EMMY_INLINE void
  congruence(const Lanes (&X)[dim][dim],
             const Lanes (&Y)[dim][dim],
             Lanes (&result)[dim][dim])
  {
    Lanes XY[dim][dim];
    product<dim>(X, Y, XY);
    for (int i = 0; i < dim; ++i)
      for (int j = 0; j <= i; ++j)
        {
          Lanes sum = XY[i][0] * X[j][0];
          for (int k = 1; k < dim; ++k)
            sum += XY[i][k] * X[j][k];
          result[i][j] = result[j][i] = sum;
        }
  }

  /** A symmetric tensor from Mandel notation, in the plane. */
  template <int dim>
  EMMY_INLINE void
  from_mandel(const Lanes (&a)[n_mandel<dim>], Lanes (&result)[dim][dim])
  {
    constexpr auto ij = mandel::pairs<dim>();
    for (int c = 0; c < dim; ++c)
      result[c][c] = a[c];
    for (unsigned int c = dim; c < n_in_plane<dim>; ++c)
      result[ij[c][0]][ij[c][1]] = result[ij[c][1]][ij[c][0]] =
        a[c] / mandel::sqrt2;
  }

  /** result = X : Y */
  template <int dim>
  EMMY_INLINE void
  contraction(const Lanes (&X)[dim][dim],
              const Lanes (&Y)[dim][dim],
              Lanes &result)
  {
    result = X[0][0] * Y[0][0];
    for (int k = 1; k < dim * dim; ++k)
      result += X[k / dim][k % dim] * Y[k / dim][k % dim];
  }

  /** result = F^-1 */
  template <int dim>
  EMMY_INLINE void
  invert(const Lanes (&F)[dim][dim], Lanes (&result)[dim][dim])
  {
    if constexpr (dim == 2)
      {
        const Lanes scale = 1. / (F[0][0] * F[1][1] - F[0][1] * F[1][0]);
        result[0][0]      = F[1][1] * scale;
        result[1][1]      = F[0][0] * scale;
        result[0][1]      = -F[0][1] * scale;
        result[1][0]      = -F[1][0] * scale;
      }
    else
      {
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j)
            result[j][i] =
              F[(i + 1) % 3][(j + 1) % 3] * F[(i + 2) % 3][(j + 2) % 3] -
              F[(i + 1) % 3][(j + 2) % 3] * F[(i + 2) % 3][(j + 1) % 3];
        const Lanes scale =
          1. / (F[0][0] * result[0][0] + F[0][1] * result[1][0] +
                F[0][2] * result[2][0]);
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j)
            result[i][j] *= scale;
      }
  }
} // namespace emmy

#endif
