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
    strain_of(const PrincipalLanes<dim> &at, HenckyLanes<dim> &law)
    {
      for (int i = 0; i < 3; ++i)
        log_one_plus(at.values[i], law.log_b[i]);
      law.trace            = 0.5 * (law.log_b[0] + law.log_b[1] + law.log_b[2]);
      law.deviator_squared = Lanes{};
      for (int i = 0; i < 3; ++i)
        {
          law.deviator[i] = 0.5 * law.log_b[i] - law.trace / 3.;
          law.deviator_squared += law.deviator[i] * law.deviator[i];
        }
    }

    template <int dim>
    EMMY_INLINE void
    stress_of(const PrincipalLanes<dim> &at, HenckyLanes<dim> &law, double *to)
    {
      constexpr auto         ij = mandel::pairs<dim>();
      constexpr unsigned int m  = n_in_plane<dim>;
      const double           K  = law.bulk_modulus;
      const Lanes            G  = law.shear_modulus * law.kept;
      for (int i = 0; i < 3; ++i)
        law.tau[i] = K * law.trace + 2. * G * law.deviator[i];
      law.energy =
        0.5 * K * law.trace * law.trace + G * law.kept * law.deviator_squared;

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
      write_points<n_mandel<dim>>(stress, at.points, to);
    }

    template <int dim>
    EMMY_INLINE void
    tangent_of(PrincipalLanes<dim> &at, const HenckyLanes<dim> &law)
    {
      constexpr auto ij = mandel::pairs<dim>();
      const double   K  = law.bulk_modulus;
      const Lanes    G  = law.shear_modulus * law.kept;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          at.normal[i][j] =
            K - 2. / 3. * G + (i == j ? 2. * G - 2. * law.tau[i] : Lanes{});
      for (unsigned int a = dim; a < n_in_plane<dim>; ++a)
        {
          const unsigned int i = ij[a][0], j = ij[a][1];
          Lanes              quotient;
          find_quotient(at.values[i],
                        at.values[j],
                        law.log_b[i] - law.log_b[j],
                        quotient);
          at.shear[a - dim] = 2. * G * quotient - (law.tau[i] + law.tau[j]);
        }
    }
  } // namespace

  namespace hencky_kernels
  {
    // no templates: those have no clones
    EMMY_CLONES void
    find_strain(const PrincipalLanes<2> &at, HenckyLanes<2> &law)
    {
      strain_of<2>(at, law);
    }
    EMMY_CLONES void
    find_strain(const PrincipalLanes<3> &at, HenckyLanes<3> &law)
    {
      strain_of<3>(at, law);
    }
    EMMY_CLONES void
    find_stress(const PrincipalLanes<2> &at,
                HenckyLanes<2>          &law,
                double                  *stress)
    {
      stress_of<2>(at, law, stress);
    }
    EMMY_CLONES void
    find_stress(const PrincipalLanes<3> &at,
                HenckyLanes<3>          &law,
                double                  *stress)
    {
      stress_of<3>(at, law, stress);
    }
    EMMY_CLONES void
    find_tangent(PrincipalLanes<2> &at, const HenckyLanes<2> &law)
    {
      tangent_of<2>(at, law);
    }
    EMMY_CLONES void
    find_tangent(PrincipalLanes<3> &at, const HenckyLanes<3> &law)
    {
      tangent_of<3>(at, law);
    }
  } // namespace hencky_kernels
} // namespace emmy
