#ifndef emmy_step_failure_h
#define emmy_step_failure_h

#include <emmy/step/time_integrator.h>

namespace emmy
{
  /** A step that found no solution at its smallest size. */
  template <int dim>
  struct FailedStep
  {
    const Ground<dim>    &ground;       ///< grid and places of the step
    const GridStart<dim> &start;        ///< at its start
    StepEquation<dim>    &equation;     ///< that could not be solved
    const Vector         &displacement; ///< where Newton ended, m
    bool                  leaves_grid;  ///< a particle would
  };

  /** Which remedies a scene with implicit steps has, or has no use for. */
  template <int dim>
  RemediesInUse
  remedies_in_use(const StepSetting<dim> &setting);

  /** What helps most often where Newton struggles, if it is not used yet. */
  template <int dim>
  std::string
  usual_remedy(const StepSetting<dim> &setting);

  /** What is wrong with a matrix, in words; nothing where it is large. */
  template <int dim>
  CutVerdict
  verdict_on(const Matrix           &matrix,
             const std::string      &name,
             const Ground<dim>      &ground,
             const ActiveGrid<dim>  &active,
             const StepSetting<dim> &setting);

  /**
   * Say why a step fails. Throws ExcRun on all ranks. Collective.
   * @param record of all tries; receives where the matrix is weakest
   */
  template <int dim>
  void
  give_up(const FailedStep<dim>  &step,
          const StepSetting<dim> &setting,
          const std::string      &where,
          FailureRecord          &record);
} // namespace emmy

#endif
