#include <emmy/base/exceptions.h>
#include <emmy/step/domains_of_step.h>

namespace emmy
{
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

  template class DomainsOfStep<2>;
  template class DomainsOfStep<3>;
} // namespace emmy
