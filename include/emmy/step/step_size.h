#ifndef emmy_step_step_size_h
#define emmy_step_step_size_h

#include <emmy/step/step_method.h>

namespace emmy
{
  /** The size of a step, and what shortened it if that is worth a line. */
  struct StepSize
  {
    double      time_step; ///< s
    std::string note;      ///< empty: nothing
  };

  /**
   * The step that the method's rule gives, not beyond its limits. Collective.
   * @param time at the start of the step, s
   */
  template <int dim>
  StepSize
  choose_step_size(const StepMethod<dim>  &method,
                   const TimeParameters   &limits,
                   const FieldLayout      &layout,
                   const Stencils<dim>    &stencils,
                   const PointArrays<dim> &points,
                   const ActiveGrid<dim>  &active,
                   const double            time);

  /**
   * The same of a size that the rule has given.
   * @param points in any order
   */
  template <int dim>
  StepSize
  limited_step_size(const double            rule,
                    const StepMethod<dim>  &method,
                    const TimeParameters   &limits,
                    const FieldLayout      &layout,
                    const PointArrays<dim> &points,
                    const double            time);

  /** "Step 3 from t = 0.2 s": where a message comes from. */
  std::string
  step_name(const unsigned int number, const double time);
} // namespace emmy

#endif
