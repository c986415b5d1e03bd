#include <emmy/output/progress.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ostream>

namespace emmy
{
  namespace
  {
    /** Steps that a screen without a cursor is told about in any case. */
    constexpr unsigned int n_first_steps = 3;

    // Words to a terminal (ECMA-48). A line that is wider than the terminal
    // must be cut: wrapped, it could not be redrawn in place.
    constexpr const char *wipe    = "\r\033[K";
    constexpr const char *no_wrap = "\033[?7l";
    constexpr const char *wrap    = "\033[?7h";


    /** Seconds as 0:07, 12:30 or 1:02:03. */
    std::string
    clock_time(const double seconds)
    {
      const auto total  = static_cast<long long>(std::min(seconds, 1e9) + 0.5);
      const int  s      = static_cast<int>(total % 60);
      const int  m      = static_cast<int>(total / 60 % 60);
      const long long h = total / 3600;
      char            text[40];
      if (h > 0)
        std::snprintf(text, sizeof(text), "%lld:%02d:%02d", h, m, s);
      else
        std::snprintf(text, sizeof(text), "%d:%02d", m, s);
      return text;
    }
  } // namespace


  Progress::Progress(std::ostream      &screen,
                     const bool         screen_is_terminal,
                     std::ostream      &log,
                     const double       end_time,
                     const unsigned int maximum_steps,
                     const double       patience)
    : screen(screen)
    , screen_is_terminal(screen_is_terminal)
    , log(log)
    , end_time(end_time)
    , maximum_steps(maximum_steps)
    , patience(patience)
    , start(Clock::now())
    , last_shown(start)
    , last_step(start)
  {}


  Progress::~Progress()
  {
    finish();
  }


  void
  Progress::step(const unsigned int step,
                 const double       time,
                 const double       dt,
                 const unsigned int newton_iterations,
                 const double       relative_balance)
  {
    // A continued run does not start at zero; its pace is that of the part
    // that this process computes.
    if (steps_seen == 0)
      start_fraction = shown_fraction =
        fraction(std::max(step, 1u) - 1, time - dt);
    ++steps_seen;
    last_step = Clock::now();

    last_line = line(step, time, dt, newton_iterations, relative_balance);
    last_line_is_shown = false;
    log << last_line << std::endl;

    const double done = fraction(step, time);
    const double quiet =
      std::chrono::duration<double>(Clock::now() - last_shown).count();
    if (screen_is_terminal ? quiet >= 0.1 || steps_seen == 1
                           : steps_seen <= n_first_steps || quiet >= 60. ||
                               std::floor(20. * done + 1e-9) >
                                 std::floor(20. * shown_fraction + 1e-9))
      {
        shown_fraction = done;
        show_on_screen();
      }
  }


  void
  Progress::working(const std::string &news)
  {
    const auto   now = Clock::now();
    const double seconds =
                   std::chrono::duration<double>(now - last_step).count(),
                 quiet =
                   std::chrono::duration<double>(now - last_shown).count();
    // a terminal is redrawn; other screens keep each line
    if (seconds < patience ||
        quiet < (screen_is_terminal ? 0.2 : 2.) * patience)
      return;
    const std::string text = news + " (" + clock_time(seconds) + ")";
    if (screen_is_terminal)
      screen << wipe << no_wrap << text << wrap;
    else
      screen << text << "\n";
    screen << std::flush;
    last_shown = now;
  }


  void
  Progress::note(const std::string &text)
  {
    log << text << std::endl;
    if (screen_is_terminal)
      screen << wipe;
    screen << text << std::endl;
    if (screen_is_terminal && !last_line.empty())
      show_on_screen();
  }


  void
  Progress::record(const std::string &text)
  {
    log << text << std::endl;
  }


  void
  Progress::finish()
  {
    if (last_line.empty())
      return;
    if (screen_is_terminal)
      screen << wipe << last_line << "\n"; // all of it, if need be wrapped
    else if (!last_line_is_shown)
      screen << last_line << "\n";
    screen << std::flush;
    last_line.clear();
    last_line_is_shown = true;
  }


  std::string
  Progress::line(const unsigned int step,
                 const double       time,
                 const double       dt,
                 const unsigned int newton_iterations,
                 const double       relative_balance) const
  {
    const double done     = fraction(step, time);
    const double computed = done - start_fraction;
    const double seconds =
      std::chrono::duration<double>(Clock::now() - start).count();

    char text[240];
    std::snprintf(text,
                  sizeof(text),
                  "step %u  t %.5g s  dt %.3g s  Newton %u  balance %.1e"
                  "  %d %%  left %s",
                  step,
                  time,
                  dt,
                  newton_iterations,
                  relative_balance,
                  static_cast<int>(100. * done + 1e-9),
                  computed > 0.
                    ? clock_time(seconds * (1. - done) / computed).c_str()
                    : "?");
    return text;
  }


  double
  Progress::fraction(const unsigned int step, const double time) const
  {
    double done = end_time > 0. ? time / end_time : 0.;
    if (maximum_steps > 0)
      done = std::max(done, static_cast<double>(step) / maximum_steps);
    return std::clamp(done, 0., 1.);
  }


  void
  Progress::show_on_screen()
  {
    if (screen_is_terminal)
      screen << wipe << no_wrap << last_line << wrap;
    else
      screen << last_line << "\n";
    screen << std::flush;
    last_shown         = Clock::now();
    last_line_is_shown = true;
  }
} // namespace emmy
