#include <emmy/math/lane_points.h>
#include <emmy/math/spectral.h>

#include <algorithm>
#include <limits>

// vectors stay within this file
#pragma GCC diagnostic ignored "-Wpsabi"

namespace emmy
{
  namespace
  {
    /** Smaller components are zero: their squares would underflow. */
    constexpr double smallest = 1e-150;

    /**
     * One Jacobi rotation in the (p,q) plane of the symmetric tensor A, which
     * makes A[p][q] zero. V collects the rotations.
     */
    template <int dim>
    inline void
    rotate(const unsigned int      p,
           const unsigned int      q,
           dealii::Tensor<2, dim> &A,
           dealii::Tensor<2, dim> &V)
    {
      const double apq = A[p][q];
      if (std::abs(apq) < smallest)
        return;
      const double half = 0.5 * (A[q][q] - A[p][p]);
      // tan of the smaller rotation angle, without overflow or cancellation
      const double root = std::sqrt(half * half + apq * apq);
      const double t    = apq / (half >= 0. ? half + root : half - root);
      const double c = 1. / std::sqrt(1. + t * t), s = t * c;

      A[p][p] -= t * apq;
      A[q][q] += t * apq;
      A[p][q] = A[q][p] = 0.;
      for (unsigned int r = 0; r < dim; ++r)
        {
          if (r != p && r != q)
            {
              const double arp = A[r][p], arq = A[r][q];
              A[r][p] = A[p][r] = c * arp - s * arq;
              A[r][q] = A[q][r] = s * arp + c * arq;
            }
          const double vrp = V[r][p], vrq = V[r][q];
          V[r][p] = c * vrp - s * vrq;
          V[r][q] = s * vrp + c * vrq;
        }
    }
  } // namespace

  template <int dim>
  SpectralDecomposition<dim>
  spectral_decomposition(const MandelVector<dim> &a)
  {
    SpectralDecomposition<dim> result;
    dealii::Tensor<2, dim>     A = mandel::block<dim>(a);
    dealii::Tensor<2, dim>    &V = result.vectors;
    for (unsigned int d = 0; d < dim; ++d)
      V[d][d] = 1.;

    if constexpr (dim == 2)
      {
        rotate(0, 1, A, V);
        result.values = {{A[0][0], A[1][1], a[3]}};
      }
    else
      {
        // converges quadratically; the bound is never met in practice
        for (unsigned int sweep = 0; sweep < 30; ++sweep)
          {
            const double off =
              A[0][1] * A[0][1] + A[0][2] * A[0][2] + A[1][2] * A[1][2];
            const double diagonal =
              A[0][0] * A[0][0] + A[1][1] * A[1][1] + A[2][2] * A[2][2];
            constexpr double epsilon = std::numeric_limits<double>::epsilon();
            if (off <= 1e-4 * epsilon * epsilon * diagonal)
              break;
            rotate(0, 1, A, V);
            rotate(0, 2, A, V);
            rotate(1, 2, A, V);
          }
        result.values = {{A[0][0], A[1][1], A[2][2]}};
      }
    return result;
  }

  namespace
  {
    /** Tensors and rotations, component by component. */
    template <int dim>
    struct SpectralBatch
    {
      using PerTensor = typename SpectralArrays<dim>::PerTensor;

      const double *tensors; ///< in, as mandel has them
      PerTensor (&V)[dim][dim];
      PerTensor (&values)[3];

      PerTensor A[dim][dim]; ///< A[p][q] with p <= q
      PerTensor open;        ///< 1: not yet diagonal, 0: done

      SpectralBatch(const double *tensors, SpectralArrays<dim> &result)
        : tensors(tensors)
        , V(result.vectors)
        , values(result.values)
      {}

      /** Tensors [0, n) and what fills up the last register. */
      EMMY_INLINE void
      read(const unsigned int n)
      {
        constexpr auto ij = mandel::pairs<dim>();
        for (unsigned int first = 0; first < n; first += n_lanes)
          {
            Lanes a[n_mandel<dim>];
            read_points<n_mandel<dim>>(tensors, LanePoints(first, n), a);
            for (unsigned int c = 0; c < n_in_plane<dim>; ++c)
              write_together(c < dim ? a[c] : a[c] / mandel::sqrt2,
                             &A[ij[c][0]][ij[c][1]][first]);
            for (int p = 0; p < dim; ++p)
              for (int q = 0; q < dim; ++q)
                write_together(Lanes{} + (p == q ? 1. : 0.), &V[p][q][first]);
            write_together(Lanes{} + 1., &open[first]);
            if constexpr (dim == 2)
              write_together(a[3], &values[2][first]);
          }
      }

