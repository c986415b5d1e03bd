#ifndef emmy_output_progress_h
#define emmy_output_progress_h

#include <chrono>
#include <iosfwd>
#include <string>

namespace emmy
{
  /**
   * Tells how far a run has come, one line per step:
   * @verbatim
   * step 45  t 2.5785 s  dt 0.0573 s  Newton 3  balance 1.2e-15  32 %  left
   * 0:07
   * @endverbatim
   *
   * The log gets every line. On a terminal the line is redrawn in place, at
   * most ten times a second. Other screens (a file, a batch system) get the
   * first steps, then a line whenever another 5 % of the run or a minute has
   * passed, and the last one.
   *
   * Within a step that takes long the screen is told what Newton does.
   *
   * Used on one rank; give the others streams that discard. The time left is
   * what remains of the simulated time, or of the steps if those end sooner,
   * at the average pace so far.
   */
  class Progress
  {
  public:
    /**
     * @param screen,log    borrowed; must outlive this object
     * @param end_time      of the run, s
     * @param maximum_steps the run stops after so many; 0: no limit
     * @param patience      how long a step may be silent, s
     */
    Progress(std::ostream      &screen,
             const bool         screen_is_terminal,
             std::ostream      &log,
             const double       end_time,
             const unsigned int maximum_steps,
             const double       patience = 5.);

    /** Ends with finish(). */
    ~Progress();

    Progress(const Progress &) = delete;
    Progress &
    operator=(const Progress &) = delete;

    /**
     * A step was accepted.
     * @param step              its number
     * @param time              at its end, s
     * @param dt                its length, s
     * @param newton_iterations of this step
     * @param relative_balance  balance error / initial energy, dimensionless
     */
    void
    step(const unsigned int step,
         const double       time,
         const double       dt,
         const unsigned int newton_iterations,
         const double       relative_balance);

    /**
     * News from within a step. The screen gets them if nothing was shown for
     * longer than the patience; a terminal in place, until the step's line.
     */
    void
    working(const std::string &news);

    /** Print lines of their own to screen and log. */
    void
    note(const std::string &text);

    /** Print a line to the log alone. */
    void
    record(const std::string &text);

    /** Show the last step if it was skipped, and leave the cursor below. */
    void
    finish();

  private:
    using Clock = std::chrono::steady_clock;

    std::string
    line(const unsigned int step,
         const double       time,
         const double       dt,
         const unsigned int newton_iterations,
         const double       relative_balance) const;

    /** Done part of the run, between 0 and 1. */
    double
    fraction(const unsigned int step, const double time) const;

    void
    show_on_screen();

    std::ostream      &screen;
    const bool         screen_is_terminal;
    std::ostream      &log;
    const double       end_time;
    const unsigned int maximum_steps;
    const double       patience;

    const Clock::time_point start;
    Clock::time_point       last_shown, last_step;
    double                  start_fraction = 0.;
    double                  shown_fraction = 0.;
    unsigned int            steps_seen     = 0;
    std::string             last_line; ///< empty before steps, after finish()
    bool                    last_line_is_shown = true;
  };
} // namespace emmy

#endif
