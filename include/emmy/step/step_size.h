#ifndef emmy_step_step_size_h
#define emmy_step_step_size_h

#include <emmy/step/time_integrator.h>

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

  /** "Step 3 from t = 0.2 s": where a message comes from. */
  std::string
  step_name(const unsigned int number, const double time);

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
