#include <emmy/material/conserving_kernels.h>
#include <emmy/material/lane_tensors.h>

// vectors stay within these files
#pragma GCC diagnostic ignored "-Wpsabi"

namespace emmy
{
  namespace
  {
    /** F g, with the derivative g of beta. */
    template <int dim>
    EMMY_INLINE void
    slope_of_correction(const Side<dim> &p,
                        const Lanes (&c)[n_mandel<dim>][n_mandel<dim>],
                        Lanes (&result)[dim][dim])
    {
      constexpr auto         ij = mandel::pairs<dim>();
      constexpr unsigned int m  = n_in_plane<dim>;
      // a c with a = F^-T A F^-1, which is A : dS1 but for F^-1
      Lanes transposed[dim][dim], turned[dim][dim], a[m], w[dim][dim];
      Lanes ac[n_mandel<dim>];
      for (int i = 0; i < dim; ++i)
        for (int j = 0; j < dim; ++j)
          transposed[i][j] = p.inverse[j][i];
      congruence<dim>(transposed, p.A, turned);
      for (unsigned int k = 0; k < m; ++k)
        a[k] = turned[ij[k][0]][ij[k][1]] * (k < dim ? 1. : mandel::sqrt2);
      for (unsigned int k = 0; k < m; ++k)
        {
          ac[k] = a[0] * c[0][k];
          for (unsigned int l = 1; l < m; ++l)
            ac[k] += a[l] * c[l][k];
        }
      from_mandel<dim>(ac, w);
      Lanes w_inverse[dim][dim], rest[dim][dim], F_rest[dim][dim];
      product_transposed<dim>(w, p.inverse, w_inverse);
      // d(psi + dissipation)/dC = S1/2, unless the material knows better
      Lanes T[dim][dim], own[dim][dim];
      const Lanes(*S_energy)[dim] = p.S1;
      if (p.has_energy_stress)
        {
          Lanes energy_stress[n_mandel<dim>];
          read_points<n_mandel<dim>>(p.arrays.energy_stress,
                                     p.points,
                                     energy_stress);
          from_mandel<dim>(energy_stress, T);
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
    find_tangent(Side<dim> &p)
    {
      constexpr auto         ij = mandel::pairs<dim>();
      constexpr unsigned int m  = n_in_plane<dim>;
      constexpr double       s  = 1. / mandel::sqrt2;
      Lanes                  c[n_mandel<dim>][n_mandel<dim>];
      read_points<n_mandel<dim> * n_mandel<dim>>(p.arrays.c, p.points, c[0]);
      Lanes M[dim][dim]; // Fm F^-1
      for (int i = 0; i < dim; ++i)
        for (int j = 0; j < dim; ++j)
          M[i][j] = 0.5 * (p.inverse[i][j] + (i == j ? 1. : 0.));
      Lanes Fg[dim][dim], FmB[dim][dim], Fmb[dim][dim], Fb[dim][dim],
        FmbF[dim][dim];
      slope_of_correction<dim>(p, c, Fg);
      product<dim>(p.Fm, p.B, FmB);
      product<dim>(p.Fm, p.b, Fmb);
      product<dim>(p.F, p.b, Fb);
      product_transposed<dim>(Fmb, p.F, FmbF);
      Lanes tangent[dim * dim][dim * dim];
      for (int i = 0; i < dim; ++i)
        for (int J = 0; J < dim; ++J)
          {
            // X -> (M X F^-T)_iJ / 2, and that of c
            Lanes row[m], row_c[n_mandel<dim>];
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
                row_c[b] = row[0] * c[0][b];
                for (unsigned int a = 1; a < m; ++a)
                  row_c[b] += row[a] * c[a][b];
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
                    tangent[i * dim + J][mm * dim + L] = sum;
                  }
              }
          }
      write_points<dim * dim * dim * dim>(tangent[0],
                                          p.points,
                                          p.arrays.tangent);
    }
  } // namespace

  namespace conserving_kernels
  {
    // no templates: those have no clones
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
