#ifndef emmy_step_domains_of_step_h
#define emmy_step_domains_of_step_h

#include <emmy/base/phases.h>
#include <emmy/transfer/domain_update.h>

#include <string>

namespace emmy
{
  /**
   * Lets the domains of GIMP follow a step; owned by the time integrator.
   */
  template <int dim>
  class DomainsOfStep
  {
  public:
    /** @param update null: domains stay, and nothing is done */
    DomainsOfStep(const DomainUpdate<dim>   *update,
                  const BackgroundGrid<dim> &grid,
                  const FieldLayout         &layout,
                  Phases                    &phases);

    /**
     * Write the domains at t + dt to @p trial. Throws ExcRun on all ranks if
     * one vanishes. Collective.
     *
     * @param displacement of the step at the local nodes, [dim * node + c], m
     * @param step_name    for messages
     * @return a line for the log if many more are cut than ever before
     */
    std::string
    follow(const Stencils<dim>       &stencils,
           const PointArrays<dim>    &points,
           const ActiveGrid<dim>     &active,
           const std::vector<double> &displacement,
           const std::string         &step_name,
           PointArrays<dim>          &trial);

  private:
    const DomainUpdate<dim> *const update;
    const BackgroundGrid<dim>     &grid;
    const FieldLayout             &layout;
    Phases                        &phases;
    std::uint64_t                  most_cut = 0; ///< when last told
  };
} // namespace emmy

#endif
