#ifndef emmy_effects_step_measures_h
#define emmy_effects_step_measures_h

#include <emmy/effects/step_report.h>
#include <emmy/grid/background_grid.h>
#include <emmy/particles/point_arrays.h>

#include <vector>

namespace emmy
{
  /** Numbers of the ledger that enter no balance. See Effect::measures(). */
  template <int dim>
  class StepMeasures
  {
  public:
    virtual ~StepMeasures() = default;

    /**
     * Once per accepted step, and before the first. Always the same names in
     * the same order. Collective.
     * @param points states at @p time, s
     */
    virtual std::vector<StepMeasure>
    measure(const PointArrays<dim>    &points,
            const double               time,
            const BackgroundGrid<dim> &grid) = 0;
  };
} // namespace emmy

#endif
