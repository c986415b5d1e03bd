#ifndef emmy_run_run_h
#define emmy_run_run_h

#include <emmy/base/parameter_file.h>

#include <deal.II/base/mpi.h>

namespace emmy
{
  struct SavedRun;
  class SignalWatch;

  /** What the command line asks for besides a parameter file. */
  struct RunOptions
  {
    bool only_check  = false; ///< describe the scene, run nothing
    bool with_absent = false; ///< and what the absent effects would cost
    bool with_step   = false; ///< of a check: make a step, and time it
    bool overwrite   = false; ///< replace results of an earlier run
    bool is_quiet    = false; ///< nothing on the screen; run.log as ever
    /** Borrowed: has a checkpoint written, and ends the run. Null: nothing. */
    const SignalWatch *signals = nullptr;
    /** Borrowed: where the run goes on; null: it begins. */
    const SavedRun *restart   = nullptr;
    bool            new_loads = false; ///< loads may be others then
  };

  /** How a run ended that did not fail. */
  enum class RunEnd
  {
    complete,
    interrupted, ///< by a signal; it can go on
    refuted      ///< of `emmy verify`: a claim does not hold
  };

  /**
   * Run the scene of a parameter file, or just describe it. Collective.
   * Throws ExcParameter or ExcRun on all ranks; when a run stops on the way,
   * all rows, frames and pictures up to the last accepted step are there.
   */
  template <int dim>
  RunEnd
  run(const ParameterFile &file,
      const RunOptions    &options,
      const MPI_Comm       communicator);
} // namespace emmy

#endif
