#include <emmy/base/exceptions.h>
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
    StepSize result{method.step_rule(stencils, points, active), ""};
    double  &dt = result.time_step;
    if (method.maximum_travel > 0.)
      {
        const double longest = time_to_travel(method.maximum_travel,
                                              points,
                                              layout["velocity"],
                                              active);
        if (dt > longest)
          result.note = "shortened from " + brief(dt) + " to " +
                        brief(longest) +
                        " s, and later ones as they need it, so that no " +
                        "particle moves more than Time/Maximum travel = " +
                        brief(method.maximum_travel) +
                        " cells: bodies could pass "
                        "through one another";
        dt = std::min(dt, longest);
      }
    const double time_left = limits.end_time - time;
    if (limits.shorten_last_step && dt > time_left)
      dt = time_left;
    return result;
  }

  std::string
  step_name(const unsigned int number, const double time)
  {
    return "Step " + std::to_string(number) + " from t = " + brief(time) + " s";
  }

  template <int dim>
  DomainsOfStep<dim>::DomainsOfStep(const DomainUpdate<dim>   *update,
                                    const BackgroundGrid<dim> &grid,
                                    const FieldLayout         &layout,
                                    Phases                    &phases)
    : update(update)
    , grid(grid)
    , layout(layout)
    , phases(phases)
  {}

  template <int dim>
  std::string
  DomainsOfStep<dim>::follow(const Stencils<dim>       &stencils,
                             const PointArrays<dim>    &points,
                             const ActiveGrid<dim>     &active,
                             const std::vector<double> &displacement,
                             const std::string         &step_name,
                             PointArrays<dim>          &trial)
  {
    if (!update)
      return {};
    const auto timed = phases.effect(domain_update_effect);
    (*update)(stencils, points, active, displacement, trial);
    throw_together(grid.communicator(),
                   step_name,
                   DomainUpdate<dim>::problem(stencils, layout, grid, trial),
                   "the step was not accepted. Use another Method/Domain "
                   "update (stretch does not vanish under rotation, none "
                   "keeps the size), or more Points per direction.");
    const std::uint64_t n_cut = DomainUpdate<dim>::n_cut(layout, grid, trial);
    if (n_cut < 2 * most_cut || n_cut == 0)
      return {};
    most_cut = n_cut;
    return step_name + ": domains of " + std::to_string(n_cut) +
           " particles are longer than two cells and act as if cut at that "
           "size; more Points per direction or larger cells avoid it";
  }

#define INSTANTIATE(dim)                                            \
  template StepSize choose_step_size<dim>(const StepMethod<dim> &,  \
                                          const TimeParameters &,   \
                                          const FieldLayout &,      \
                                          const Stencils<dim> &,    \
                                          const PointArrays<dim> &, \
                                          const ActiveGrid<dim> &,  \
                                          const double);            \
  template class DomainsOfStep<dim>;
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
