#ifndef emmy_math_spectral_h
#define emmy_math_spectral_h

#include <emmy/math/mandel.h>

#include <array>

namespace emmy
{
  /**
   * Eigenvalues and eigenvectors of a symmetric tensor in three dimensions.
   * In plane strain the third eigenvector is the out-of-plane axis and is not
   * stored.
   */
  template <int dim>
  struct SpectralDecomposition
  {
    /** Eigenvalues, in no particular order; in plane strain the last is 33. */
    std::array<double, 3> values;
    /** Column i is the unit eigenvector of value i, i < dim. */
    dealii::Tensor<2, dim> vectors;
  };

  /**
   * Spectral decomposition by Jacobi rotations: accurate to round-off for
   * equal and nearly equal eigenvalues too. Cost: one rotation in plane
   * strain, about ten in 3D.
   *
   * Components below 1e-150 count as zero: their squares vanish.
   *
   * deal.II's eigenvectors() serves SymmetricTensor and sorts; here the
   * tensors are in Mandel notation and the order does not matter.
   */
  template <int dim>
  SpectralDecomposition<dim>
  spectral_decomposition(const MandelVector<dim> &a);

  constexpr unsigned int max_spectral_batch = 32; ///< tensors in a batch

  /**
   * Those of a batch, component by component: of tensor k at [k]. Behind the
   * last tensor it is repeated, up to a multiple of four.
   */
  template <int dim>
  struct SpectralArrays
  {
    using PerTensor = double[max_spectral_batch]; ///< one of each

    PerTensor values[3];         ///< as SpectralDecomposition::values
    PerTensor vectors[dim][dim]; ///< as SpectralDecomposition::vectors

    /** That of tensor k. */
    SpectralDecomposition<dim>
    of(const unsigned int k) const
    {
      SpectralDecomposition<dim> result;
      for (unsigned int d = 0; d < 3; ++d)
        result.values[d] = values[d][k];
      for (unsigned int i = 0; i < dim; ++i)
        for (unsigned int j = 0; j < dim; ++j)
          result.vectors[i][j] = vectors[i][j][k];
      return result;
    }
  };

  /**
   * The same of many tensors, with the same rotations and to the last bit the
   * same results, several times as fast: the loops over tensors vectorise, and
   * do not wait for one square root after the other.
   *
   * @param n from one to max_spectral_batch
   */
  template <int dim>
  void
  spectral_decompositions(const MandelVector<dim> *a,
                          const unsigned int       n,
                          SpectralArrays<dim>     &result);
  /** One after the other. */
  template <int dim>
  void
  spectral_decompositions(const MandelVector<dim>    *a,
                          const unsigned int          n,
                          SpectralDecomposition<dim> *result);

  /**
   * artanh(z)/z for z^2 up to 1e-3, by its series; the first dropped term is
   * below 1e-16.
   */
  inline double
  artanh_quotient(const double z2)
  {
    return 1. +
           z2 * (1. / 3. +
                 z2 * (1. / 5. + z2 * (1. / 7. + z2 * (1. / 9. + z2 / 11.))));
  }

  /**
   * artanh(z)/z with z = (a - b)/(a + b) for a = 1 + x, b = 1 + y positive,
   * which is (a + b)/2 times the divided difference of the logarithm,
   * (ln a - ln b)/(a - b). Safe for a = b (formulation of the derivative of
   * the logarithm without case distinction; Pretti et al. 2023, A.32).
   *
   * @param log_ratio ln a - ln b, which the callers have already.
   */
  inline double
  logarithm_quotient(const double x, const double y, const double log_ratio)
  {
    const double z = (x - y) / (2. + x + y), z2 = z * z;
    if (z2 > 1e-3)
      return log_ratio / (2. * z);
    return artanh_quotient(z2);
  }

  /**
   * ln(1 + x) for x > -1, to some units in the last digit: what 1 + x has lost
   * of x is made good by the factor. Much faster than std::log1p.
   */
  inline double
  log_one_plus(const double x)
  {
    const double sum = 1. + x, kept = sum - 1.;
    return kept == 0. ? x : std::log(sum) * (x / kept);
  }

  /** x - ln(1 + x) for x > -1, with all digits. */
  inline double
  less_log1p(const double x)
  {
    if (std::abs(x) > 0.1)
      return x - std::log1p(x);
    // with z = x/(2 + x), ln(1 + x) = 2 artanh z and x = 2 z/(1 - z); the
    // first dropped term is below 1e-17 of the result
    const double z = x / (2. + x), z2 = z * z;
    const double rest =
      1. / 3. +
      z2 * (1. / 5. +
            z2 * (1. / 7. + z2 * (1. / 9. + z2 * (1. / 11. + z2 / 13.))));
    return z * x - 2. * z * z2 * rest;
  }
} // namespace emmy

#endif
