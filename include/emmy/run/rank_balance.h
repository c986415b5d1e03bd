#ifndef emmy_run_rank_balance_h
#define emmy_run_rank_balance_h

#include <emmy/base/phases.h>
#include <emmy/base/section.h>
#include <emmy/grid/background_grid.h>
#include <emmy/step/run_state.h>
#include <emmy/step/step_rule.h>

#include <iosfwd>
#include <memory>
#include <string>

namespace emmy
{
  /** Section `Ranks`. */
  class RankParameters : public Section
  {
  public:
    double rebalance_above = 1.2; ///< 0: before each step

    RankParameters();
  };

  /**
   * Hands cells and their particles to other ranks before a step, when the
   * busiest rank has too much of the work. Owned by the scene; on one rank it
   * does nothing.
   *
   * Work is counted (grid/cell_work.h), not timed, so that a run that is
   * repeated, or restarted on as many ranks, decides the same and has the same
   * ledger to the last bit; seconds, which differ each time, are only
   * reported. Nothing is remembered that decides: the load that the last
   * distribution left follows from BackgroundGrid::covered().
   *
   * Cost: see load_of_ranks() each step, distribute_anew() where it hands over.
   */
  template <int dim>
  class RankBalance
  {
  public:
    /** Borrows all but the parameters. */
    RankBalance(const RankParameters &parameters,
                const TimeParameters &limits,
                BackgroundGrid<dim>  &grid,
                Phases               &phases);

    /**
     * Hand over if it is due and pays. Collective.
     * @return a line for the log, or nothing
     */
    std::string
    before_step(RunState<dim> &state);

    /** How often it handed over since the program began. */
    unsigned int
    n_times() const
    {
      return times;
    }

    /** What it did and brought, in a line; on one rank nothing. Collective. */
    void
    print(std::ostream &out, const RunState<dim> &state) const;

  private:
    /** Whether the steps that are left win more than it costs. */
    bool
    pays(const RunState<dim> &state,
         const double         load,
         const double         best) const;
    /** Of the busiest rank over the mean since handing over. Collective. */
    double
    load_in_seconds() const;

    const double          bound;
    const TimeParameters &limits;
    BackgroundGrid<dim>  &grid;
    Phases               &phases;
    const bool            is_alone;
    /** When the best load was found, which cells were distributed then. */
    std::weak_ptr<const dealii::Utilities::MPI::Partitioner> distributed;
    double                                                   best_load = 1.;
    unsigned int                                             times     = 0;
    double       seconds_before = 0.; ///< of this rank, when it handed over
    double       first_load     = 0.; ///< before it handed over first
    double       first_seconds  = 0.;
    double       largest        = 1.; ///< load of all steps
    unsigned int last_step      = 0;
  };
} // namespace emmy

#endif
