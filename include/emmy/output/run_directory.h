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
     *                  files, parameters, log, timing, field list and
     *                  pictures that emmy writes, and nothing else
     *
     * Throws ExcRun on all ranks if the folder cannot be made or written to,
     * or if it holds a run and @p overwrite is false.
     */
    RunDirectory(const std::string &path,
                 const bool         overwrite,
                 const MPI_Comm     communicator);

    /** As given to the constructor. */
    const std::string &
    path() const;

    /** The name, with the folder, of the file @p name in it. */
    std::string
    file(const std::string &name) const;

  private:
    const std::string directory;
  };
} // namespace emmy

#endif
