#ifndef emmy_run_closing_lines_h
#define emmy_run_closing_lines_h

#include <emmy/output/ledger.h>
#include <emmy/step/run_state.h>
#include <emmy/step/step_rule.h>

#include <iosfwd>

namespace emmy
{
  /** A line if the last step went beyond the end time; or nothing. */
  void
  tell_of_overshoot(const TimeParameters &limits,
                    const double          time,
                    std::ostream         &out);

  /**
   * The closing lines of a run: what was conserved, and how well.
   * @param largest_energy of all steps, J
   */
  void
  summarise(std::ostream    &out,
            const Ledger    &ledger,
            const double     largest_energy,
            const Struggles &struggles);
} // namespace emmy

#endif
