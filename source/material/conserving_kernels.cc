#include <emmy/material/conserving_kernels.h>

// vectors stay within these files
#pragma GCC diagnostic ignored "-Wpsabi"

namespace emmy
{
  namespace
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

    template <int dim>
    EMMY_INLINE void
    from_mandel(const Lanes (&a)[n_in_plane<dim>], Lanes (&result)[dim][dim])
    {
      constexpr auto ij = mandel::pairs<dim>();
      for (int c = 0; c < dim; ++c)
        result[c][c] = a[c];
      for (unsigned int c = dim; c < n_in_plane<dim>; ++c)
        result[ij[c][0]][ij[c][1]] = result[ij[c][1]][ij[c][0]] =
          a[c] / mandel::sqrt2;
    }

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

    /** Kinematics, S-bar (in S), B, and what decides on the correction. */
    template <int dim>
    EMMY_INLINE void
    find_means(Side<dim> &p)
    {
      for (int i = 0; i < dim; ++i)
        for (int j = 0; j < dim; ++j)
          {
            const double unit = i == j ? 1. : 0.;
            p.F[i][j]         = p.H[i][j] + unit;
            p.Fm[i][j]        = 0.5 * p.H[i][j] + unit;
          }
      invert<dim>(p.F, p.inverse);
      // A = H + H^T + H^T H, without subtraction
      for (int i = 0; i < dim; ++i)
        for (int j = 0; j <= i; ++j)
          {
            Lanes sum = p.H[0][i] * p.H[0][j];
            for (int k = 1; k < dim; ++k)
              sum += p.H[k][i] * p.H[k][j];
            p.A[i][j] = p.A[j][i] = (p.H[i][j] + p.H[j][i]) + sum;
          }
      from_mandel<dim>(p.b_old, p.b);
      for (int i = 0; i < dim; ++i)
        p.b[i][i] += 1.;
      congruence<dim>(p.b, p.A, p.B);
      Lanes tau[dim][dim], tau_old[dim][dim];
      from_mandel<dim>(p.tau, tau);
      from_mandel<dim>(p.tau_old, tau_old);
      congruence<dim>(p.inverse, tau, p.S1);
      for (int i = 0; i < dim; ++i)
        for (int j = 0; j < dim; ++j)
          p.S[i][j] = 0.5 * (tau_old[i][j] + p.S1[i][j]);
      contraction<dim>(p.S, p.A, p.work);
      contraction<dim>(p.A, p.B, p.nu);
    }

    /** F g, with the derivative g of beta. */
    template <int dim>
    EMMY_INLINE void
    slope_of_correction(const Side<dim> &p, Lanes (&result)[dim][dim])
    {
      constexpr auto         ij = mandel::pairs<dim>();
      constexpr unsigned int m  = n_in_plane<dim>;
      // a c with a = F^-T A F^-1, which is A : dS1 but for F^-1
      Lanes transposed[dim][dim], turned[dim][dim], a[m], ac[m], w[dim][dim];
      for (int i = 0; i < dim; ++i)
        for (int j = 0; j < dim; ++j)
          transposed[i][j] = p.inverse[j][i];
      congruence<dim>(transposed, p.A, turned);
      for (unsigned int k = 0; k < m; ++k)
        a[k] = turned[ij[k][0]][ij[k][1]] * (k < dim ? 1. : mandel::sqrt2);
      for (unsigned int k = 0; k < m; ++k)
        {
          ac[k] = a[0] * p.c[0][k];
          for (unsigned int l = 1; l < m; ++l)
            ac[k] += a[l] * p.c[l][k];
        }
      from_mandel<dim>(ac, w);
      Lanes w_inverse[dim][dim], rest[dim][dim], F_rest[dim][dim];
      product_transposed<dim>(w, p.inverse, w_inverse);
      // d(psi + dissipation)/dC = S1/2, unless the material knows better
      Lanes T[dim][dim], own[dim][dim];
      const Lanes(*S_energy)[dim] = p.S1;
      if (p.has_energy_stress)
        {
          from_mandel<dim>(p.energy_stress, T);
          congruence<dim>(p.inverse, T, own);
          S_energy = own;
        }
      // S is S-bar + beta B by now
      for (int i = 0; i < dim; ++i)
        for (int j = 0; j < dim; ++j)
          rest[i][j] =
            S_energy[i][j] - p.S[i][j] - p.slope_correction * p.B[i][j];
      product<dim>(p.F, rest, F_rest);
      for (int i = 0; i < dim; ++i)
        for (int j = 0; j < dim; ++j)
          result[i][j] = p.inverse_nu * (F_rest[i][j] - 0.25 * w_inverse[i][j]);
    }

