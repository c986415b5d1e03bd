#ifndef emmy_output_run_directory_h
#define emmy_output_run_directory_h

#include <deal.II/base/mpi.h>

#include <string>

namespace emmy
{
  /**
   * The folder that receives the results of one run. Made once, before the
   * first output.
   *
   * A folder holds a run if there is a ledger.csv in it. An old run is never
   * mixed with a new one: it is refused, or removed on request.
   */
  class RunDirectory
  {
  public:
    /**
     * Collective: prepare the folder, with its parents.
     *
     * @param path      absolute or relative to the current folder; all ranks
     *                  must see the same file system there
     * @param overwrite remove an old run: the ledger, particles and grid
     *                  files, parameters, log, timing, field list,
     *                  pictures, checkpoints and what a failure left, and
     *                  nothing else
     *
     * Throws ExcRun on all ranks if the folder cannot be made or written to,
     * or if it holds a run and @p overwrite is false.
     */
    RunDirectory(const std::string &path,
                 const bool         overwrite,
                 const MPI_Comm     communicator);

    /**
     * Collective: the folder of a run that goes on there; nothing is removed.
     * Throws ExcRun on all ranks if no file can be written in it.
     */
    static RunDirectory
    of_run(const std::string &path, const MPI_Comm communicator);

    /**
     * Remove the files of frames from a number on, that of the next frame. For
     * one rank; a file that stays is written over, or no .pvd names it.
     */
    void
    remove_frames_from(const unsigned int number) const;

    /** As given to the constructor. */
    const std::string &
    path() const;

    /** The name, with the folder, of the file @p name in it. */
    std::string
    file(const std::string &name) const;

  private:
    enum class Old
    {
      refused,
      removed,
      kept
    };

    RunDirectory(const std::string &path,
                 const Old          old_run,
                 const MPI_Comm     communicator);

    const std::string directory;
  };
} // namespace emmy

#endif
