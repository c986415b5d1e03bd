#include <emmy/base/text.h>
#include <emmy/step/step_size.h>

#include <algorithm>

namespace emmy
{
  template <int dim>
  StepSize
  choose_step_size(const StepMethod<dim>  &method,
                   const TimeParameters   &limits,
                   const FieldLayout      &layout,
                   const Stencils<dim>    &stencils,
                   const PointArrays<dim> &points,
                   const ActiveGrid<dim>  &active,
                   const double            time)
  {
    return limited_step_size(method.step_rule(stencils, points, active),
                             method,
                             limits,
                             layout,
                             points,
                             time);
  }

  template <int dim>
  StepSize
  limited_step_size(const double            rule,
                    const StepMethod<dim>  &method,
                    const TimeParameters   &limits,
                    const FieldLayout      &layout,
                    const PointArrays<dim> &points,
                    const double            time)
  {
    StepSize result{rule, ""};
    double  &dt = result.time_step;
    if (method.travel_limit)
      {
        const double longest = (*method.travel_limit)(dt,
                                                      points,
                                                      layout["velocity"],
                                                      layout["mass"]);
        if (dt > longest)
          result.note = "shortened from " + brief(dt) + " to " +
                        brief(longest) +
                        " s, and later ones as they need it, so that nothing "
                        "passes through something else: parts that meet, and "
                        "walls, come nearer by at most Time/Maximum travel = " +
                        brief(method.travel_limit->travel()) + " cells a step";
        dt = longest;
      }
    // what round-off leaves for one step more goes with this one
    const double time_left       = limits.end_time - time;
    const bool   leaves_a_sliver = time_left > dt &&
                                 time_left - dt > 1e-12 * limits.end_time &&
                                 time_left - dt < 1e-6 * dt;
    const bool is_over = time_left <= 1e-12 * limits.end_time;
    if (limits.shorten_last_step && !is_over &&
        (dt > time_left || leaves_a_sliver))
      dt = time_left;
    return result;
  }

  std::string
  step_name(const unsigned int number, const double time)
  {
    return "Step " + std::to_string(number) + " from t = " + brief(time) + " s";
  }

  template StepSize
  limited_step_size<2>(const double,
                       const StepMethod<2> &,
                       const TimeParameters &,
                       const FieldLayout &,
                       const PointArrays<2> &,
                       const double);
  template StepSize
  limited_step_size<3>(const double,
                       const StepMethod<3> &,
                       const TimeParameters &,
                       const FieldLayout &,
                       const PointArrays<3> &,
                       const double);
  template StepSize
  choose_step_size<2>(const StepMethod<2> &,
                      const TimeParameters &,
                      const FieldLayout &,
                      const Stencils<2> &,
                      const PointArrays<2> &,
                      const ActiveGrid<2> &,
                      const double);
  template StepSize
  choose_step_size<3>(const StepMethod<3> &,
                      const TimeParameters &,
                      const FieldLayout &,
                      const Stencils<3> &,
                      const PointArrays<3> &,
                      const ActiveGrid<3> &,
                      const double);
} // namespace emmy
