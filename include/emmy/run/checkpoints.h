#ifndef emmy_run_checkpoints_h
#define emmy_run_checkpoints_h

#include <emmy/output/ledger.h>
#include <emmy/run/interrupt.h>
#include <emmy/run/saved_run.h>

#include <chrono>
#include <string>

namespace emmy
{
  /**
   * Writes checkpoints of a run when they are due: by steps, by the clock, at
   * a signal, and at the end. Owned by the run loop. What goes wrong while
   * one is written ends no run: the one before is kept. Cost: a reduction
   * over the ranks in each step, and what save() costs.
   */
  template <int dim>
  class Checkpoints
  {
  public:
    /**
     * Borrows all.
     * @param directory of the results
     * @param signals   null: none ends the run
     */
    Checkpoints(Scene<dim>                 &scene,
                const SceneParameters<dim> &parameters,
                const Ledger               &ledger,
                const std::string          &directory,
                const SignalWatch          *signals);

    /**
     * After an accepted step, when all else of it is written. Collective.
     * @return a line for the log and the screen if one could not be written
     */
    std::string
    after_step();

    /** The last state, if checkpoints are on and it is not written. */
    std::string
    at_end();

    /** Whether a signal ended the run; the same on all ranks. */
    bool
    is_interrupted() const
    {
      return signal != 0;
    }

    /** Whether there is a checkpoint of this run. */
    bool
    is_there() const
    {
      return is_written;
    }

    /** What the run says then, and how it goes on. */
    std::string
    farewell() const;

  private:
    std::string
    write();

    Scene<dim>                           &scene;
    const CheckpointParameters           &wanted;
    const std::string                     parameters;
    const Ledger                         &ledger;
    const std::string                     directory;
    const CheckpointFolder                folder;
    const SignalWatch *const              signals;
    std::chrono::steady_clock::time_point last_time;
    unsigned int                          last_step; ///< that was written
    bool                                  is_written = false;
    int                                   signal     = 0;
  };

  /** All parameters of a scene, as a parameter file. */
  template <int dim>
  std::string
  text_of(const SceneParameters<dim> &parameters);
} // namespace emmy

#endif
