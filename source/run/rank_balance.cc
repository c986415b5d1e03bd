#include <emmy/base/text.h>
#include <emmy/run/rank_balance.h>
#include <emmy/run/scene.h>
#include <emmy/step/step_size.h>
#include <emmy/transfer/particle_sort.h>
#include <emmy/transfer/rank_load.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <ostream>

namespace emmy
{
  namespace
  {
    /** What handing over costs at most, in steps: see doc/scaling.md. */
    double
    cost_in_steps(const TimeParameters &limits)
    {
      return limits.integrator == "explicit" ? 30. : 2.;
    }

    /** Computed by each rank alone, without waiting for others. */
    const std::string timed_effects = material_effect("");
  } // namespace

  RankParameters::RankParameters()
    : Section("Ranks")
  {
    add_parameter("Rebalance above",
                  rebalance_above,
                  "Cells and their particles are handed to other ranks before "
                  "a step, if the busiest rank has more than so many times "
                  "the mean work, and the steps that are left win more than "
                  "that costs. Work is counted in particles and cells. 0: "
                  "before each step, for tests. Not used on one rank.",
                  prm,
                  dealii::Patterns::Double(0.));
  }

  template <int dim>
  RankBalance<dim>::RankBalance(const RankParameters &parameters,
                                const TimeParameters &limits,
                                BackgroundGrid<dim>  &grid,
                                Phases               &phases)
    : bound(parameters.rebalance_above)
    , limits(limits)
    , grid(grid)
    , phases(phases)
    , is_alone(dealii::Utilities::MPI::n_mpi_processes(grid.communicator()) ==
               1)
  {}

  template <int dim>
  std::string
  RankBalance<dim>::before_step(RunState<dim> &state)
  {
    if (is_alone)
      return {};
    const auto timed = phases.scope("balance of ranks");
    // a window that moved was distributed too
    if (distributed.lock() != grid.nodes())
      {
        best_load   = load_when_covered(grid).work;
        distributed = grid.nodes();
      }
    const double load = load_of_ranks(grid, state.particles).work;
    largest           = std::max(largest, load);
    if (bound > 0. &&
        !(load > bound * best_load && pays(state, load, best_load)))
      return {};

    const double seconds = load_in_seconds();
    distribute_anew(grid, state.particles);
    const double after = load_of_ranks(grid, state.particles).work;
    std::string  line  = step_name(state.step + 1, state.time) +
                       ": cells were handed to other ranks: the busiest had " +
                       brief(load) + " of the mean work, and has " +
                       brief(after) + "; in seconds of stresses it took " +
                       brief(seconds) + " of the mean since " +
                       (times == 0 ? std::string("the start")
                                   : "step " + std::to_string(last_step + 1));
    if (times == 0)
      {
        first_load    = load;
        first_seconds = seconds;
      }
    ++times;
    last_step      = state.step;
    seconds_before = phases.seconds_here(timed_effects);
    return line;
  }

  template <int dim>
  bool
  RankBalance<dim>::pays(const RunState<dim> &state,
                         const double         load,
                         const double         best) const
  {
    if (state.step == 0)
      return false; // just distributed, and there is no step to judge by
    // as long as those so far; what the clock says would differ in each run
    double n_left = (limits.end_time - state.time) / (state.time / state.step);
    if (limits.maximum_steps > 0)
      n_left = std::min(n_left, double(limits.maximum_steps) - state.step);
    return (1. - best / load) * n_left > cost_in_steps(limits);
  }

  template <int dim>
  double
  RankBalance<dim>::load_in_seconds() const
  {
    const auto seconds = dealii::Utilities::MPI::min_max_avg(
      phases.seconds_here(timed_effects) - seconds_before, grid.communicator());
    return seconds.avg > 0. ? seconds.max / seconds.avg : 1.;
  }

  template <int dim>
  void
  RankBalance<dim>::print(std::ostream &out, const RunState<dim> &state) const
  {
    if (is_alone)
      return;
    const RankLoad load    = load_of_ranks(grid, state.particles);
    const double   seconds = load_in_seconds();
    out << "balance of ranks: the busiest has " << brief(load.work)
        << " of the mean work, " << brief(load.particles)
        << " of the mean particles; at most it had " << brief(largest)
        << " of the mean work. In seconds of stresses it took "
        << brief(seconds) << " of the mean";
    if (times > 0)
      out << " since step " << last_step + 1 << ", before which cells were "
          << "handed over for the last of " << times << " times; before the "
          << "first time " << brief(first_seconds) << ", and "
          << brief(first_load) << " of the mean work";
    out << '\n';
  }

  template class RankBalance<2>;
  template class RankBalance<3>;
} // namespace emmy
