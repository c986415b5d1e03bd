#ifndef emmy_effects_time_history_h
#define emmy_effects_time_history_h

#include <functional>
#include <string>
#include <vector>

namespace emmy
{
  /** A factor, force, velocity or displacement that is given over time. */
  struct TimeHistory
  {
    std::string                   name; ///< of what has it, for messages
    std::function<double(double)> at;   ///< of the time, s; may throw ExcRun
  };

  /**
   * The parameters of an effect that has such: `emmy --check` looks how fast
   * they change (run/load_waves.h).
   */
  class GivenOverTime
  {
  public:
    virtual ~GivenOverTime() = default;

    /** All of them; throws ExcParameter for what cannot be read. */
    virtual std::vector<TimeHistory>
    histories() const = 0;
  };
} // namespace emmy

#endif