    template <int dim>
    EMMY_INLINE void
    find_stress(Side<dim> &p)
    {
      for (int i = 0; i < dim; ++i)
        for (int j = 0; j < dim; ++j)
          p.S[i][j] += p.correction * p.B[i][j];
      product<dim>(p.Fm, p.S, p.P);
    }

    template <int dim>
    EMMY_INLINE void
    find_tangent(Side<dim> &p)
    {
      constexpr auto         ij = mandel::pairs<dim>();
      constexpr unsigned int m  = n_in_plane<dim>;
      constexpr double       s  = 1. / mandel::sqrt2;
      Lanes                  M[dim][dim]; // Fm F^-1
      for (int i = 0; i < dim; ++i)
        for (int j = 0; j < dim; ++j)
          M[i][j] = 0.5 * (p.inverse[i][j] + (i == j ? 1. : 0.));
      Lanes Fg[dim][dim], FmB[dim][dim], Fmb[dim][dim], Fb[dim][dim],
        FmbF[dim][dim];
      slope_of_correction<dim>(p, Fg);
      product<dim>(p.Fm, p.B, FmB);
      product<dim>(p.Fm, p.b, Fmb);
      product<dim>(p.F, p.b, Fb);
      product_transposed<dim>(Fmb, p.F, FmbF);
      for (int i = 0; i < dim; ++i)
        for (int J = 0; J < dim; ++J)
          {
            // X -> (M X F^-T)_iJ / 2, and that of c
            Lanes row[m], row_c[m];
            for (unsigned int a = 0; a < m; ++a)
              {
                const unsigned int k = ij[a][0], l = ij[a][1];
                row[a] =
                  a < dim
                    ? 0.5 * (M[i][k] * p.inverse[J][k])
                    : 0.5 * s *
                        (M[i][k] * p.inverse[J][l] + M[i][l] * p.inverse[J][k]);
              }
            for (unsigned int b = 0; b < m; ++b)
              {
                row_c[b] = row[0] * p.c[0][b];
                for (unsigned int a = 1; a < m; ++a)
                  row_c[b] += row[a] * p.c[a][b];
              }
            Lanes C[dim][dim]; // as a symmetric tensor
            from_mandel<dim>(row_c, C);
            const Lanes twice_FmB = 2. * FmB[i][J];
            for (int mm = 0; mm < dim; ++mm)
              {
                const Lanes beta_FmbF = p.slope_correction * FmbF[i][mm],
                            beta_Fb   = p.slope_correction * Fb[mm][J];
                for (int L = 0; L < dim; ++L)
                  {
                    Lanes sum = C[mm][0] * p.inverse[L][0];
                    for (int k = 1; k < dim; ++k)
                      sum += C[mm][k] * p.inverse[L][k];
                    sum += twice_FmB * Fg[mm][L];
                    sum += beta_FmbF * p.b[L][J] + Fmb[i][L] * beta_Fb;
                    if (i == mm)
                      sum += 0.5 * p.S[J][L];
                    p.tangent[i * dim + J][mm * dim + L] = sum;
                  }
              }
          }
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
    EMMY_CLONES void
    tangent(Side<2> &p)
    {
      find_tangent<2>(p);
    }
    EMMY_CLONES void
    tangent(Side<3> &p)
    {
      find_tangent<3>(p);
    }
  } // namespace conserving_kernels
} // namespace emmy
