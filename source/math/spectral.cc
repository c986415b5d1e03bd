#include <emmy/math/spectral.h>

#include <limits>

namespace emmy
{
  namespace
  {
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
      if (apq == 0.)
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

  template SpectralDecomposition<2>
  spectral_decomposition<2>(const MandelVector<2> &);
  template SpectralDecomposition<3>
  spectral_decomposition<3>(const MandelVector<3> &);
} // namespace emmy
