#include <emmy/material/conserving_stress.h>
#include <emmy/math/lanes.h>

#include <algorithm>
#include <limits>
#include <memory>

// vectors stay within this file
#pragma GCC diagnostic ignored "-Wpsabi"

namespace emmy
{
  namespace
  {
    /** |C - C_t|^2 of a step that is none: there squares would underflow. */
    constexpr double smallest_square = 1e-250;

    /**
     * Below this ratio of |C - C_t| to the elastic strain the derivative of
     * the energy correction is left out. It is a difference of stresses
     * divided by the step: round-off would be worse than what is left out,
     * which is as small as the step. The stress has its correction.
     */
    constexpr double smallest_slope = 1e-8;

    /** An energy difference below this part of the energies is round-off. */
    constexpr double energy_round_off =
      4. * std::numeric_limits<double>::epsilon();

    /** Changes of energy that the material was not asked for, or cannot give.
     */
    template <int dim>
    void
    subtract_energies(const bool is_given, StressBatch<dim> &batch)
    {
      MaterialBatch<dim> &material = batch.material;
      if (!material.with_energy_change)
        for (unsigned int p = 0; p < batch.n_points; ++p)
          material.stored_energy_change[p] =
            material.stored_energy[p] - batch.stored_energy_old[p];
      if (batch.is_inelastic && !is_given)
        for (unsigned int p = 0; p < batch.n_points; ++p)
          material.hardening_energy_change[p] =
            material.hardening_energy[p] - batch.hardening_energy_old[p];
    }

    /**
     * 2 (Delta psi + Delta D) - work of a point, J/m^3, and its energies at
     * t + dt: those at t plus their changes.
     *
     * @param work twice what the mean stress works, S : A
     */
    template <int dim>
    double
    missing_energy(StressBatch<dim>  &batch,
                   const unsigned int p,
                   const double       work)
    {
      MaterialBatch<dim> &material = batch.material;
      double              change   = material.stored_energy_change[p];
      double              size     = std::abs(batch.stored_energy_old[p]) +
                    std::abs(material.stored_energy[p]);
      if (batch.is_inelastic)
        {
          change +=
            material.hardening_energy_change[p] + material.dissipation[p];
          size += batch.hardening_energy_old[p] + material.hardening_energy[p];
        }
      double missing = 2. * change - work;
      if (!material.with_energy_change &&
          std::abs(missing) <= energy_round_off * size)
        {
          material.stored_energy_change[p] -= 0.5 * missing;
          missing = 0.;
        }
      material.stored_energy[p] =
        batch.stored_energy_old[p] + material.stored_energy_change[p];
      if (batch.is_inelastic)
        material.hardening_energy[p] =
          batch.hardening_energy_old[p] + material.hardening_energy_change[p];
      return missing;
    }

    /** Points side by side: what the formulas read, and what they make. */
    template <int dim>
    struct Side
    {
      static constexpr unsigned int m = n_in_plane<dim>;

      // in; symmetric tensors as in mandel, in the plane
      Lanes H[dim][dim], b_old[m], tau_old[m], tau[m], c[m][m];
      /** MaterialBatch::energy_stress, where the material gives it. */
      Lanes energy_stress[m];
      bool  has_energy_stress = false;

      // from find_means(); tensors as they are
      Lanes F[dim][dim], inverse[dim][dim], Fm[dim][dim], b[dim][dim];
      Lanes A[dim][dim], B[dim][dim], S1[dim][dim], S[dim][dim];
      Lanes work; ///< S-bar : A
      Lanes nu;   ///< A : B

      // in: beta; and for its derivative, zero where that is left out
      Lanes correction, slope_correction, inverse_nu;

      // from find_stress() and find_tangent()
      Lanes P[dim][dim], tangent[dim * dim][dim * dim];
    };

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

