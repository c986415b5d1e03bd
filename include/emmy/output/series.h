#ifndef emmy_output_series_h
#define emmy_output_series_h

#include <deal.II/base/mpi.h>

#include <string>
#include <utility>
#include <vector>

namespace emmy
{
  /**
   * The frames of one kind of output over the time of a run, as the file
   * basename.pvd that ParaView opens. Owned by the run loop. The file is
   * complete after each frame, so that a run can be watched.
   */
  class Series
  {
  public:
    /** Time (s) and file of one frame. */
    using Entry = std::pair<double, std::string>;

    /**
     * @param directory an existing folder, the one of the frames
     * @param of_run    borrowed: where the frames are listed, those of before
     *   among them; null: in the series
     */
    Series(const std::string  &directory,
           const std::string  &basename,
           const MPI_Comm      communicator,
           std::vector<Entry> *of_run = nullptr);
    Series(const Series &) = delete;

    /**
     * Collective: add the frame @p file, as DataFile::write() returned it, at
     * @p time (s), and rewrite the .pvd on rank 0. Throws ExcRun on all ranks
     * if it cannot be written.
     */
    void
    add(const double time, const std::string &file);

    /** Write the .pvd of the frames so far; without any there is none. */
    void
    write() const;

  private:
    const std::string   filename;
    const MPI_Comm      communicator;
    std::vector<Entry>  own_frames;
    std::vector<Entry> &frames;
  };
} // namespace emmy

#endif
