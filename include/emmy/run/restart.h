#ifndef emmy_run_restart_h
#define emmy_run_restart_h

#include <emmy/base/parameter_file.h>
#include <emmy/output/ledger.h>
#include <emmy/output/run_directory.h>
#include <emmy/run/saved_run.h>

#include <iosfwd>
#include <string>
#include <vector>

namespace emmy
{
  /**
   * The parameters with which a run goes on: those of its checkpoint, or of
   * another file, with results in the folder of the run. After a failure the
   * failed step is the last one.
   *
   * @param filename    empty: those of the checkpoint
   * @param assignments "Section/Name=value", which override both
   */
  ParameterFile
  parameters_to_go_on(const SavedRun                 &saved,
                      const std::string              &filename,
                      const std::vector<std::string> &assignments);

  /**
   * What differs from the parameters of the checkpoint, one line each. Throws
   * ExcRun with all differences that contradict the state: the particles, the
   * method and the columns of the ledger are those of the run. Of a failed
   * step everything may differ that leaves fields and columns as they are.
   *
   * @param parameters with which the run shall go on, as a parameter file
   * @param new_loads  loads and the motion of walls may differ too
   */
  std::vector<std::string>
  changes_to_go_on(const SavedRun    &saved,
                   const std::string &parameters,
                   const bool         new_loads);

  /**
   * Let a scene go on from a checkpoint: its state, its ledger, of which later
   * rows are cut off. Damaged checkpoints after it are set aside. Throws
   * ExcRun on all ranks; then no file has changed. Collective.
   *
   * @pre the scene has told its initial_report(), the ledger is made of it
   */
  template <int dim>
  void
  go_on(const SavedRun     &saved,
        const RunDirectory &directory,
        Scene<dim>         &scene,
        Ledger             &ledger);

  /** Where the run goes on, on how many ranks, and what is new. */
  void
  describe_restart(const SavedRun                 &saved,
                   const std::vector<std::string> &changes,
                   const unsigned int              n_ranks,
                   std::ostream                   &out);
} // namespace emmy

#endif