  namespace
  {
    /** Points [first, first + n_lanes); behind the last one it is repeated. */
    template <int dim>
    void
    put_side_by_side(const StressBatch<dim> &batch,
                     const unsigned int      first,
                     Side<dim>              &side)
    {
      constexpr unsigned int m = n_in_plane<dim>;
      for (unsigned int lane = 0; lane < n_lanes; ++lane)
        {
          const unsigned int p = std::min(first + lane, batch.n_points - 1);
          for (int i = 0; i < dim; ++i)
            for (int j = 0; j < dim; ++j)
              side.H[i][j][lane] = batch.displacement_gradient[p][i][j];
          for (unsigned int a = 0; a < m; ++a)
            {
              side.b_old[a][lane] = batch.left_cauchy_green_less_unit_old[p][a];
              side.tau_old[a][lane] = batch.kirchhoff_stress_old[p][a];
              side.tau[a][lane]     = batch.material.kirchhoff_stress[p][a];
            }
          if (batch.with_tangent)
            for (unsigned int a = 0; a < m; ++a)
              for (unsigned int b = 0; b < m; ++b)
                side.c[a][b][lane] = batch.material.spatial_tangent[p][a][b];
          if (side.has_energy_stress)
            for (unsigned int a = 0; a < m; ++a)
              side.energy_stress[a][lane] = batch.material.energy_stress[p][a];
        }
    }

    /** What makes up for the energy that the mean stress does not work. */
    template <int dim>
    void
    correct(const unsigned int first, StressBatch<dim> &batch, Side<dim> &side)
    {
      for (unsigned int lane = 0; lane < n_lanes; ++lane)
        {
          const unsigned int p = first + lane;
          if (p >= batch.n_points)
            {
              side.correction[lane]   = side.slope_correction[lane] =
                side.inverse_nu[lane] = 0.;
              continue;
            }
          const double nu         = side.nu[lane];
          const double missing    = missing_energy(batch, p, side.work[lane]);
          const double correction = nu > smallest_square ? missing / nu : 0.;
          const bool   has_slope =
            nu > smallest_square &&
            nu > smallest_slope * smallest_slope *
                   batch.material.step.left_cauchy_green_less_unit_old[p]
                     .norm_square();
          side.correction[lane]       = correction;
          side.slope_correction[lane] = has_slope ? correction : 0.;
          side.inverse_nu[lane]       = has_slope ? 1. / nu : 0.;
        }
    }

    template <int dim>
    void
    take_apart(const Side<dim>   &side,
               const unsigned int first,
               StressBatch<dim>  &batch)
    {
      const unsigned int n = std::min(n_lanes, batch.n_points - first);
      for (unsigned int lane = 0; lane < n; ++lane)
        {
          for (int i = 0; i < dim; ++i)
            for (int j = 0; j < dim; ++j)
              batch.nominal_stress[first + lane][i][j] = side.P[i][j][lane];
          if (batch.with_tangent)
            for (int r = 0; r < dim * dim; ++r)
              for (int c = 0; c < dim * dim; ++c)
                batch.tangent[first + lane][r][c] = side.tangent[r][c][lane];
        }
    }
  } // namespace

  template <int dim>
  unsigned int
  conserving_stress(const Material<dim> &material, StressBatch<dim> &batch)
  {
    const unsigned int inverted =
      update_states(material, batch, /*with_energy_change=*/true);
    if (inverted < batch.n_points)
      return inverted;
    subtract_energies(material.gives_energy_change(), batch);

    Side<dim> side;
    side.has_energy_stress =
      batch.with_tangent && material.gives_energy_stress();
    for (unsigned int first = 0; first < batch.n_points; first += n_lanes)
      {
        put_side_by_side(batch, first, side);
        conserving_kernels::means(side);
        correct(first, batch, side);
        conserving_kernels::stress(side);
        if (batch.with_tangent)
          conserving_kernels::tangent(side);
        take_apart(side, first, batch);
      }
    return batch.n_points;
  }

  template unsigned int
  conserving_stress<2>(const Material<2> &, StressBatch<2> &);
  template unsigned int
  conserving_stress<3>(const Material<3> &, StressBatch<3> &);
} // namespace emmy
