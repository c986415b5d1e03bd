#ifndef emmy_run_checkpoint_parameters_h
#define emmy_run_checkpoint_parameters_h

#include <emmy/base/section.h>

namespace emmy
{
  /** Section `Checkpoint`. */
  class CheckpointParameters : public Section
  {
  public:
    unsigned int every_steps   = 0;  ///< 0: not by steps
    double       every_minutes = 0.; ///< of the clock; 0: not by time
    unsigned int keep          = 2;  ///< how many stay

    CheckpointParameters();

    /** Whether checkpoints are written without a signal. */
    bool
    is_on() const
    {
      return every_steps > 0 || every_minutes > 0.;
    }
  };
} // namespace emmy

#endif
