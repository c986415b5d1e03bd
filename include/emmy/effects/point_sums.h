#ifndef emmy_effects_point_sums_h
#define emmy_effects_point_sums_h

#include <emmy/effects/point_batch.h>
#include <emmy/material/stress_rules.h>
#include <emmy/system/active_grid.h>

#include <vector>

namespace emmy
{
  /**
   * Displacement gradients of a batch, H_ij = sum u_ai dS_a/dx_j, and how many
   * points it has. The same bits on all instruction sets.
   *
   * @param displacement at the local nodes, [dim * node + c], m
   */
  template <int dim>
  void
  displacement_gradients(const PointBatch<dim>     &points,
                         const ActiveGrid<dim>     &active,
                         const std::vector<double> &displacement,
                         StressBatch<dim>          &batch);

  /**
   * Add V0 P grad S of a batch to the forces of the nodes, [dim * node + c], N.
   * The same bits on all instruction sets.
   *
   * @param volumes of all points, m^3
   */
  template <int dim>
  void
  add_forces(const PointBatch<dim>  &points,
             const ActiveGrid<dim>  &active,
             const double           *volumes,
             const StressBatch<dim> &batch,
             std::vector<double>    &force);
} // namespace emmy

#endif
