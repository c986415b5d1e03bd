#ifndef emmy_output_checkpoint_folder_h
#define emmy_output_checkpoint_folder_h

#include <deal.II/base/mpi.h>

#include <string>
#include <string_view>
#include <vector>

namespace emmy
{
  /** A whole checkpoint, as this rank reads it. */
  struct ReadCheckpoint
  {
    unsigned int step = 0; ///< after which it was written
    std::string  path;     ///< its folder; empty: there is none
    std::string  head;     ///< what rank 0 wrote; on all ranks
    /** What ranks wrote: those of rank r, r + n, ... on rank r of n. */
    std::vector<std::string> parts;
    /** Why newer ones are not used, one line each; on all ranks. */
    std::vector<std::string> passed_over;
  };

  /**
   * The folder `checkpoints` in the results of a run. A checkpoint is a folder
   * step-NNNNNNNN in it: a sealed file of each rank, and one of rank 0, the
   * head, with the checksums of all others. It is written under another name,
   * handed to the disk and renamed, so that who reads it or comes after a
   * crash finds it whole or not at all. What the bytes mean is up to the
   * caller.
   *
   * Cost: what each rank has is written once, by that rank, and read once.
   */
  class CheckpointFolder
  {
  public:
    /** Of what is written now; older emmys refuse newer numbers. */
    static constexpr unsigned int format = 3;

    /** @param directory the results of the run */
    CheckpointFolder(const std::string &directory, const MPI_Comm communicator);

    /**
     * Write a checkpoint, then remove all but the last @p n_kept. One that is
     * there already is replaced. Collective.
     * @param head  of rank 0
     * @param parts of this rank, one behind the other
     * @return what went wrong, the same on all ranks; then nothing of it is
     *   left, and nothing was removed. Empty: it is on the disk.
     */
    std::string
    write(const unsigned int                   step,
          const std::string                   &head,
          const std::vector<std::string_view> &parts,
          const unsigned int                   n_kept) const;

    /**
     * Read the newest whole checkpoint. Collective.
     * @param latest no newer one than of this step
     */
    ReadCheckpoint
    read_newest(const unsigned int latest) const;

    /** Rename those after a step, which are damaged: damaged-step-... */
    void
    set_aside_after(const unsigned int step) const;

  private:
    /** The steps of which there are checkpoints, whole or not; ascending. */
    std::vector<unsigned int>
    steps() const;
    std::string
    path_of(const unsigned int step) const;
    /** Read one; what is wrong with it, the same on all ranks. */
    std::string
    read(ReadCheckpoint &checkpoint) const;
    /** The work of rank 0 at the end of write(). */
    std::string
    put_in_place(const unsigned int step, const unsigned int n_kept) const;

    const std::string folder;
    const MPI_Comm    communicator;
    const bool        is_first;
  };
} // namespace emmy

#endif
