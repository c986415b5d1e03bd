#ifndef emmy_step_start_balance_h
#define emmy_step_start_balance_h

#include <emmy/step/time_integrator.h>

namespace emmy
{
  /**
   * How far the stress that particles have is from balance with the loads of a
   * time: the norm of loads less sum V0 tau grad S on free unknowns, over the
   * larger norm of both on all. Tools, contact and viscous sides are no loads.
   * Collective. Cost: that of a force without tangent.
   */
  template <int dim>
  double
  start_imbalance(const Stencils<dim>    &stencils,
                  const PointArrays<dim> &points,
                  const ActiveGrid<dim>  &active,
                  const StepSetting<dim> &setting,
                  const double            time);
} // namespace emmy

#endif
