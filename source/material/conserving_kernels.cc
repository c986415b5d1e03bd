#include <emmy/material/conserving_kernels.h>
#include <emmy/material/lane_tensors.h>

// vectors stay within these files
#pragma GCC diagnostic ignored "-Wpsabi"

namespace emmy
{
  namespace
  {
    /** Kinematics, S-bar (in S), B, and what decides on the correction. */
    template <int dim>
    EMMY_INLINE void
    find_means(Side<dim> &p)
    {
      const StressArrays &arrays = p.arrays;
      Lanes b_old[n_mandel<dim>], tau[n_mandel<dim>], tau_old[n_mandel<dim>];
      Lanes H[dim][dim];
      read_points<dim * dim>(arrays.H, p.points, H[0]);
      read_points<n_mandel<dim>>(arrays.b_old, p.points, b_old);
      read_points<n_mandel<dim>>(arrays.tau_old, p.points, tau_old);
      read_points<n_mandel<dim>>(arrays.tau, p.points, tau);
      for (int i = 0; i < dim; ++i)
        for (int j = 0; j < dim; ++j)
          {
            const double unit = i == j ? 1. : 0.;
            p.F[i][j]         = H[i][j] + unit;
            p.Fm[i][j]        = 0.5 * H[i][j] + unit;
          }
      invert<dim>(p.F, p.inverse);
      // A = H + H^T + H^T H, without subtraction
      for (int i = 0; i < dim; ++i)
        for (int j = 0; j <= i; ++j)
          {
            Lanes sum = H[0][i] * H[0][j];
            for (int k = 1; k < dim; ++k)
              sum += H[k][i] * H[k][j];
            p.A[i][j] = p.A[j][i] = (H[i][j] + H[j][i]) + sum;
          }
      from_mandel<dim>(b_old, p.b);
      for (int i = 0; i < dim; ++i)
        p.b[i][i] += 1.;
      congruence<dim>(p.b, p.A, p.B);
      Lanes end[dim][dim], start[dim][dim];
      from_mandel<dim>(tau, end);
      from_mandel<dim>(tau_old, start);
      congruence<dim>(p.inverse, end, p.S1);
      for (int i = 0; i < dim; ++i)
        for (int j = 0; j < dim; ++j)
          p.S[i][j] = 0.5 * (start[i][j] + p.S1[i][j]);
      contraction<dim>(p.S, p.A, p.work);
      contraction<dim>(p.A, p.B, p.nu);
    }

    template <int dim>
    EMMY_INLINE void
    find_stress(Side<dim> &p)
    {
      for (int i = 0; i < dim; ++i)
        for (int j = 0; j < dim; ++j)
          p.S[i][j] += p.correction * p.B[i][j];
      Lanes P[dim][dim];
      product<dim>(p.Fm, p.S, P);
      write_points<dim * dim>(P[0], p.points, p.arrays.P);
    }
  } // namespace

  namespace conserving_kernels
  {
    // no templates: those have no clones
    EMMY_CLONES void
    means(Side<2> &p)
    {
      find_means<2>(p);
    }
    EMMY_CLONES void
    means(Side<3> &p)
    {
      find_means<3>(p);
    }
    EMMY_CLONES void
    stress(Side<2> &p)
    {
      find_stress<2>(p);
    }
    EMMY_CLONES void
    stress(Side<3> &p)
    {
      find_stress<3>(p);
    }
  } // namespace conserving_kernels
} // namespace emmy