      /** One Jacobi rotation of all that are open, as rotate() does it. */
      EMMY_INLINE void
      rotate(const unsigned int p, const unsigned int q, const unsigned int n)
      {
        PerTensor c, s;
        for (unsigned int k = 0; k < n; ++k)
          {
            const double apq   = A[p][q][k];
            const bool   is_on = open[k] * std::abs(apq) >= smallest;
            const double half  = 0.5 * (A[q][q][k] - A[p][p][k]);
            const double root  = std::sqrt(half * half + apq * apq);
            const double sum = half + root, difference = half - root;
            const double denominator = half >= 0. ? sum : difference;
            const double t = is_on ? apq / (is_on ? denominator : 1.) : 0.;
            c[k]           = 1. / std::sqrt(1. + t * t);
            s[k]           = t * c[k];
            A[p][p][k] -= t * apq;
            A[q][q][k] += t * apq;
            A[p][q][k] = is_on ? 0. : apq;
          }
        for (unsigned int r = 0; r < dim; ++r)
          {
            if (r != p && r != q)
              turn(A[std::min(r, p)][std::max(r, p)],
                   A[std::min(r, q)][std::max(r, q)],
                   c,
                   s,
                   n);
            turn(V[r][p], V[r][q], c, s, n);
          }
      }

      static EMMY_INLINE void
      turn(PerTensor          x,
           PerTensor          y,
           const PerTensor    c,
           const PerTensor    s,
           const unsigned int n)
      {
        for (unsigned int k = 0; k < n; ++k)
          {
            const double xk = x[k], yk = y[k];
            x[k] = c[k] * xk - s[k] * yk;
            y[k] = s[k] * xk + c[k] * yk;
          }
      }

      /** Find out which are not yet diagonal. @return whether any is. */
      EMMY_INLINE bool
      find_open(const unsigned int n)
      {
        double any = 0.;
        for (unsigned int k = 0; k < n; ++k)
          {
            double off = 0., diagonal = 0.;
            if constexpr (dim == 3)
              {
                off = A[0][1][k] * A[0][1][k] + A[0][2][k] * A[0][2][k] +
                      A[1][2][k] * A[1][2][k];
                diagonal = A[0][0][k] * A[0][0][k] + A[1][1][k] * A[1][1][k] +
                           A[2][2][k] * A[2][2][k];
              }
            constexpr double epsilon = std::numeric_limits<double>::epsilon();
            open[k] = off <= 1e-4 * epsilon * epsilon * diagonal ? 0. : 1.;
            any += open[k];
          }
        return any > 0.;
      }

      EMMY_INLINE void
      diagonalise(const unsigned int n)
      {
        if constexpr (dim == 2)
          rotate(0, 1, n);
        else
          for (unsigned int sweep = 0; sweep < 30 && find_open(n); ++sweep)
            {
              rotate(0, 1, n);
              rotate(0, 2, n);
              rotate(1, 2, n);
            }
      }

      EMMY_INLINE void
      find(const unsigned int n)
      {
        const unsigned int n_filled = (n + n_lanes - 1) / n_lanes * n_lanes;
        read(n);
        diagonalise(n_filled);
        for (int d = 0; d < dim; ++d)
          for (unsigned int k = 0; k < n_filled; ++k)
            values[d][k] = A[d][d][k];
      }
    };
  } // namespace

  namespace spectral_kernels
  {
    // no templates: those have no clones
    EMMY_CLONES void
    diagonalise(SpectralBatch<2> &batch, const unsigned int n)
    {
      batch.find(n);
    }
    EMMY_CLONES void
    diagonalise(SpectralBatch<3> &batch, const unsigned int n)
    {
      batch.find(n);
    }
  } // namespace spectral_kernels

  template <int dim>
  void
  spectral_decompositions(const MandelVector<dim> *a,
                          const unsigned int       n,
                          SpectralArrays<dim>     &result)
  {
    SpectralBatch<dim> batch(a[0].begin_raw(), result);
    spectral_kernels::diagonalise(batch, n);
  }

  template <int dim>
  void
  spectral_decompositions(const MandelVector<dim>    *a,
                          const unsigned int          n,
                          SpectralDecomposition<dim> *result)
  {
    SpectralArrays<dim> arrays;
    spectral_decompositions(a, n, arrays);
    for (unsigned int k = 0; k < n; ++k)
      result[k] = arrays.of(k);
  }

  template void
  spectral_decompositions<2>(const MandelVector<2> *,
                             const unsigned int,
                             SpectralArrays<2> &);
  template void
  spectral_decompositions<3>(const MandelVector<3> *,
                             const unsigned int,
                             SpectralArrays<3> &);
  template void
  spectral_decompositions<2>(const MandelVector<2> *,
                             const unsigned int,
                             SpectralDecomposition<2> *);
  template void
  spectral_decompositions<3>(const MandelVector<3> *,
                             const unsigned int,
                             SpectralDecomposition<3> *);
  template SpectralDecomposition<2>
  spectral_decomposition<2>(const MandelVector<2> &);
  template SpectralDecomposition<3>
  spectral_decomposition<3>(const MandelVector<3> &);
} // namespace emmy
