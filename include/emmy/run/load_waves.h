#ifndef emmy_run_load_waves_h
#define emmy_run_load_waves_h

#include <emmy/run/scene.h>

#include <iosfwd>

namespace emmy
{
  /** Cells in a wave, and steps in a period, that show it well. */
  constexpr double cells_per_wave = 10., steps_per_period = 10.;

  /**
   * The bodies through which waves pass so fast that steps of that length, s,
   * do not show even the slowest ones along them, of four times their length:
   * a vector of their numbers.
   */
  template <int dim>
  std::vector<unsigned int>
  bodies_without_waves(const Scene<dim> &scene, const double time_step);

  /** How fast something that is given over time changes. */
  struct FastestChange
  {
    /** Half the period of the fastest swing, or a ramp's time, s; infinite: it
     * is constant. */
    double half_period;
    /** The middle of that, s. */
    double time;
    /** Whether it is too fast for the samples: a jump. */
    bool is_jump;
  };

  /**
   * The fastest swing or ramp of a history from 0 to an end time, s, by that
   * many samples. Swings of less than a twentieth of the range do not count;
   * nor does the part of a swing with which a history begins or ends, if it is
   * no steeper than whole ones. A sine of period P has P/2, a ramp its time.
   */
  FastestChange
  fastest_change(const std::function<double(double)> &history,
                 const double                         end_time,
                 const unsigned int                   n_samples);

  /**
   * For loads, tools, sides and held parts whose histories change: how long the
   * waves are that they send, by the slowest waves of the bodies, in cells and
   * in steps. A note where these are too few. Cost: some ten thousand
   * evaluations of each history.
   */
  template <int dim>
  void
  tell_load_waves(const Scene<dim>           &scene,
                  const SceneParameters<dim> &parameters,
                  const StepReport           &initial,
                  std::ostream               &out);
} // namespace emmy

#endif
