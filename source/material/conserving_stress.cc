#include <emmy/material/conserving_kernels.h>
#include <emmy/material/conserving_stress.h>

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
  } // namespace

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
        change += material.hardening_energy_change[p] + material.dissipation[p];
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

#define INSTANTIATE(dim)                                                  \
  template void   subtract_energies<dim>(const bool, StressBatch<dim> &); \
  template double missing_energy<dim>(StressBatch<dim> &,                 \
                                      const unsigned int,                 \
                                      const double);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE

  template unsigned int
  conserving_stress<2>(const Material<2> &, StressBatch<2> &);
  template unsigned int
  conserving_stress<3>(const Material<3> &, StressBatch<3> &);
} // namespace emmy
