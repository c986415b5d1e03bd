#ifndef emmy_run_saved_run_h
#define emmy_run_saved_run_h

#include <emmy/output/checkpoint_folder.h>
#include <emmy/run/scene.h>
#include <emmy/transfer/particle_parcel.h>

#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace emmy
{
  /** What a checkpoint says before its scene is known. */
  struct SavedRun
  {
    std::string directory;  ///< of the results
    std::string version;    ///< of the emmy that wrote it
    std::string parameters; ///< all of them, as a parameter file
    /** Of the run that was saved. */
    unsigned int dimension = 0, step = 0, n_ranks = 0;
    double       time       = 0.;    ///< s
    bool         is_failure = false; ///< the step after it could not be made
    /** Fields of the particles in their order: name, number of components. */
    std::vector<std::pair<std::string, unsigned int>> fields;

    std::string state; ///< for recall(): RunState without particles
    /** Particles, and what effects remember, of some ranks of then. */
    std::vector<std::string> parts;
    std::string              path; ///< of the checkpoint
    /** Why newer ones are not used, one line each. */
    std::vector<std::string> passed_over;
  };

  /**
   * Read the newest whole checkpoint in the results of a run. Throws ExcRun on
   * all ranks, with what is wrong with each, if there is none that this emmy
   * can read. Collective.
   *
   * @param latest no newer one than of this step
   * @param for_what in the words of the caller, for messages
   */
  SavedRun
  read_saved_run(
    const std::string &directory,
    const MPI_Comm     communicator,
    const std::string &for_what,
    const unsigned int latest = std::numeric_limits<unsigned int>::max());

  /**
   * Write all that a scene needs to go on: RunState, what effects and
   * measurements remember, and the parameters. Collective; the particles of
   * each rank are written by that rank. Cost: a copy of the particles in
   * memory, and twice a pass over it (checksum and disk).
   *
   * @param parameters as a parameter file
   * @return what went wrong, the same on all ranks; empty: it is on the disk
   */
  template <int dim>
  std::string
  save(const Scene<dim>       &scene,
       const std::string      &parameters,
       const CheckpointFolder &folder,
       const unsigned int      n_kept,
       const bool              is_failure = false);

  /**
   * Let a scene that was just made, and has told its initial_report(), go on
   * from where it was saved. On as many ranks as then particles come back in
   * their order, with their ids and all bits. Collective. Throws ExcRun on all
   * ranks if the scene has other fields.
   */
  template <int dim>
  void
  recall(const SavedRun &saved, Scene<dim> &scene);

  /** The particles of its parts, and the stored energies that its ledger has
   * by column, J. For another scene that starts from it. */
  template <int dim>
  Parcel<dim>
  particles_of(const SavedRun &saved);
  /** At the time of the checkpoint, J. */
  template <int dim>
  std::map<std::string, double>
  stored_energies(const SavedRun &saved);
} // namespace emmy

#endif
