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
    /** What makes up for the energy that the mean stress does not work. */
    template <int dim>
    void
    correct(StressBatch<dim> &batch, Side<dim> &side)
    {
      for (unsigned int lane = 0; lane < n_lanes; ++lane)
        {
          const std::size_t p = side.points.of_lane[lane];
          if (lane > 0 && p == side.points.of_lane[lane - 1])
            {
              side.correction[lane]       = side.correction[lane - 1];
              side.slope_correction[lane] = side.slope_correction[lane - 1];
              side.inverse_nu[lane]       = side.inverse_nu[lane - 1];
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

    MaterialBatch<dim> &end = batch.material;
    const StressArrays  arrays{
      batch.displacement_gradient[0].begin_raw(),
      batch.left_cauchy_green_less_unit_old[0].begin_raw(),
      batch.kirchhoff_stress_old[0].begin_raw(),
      end.kirchhoff_stress[0].begin_raw(),
      end.spatial_tangent[0].begin_raw(),
      end.energy_stress[0].begin_raw(),
      batch.nominal_stress[0].begin_raw(),
      batch.tangent[0].begin_raw()};
    for (unsigned int first = 0; first < batch.n_points; first += n_lanes)
      {
        Side<dim> side(arrays,
                       LanePoints(first, batch.n_points),
                       material.gives_energy_stress());
        conserving_kernels::means(side);
        correct(batch, side);
        conserving_kernels::stress(side);
        if (batch.with_tangent)
          conserving_kernels::tangent(side);
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
