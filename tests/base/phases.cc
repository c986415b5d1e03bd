// The table of phases: what it counts, what it costs, and how ranks that do
// not know the same phases are combined. Runs on any number of ranks.

#include <emmy/base/phases.h>

#include <algorithm>
#include <chrono>
#include <sstream>

#include "../check.h"

using namespace emmy;
using test::check;

namespace
{
  const MPI_Comm world = MPI_COMM_WORLD;

  unsigned int
  rank()
  {
    return dealii::Utilities::MPI::this_mpi_process(world);
  }


  std::size_t
  count(const std::string &text, const std::string &part)
  {
    std::size_t n = 0;
    for (auto at = text.find(part); at != std::string::npos;
         at      = text.find(part, at + 1))
      ++n;
    return n;
  }


  void
  test_phases()
  {
    Phases phases(world);
    {
      const auto timed = phases.scope("first");
      phases.add_count("first", 10);
    }
    if (rank() == 0)
      const auto timed = phases.scope("only on rank 0");

    double least = 1.;
    for (unsigned int attempt = 0; attempt < 10; ++attempt)
      {
        constexpr unsigned int n     = 10000;
        const auto             start = std::chrono::steady_clock::now();
        for (unsigned int i = 0; i < n; ++i)
          const auto timed = phases.scope("a phase that costs nothing");
        least = std::min(least,
                         std::chrono::duration<double>(
                           std::chrono::steady_clock::now() - start)
                             .count() /
                           n);
      }
    check(least < 1e-6, "timing a phase costs less than a microsecond");

    const auto rows = phases.rows();
    check(rows.size() == 3 && rows[0].name == "first" &&
            rows[1].name == "only on rank 0" && rows[1].calls == 1. &&
            rows[2].calls == 100000.,
          "phases in the order of their first use");
    check(rows[0].points ==
            10. * dealii::Utilities::MPI::n_mpi_processes(world),
          "points are added over the ranks");

    // an effect that takes part of two phases, and a part of that
    for (const char *phase : {"first", "second"})
      {
        const auto timed  = phases.scope(phase);
        const auto effect = phases.effect("effect");
        const auto part   = phases.effect("part");
        phases.add_iterations(phase, 2);
      }
    {
      const auto outside = phases.effect("outside of phases");
    }
    phases.add_effect_count("part", 3);
    phases.add_iterations("second", 7);
    const auto effects = phases.effects();
    check(effects.size() == 3 && effects[0].name == "effect" &&
            effects[0].within.empty() && effects[0].calls == 2.,
          "an effect is booked over all phases");
    check(effects[1].name == "part" && effects[1].within == "effect" &&
            effects[1].seconds <= effects[0].seconds &&
            effects[1].points ==
              3. * dealii::Utilities::MPI::n_mpi_processes(world),
          "a part of an effect knows whose");
    check(effects[1].iterations == 4. && effects[0].iterations == 0. &&
            effects[2].iterations == 0.,
          "iterations are those of the innermost effect");
    check(effects[2].within.empty(), "the next effect is no part of the last");
    {
      const auto nowhere = effect_scope(nullptr, "effect");
    }
    check(phases.effects()[0].calls == 2., "without a table nothing is timed");

    const auto   all   = phases.rows();
    const double total = phases.total_seconds();
    check(all.size() == 4 && all[0].iterations == 2. && all[3].iterations == 9.,
          "iterations of linear solvers, those of effects included");
    double sum = Phases::seconds_outside(all, total);
    for (const auto &row : all)
      sum += row.mean_seconds;
    test::check_close(sum, total, 1e-12, "the phases add up to the wall time");

    std::ostringstream table;
    phases.print(table, all, total);
    check(count(table.str(), "total wall time") == 1 &&
            count(table.str(), "\n") == 9,
          "the table has a line for each phase");
  }
} // namespace


int
main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  test_phases();
  return test::report();
}
