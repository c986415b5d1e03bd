#include <emmy/material/hencky_kernels.h>
#include <emmy/math/lane_logarithm.h>

// vectors stay within these files
#pragma GCC diagnostic ignored "-Wpsabi"

namespace emmy
{
  namespace
  {
    /** As logarithm_quotient(), without a branch. */
    EMMY_INLINE void
    find_quotient(const Lanes &x,
                  const Lanes &y,
                  const Lanes &log_ratio,
                  Lanes       &result)
    {
      const Lanes z = (x - y) / (2. + x + y), z2 = z * z;
      Lanes       series  = z2 / 11. + 1. / 9.;
      series              = series * z2 + 1. / 7.;
      series              = series * z2 + 1. / 5.;
      series              = series * z2 + 1. / 3.;
      series              = series * z2 + 1.;
      const auto  is_far  = z2 > 1e-3;
      const Lanes divisor = is_far ? 2. * z : Lanes{} + 1.;
      result              = is_far ? log_ratio / divisor : series;
    }

    template <int dim>
    EMMY_INLINE void
    evaluate_lanes(PrincipalLanes<dim> &at, HenckyLanes<dim> &law)
    {
      constexpr auto         ij = mandel::pairs<dim>();
      constexpr unsigned int m  = n_in_plane<dim>;
      const double           K = law.bulk_modulus, G = law.shear_modulus;

      Lanes log_b[3];
      for (int i = 0; i < 3; ++i)
        log_one_plus(at.values[i], log_b[i]);
      const Lanes trace            = 0.5 * (log_b[0] + log_b[1] + log_b[2]);
      Lanes       deviator_squared = Lanes{};
      for (int i = 0; i < 3; ++i)
        {
          const Lanes deviator = 0.5 * log_b[i] - trace / 3.;
          deviator_squared += deviator * deviator;
          law.tau[i] = K * trace + 2. * G * deviator;
        }
      law.energy = 0.5 * K * trace * trace + G * deviator_squared;

      Lanes stress[n_mandel<dim>];
      for (unsigned int a = 0; a < m; ++a)
        {
          const auto &of_i = at.vectors[ij[a][0]], &of_j = at.vectors[ij[a][1]];
          Lanes       sum = of_i[0] * of_j[0] * law.tau[0];
          for (int c = 1; c < dim; ++c)
            sum += of_i[c] * of_j[c] * law.tau[c];
          stress[a] = a < dim ? sum : mandel::sqrt2 * sum;
        }
      if constexpr (dim == 2)
        stress[3] = law.tau[2];
      write_points<n_mandel<dim>>(stress, at.points, law.stress);

      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          at.normal[i][j] = Lanes{} + (K - 2. / 3. * G) +
                            (i == j ? 2. * G - 2. * law.tau[i] : Lanes{});
      for (unsigned int a = dim; a < m; ++a)
        {
          const unsigned int i = ij[a][0], j = ij[a][1];
          Lanes              quotient;
          find_quotient(at.values[i],
                        at.values[j],
                        log_b[i] - log_b[j],
                        quotient);
          at.shear[a - dim] = 2. * G * quotient - (law.tau[i] + law.tau[j]);
        }
    }
  } // namespace

  namespace hencky_kernels
  {
    // no templates: those have no clones
    EMMY_CLONES void
    evaluate(PrincipalLanes<2> &at, HenckyLanes<2> &law)
    {
      evaluate_lanes<2>(at, law);
    }
    EMMY_CLONES void
    evaluate(PrincipalLanes<3> &at, HenckyLanes<3> &law)
    {
      evaluate_lanes<3>(at, law);
    }
  } // namespace hencky_kernels
} // namespace emmy
