#ifndef emmy_math_mandel_h
#define emmy_math_mandel_h

#include <deal.II/base/tensor.h>

#include <array>
#include <cmath>

namespace emmy
{
  /**
   * Symmetric second-order tensors in three dimensions, written as vectors in
   * Mandel (orthonormal) notation, so that a double contraction is the scalar
   * product of two vectors and a fourth-order tensor with both minor
   * symmetries is a plain matrix.
   *
   * Components: in 3D (11, 22, 33, s 12, s 13, s 23) with s = sqrt(2). In
   * plane strain (dim = 2) the tensors stay three-dimensional; what can be
   * different from zero is (11, 22, s 12, 33). The first
   * n_in_plane<dim> components are always those of the dim x dim block.
   */
  template <int dim>
  constexpr unsigned int n_mandel = (dim == 2) ? 4 : 6;

  /** Number of components of a symmetric dim x dim tensor. */
  template <int dim>
  constexpr unsigned int n_in_plane = dim *(dim + 1) / 2;

  /** A symmetric second-order tensor in Mandel notation. */
  template <int dim>
  using MandelVector = dealii::Tensor<1, n_mandel<dim>>;

  /** A fourth-order tensor with both minor symmetries in Mandel notation. */
  template <int dim>
  using MandelMatrix = dealii::Tensor<2, n_mandel<dim>>;

  namespace mandel
  {
    constexpr double sqrt2 = 1.4142135623730950488;

    /** Row and column of each in-plane component. */
    template <int dim>
    constexpr std::array<std::array<unsigned int, 2>, n_in_plane<dim>>
    pairs()
    {
      if constexpr (dim == 2)
        return {{{{0, 0}}, {{1, 1}}, {{0, 1}}}};
      else
        return {{{{0, 0}}, {{1, 1}}, {{2, 2}}, {{0, 1}}, {{0, 2}}, {{1, 2}}}};
    }

    /** Where the three normal components 11, 22, 33 stand. */
    template <int dim>
    constexpr std::array<unsigned int, 3>
    normal_components()
    {
      if constexpr (dim == 2)
        return {{0, 1, 3}};
      else
        return {{0, 1, 2}};
    }

    /** The second-order unit tensor. */
    template <int dim>
    MandelVector<dim>
    unit()
    {
      MandelVector<dim> result;
      for (const unsigned int i : normal_components<dim>())
        result[i] = 1.;
      return result;
    }

    /** a + I, for tensors that are carried without their unit. */
    template <int dim>
    MandelVector<dim>
    plus_unit(MandelVector<dim> a)
    {
      for (const unsigned int i : normal_components<dim>())
        a[i] += 1.;
      return a;
    }

    /** The dim x dim block as a full tensor. */
    template <int dim>
    dealii::Tensor<2, dim>
    block(const MandelVector<dim> &a)
    {
      constexpr auto         ij = pairs<dim>();
      dealii::Tensor<2, dim> result;
      for (unsigned int c = 0; c < dim; ++c)
        result[c][c] = a[c];
      for (unsigned int c = dim; c < n_in_plane<dim>; ++c)
        {
          result[ij[c][0]][ij[c][1]] = a[c] / sqrt2;
          result[ij[c][1]][ij[c][0]] = a[c] / sqrt2;
        }
      return result;
    }

    /**
     * The symmetric part of a dim x dim tensor; in plane strain the 33
     * component is @p out_of_plane.
     */
    template <int dim>
    MandelVector<dim>
    symmetric_part(const dealii::Tensor<2, dim> &a,
                   const double                  out_of_plane = 0.)
    {
      constexpr auto    ij = pairs<dim>();
      MandelVector<dim> result;
      for (unsigned int c = 0; c < dim; ++c)
        result[c] = a[c][c];
      for (unsigned int c = dim; c < n_in_plane<dim>; ++c)
        result[c] = (a[ij[c][0]][ij[c][1]] + a[ij[c][1]][ij[c][0]]) / sqrt2;
      if constexpr (dim == 2)
        result[3] = out_of_plane;
      return result;
    }

    /** Trace, second invariant (tr(a)^2 - tr(a^2))/2, and determinant. */
    template <int dim>
    std::array<double, 3>
    invariants(const MandelVector<dim> &a)
    {
      const auto A = block<dim>(a);
      if constexpr (dim == 2)
        {
          const double in_plane = determinant(A), trace = A[0][0] + A[1][1];
          return {{trace + a[3], in_plane + trace * a[3], in_plane * a[3]}};
        }
      else
        {
          double second = 0.;
          for (unsigned int i = 0; i < 3; ++i)
            {
              const unsigned int j = (i + 1) % 3;
              second += A[i][i] * A[j][j] - A[i][j] * A[j][i];
            }
          return {{trace(A), second, determinant(A)}};
        }
    }

    /** det(I + a) - 1, without the cancellation of the difference. */
    template <int dim>
    double
    determinant_less_one(const MandelVector<dim> &a)
    {
      const auto [first, second, third] = invariants<dim>(a);
      return first + second + third;
    }

    /**
     * The matrix Q of the congruence X -> G X G^T. In plane strain G_33 = 1.
     * Its transpose is the congruence with G^T, its inverse the one with
     * G^-1.
     */
    template <int dim>
    MandelMatrix<dim>
    congruence(const dealii::Tensor<2, dim> &G)
    {
      constexpr auto    ij = pairs<dim>();
      MandelMatrix<dim> Q;
      for (unsigned int a = 0; a < n_in_plane<dim>; ++a)
        {
          const unsigned int i = ij[a][0], j = ij[a][1];
          const double       row_factor = a < dim ? 1. : sqrt2;
          for (unsigned int c = 0; c < dim; ++c)
            Q[a][c] = row_factor * G[i][c] * G[j][c];
          for (unsigned int c = dim; c < n_in_plane<dim>; ++c)
            {
              const unsigned int k = ij[c][0], l = ij[c][1];
              Q[a][c] = (G[i][k] * G[j][l] + G[i][l] * G[j][k]) *
                        (a < dim ? 1. / sqrt2 : 1.);
            }
        }
      if constexpr (dim == 2)
        Q[3][3] = 1.;
      return Q;
    }

    /** Q C Q^T, with Q from congruence(). */
    template <int dim>
    MandelMatrix<dim>
    transform(const MandelMatrix<dim> &Q, const MandelMatrix<dim> &C)
    {
      return Q * C * transpose(Q);
    }
  } // namespace mandel
} // namespace emmy

#endif
