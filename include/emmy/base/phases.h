#ifndef emmy_base_phases_h
#define emmy_base_phases_h

#include <deal.II/base/exceptions.h>
#include <deal.II/base/mpi.h>

#include <chrono>
#include <cstddef>
#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

namespace emmy
{
  /**
   * Where the time of a run goes: wall seconds per named phase, such as
   * "particles to grid". Phases do not nest, so that the seconds of the table
   * add up to the wall time:
   * @code
   *   const auto timed = phases.scope("particles to grid");
   * @endcode
   *
   * One object per run, owned by the run loop and lent to the step and the
   * solver. A scope costs two readings of the clock and a look-up among a few
   * names, well below a microsecond; it does not communicate. Ranks are
   * combined in print() and write_json() only, where the seconds of a phase
   * are those of its slowest rank. (dealii::TimerOutput communicates whenever
   * a section ends.)
   */
  class Phases
  {
  public:
    /** Times one phase from its construction to its destruction. */
    class [[nodiscard]] Scope
    {
    public:
      ~Scope();
      Scope(const Scope &) = delete;
      Scope &
      operator=(const Scope &) = delete;

    private:
      friend class Phases;
      Scope(Phases &phases, const std::size_t index);

      Phases                                     &phases;
      const std::size_t                           index;
      const std::chrono::steady_clock::time_point start;
    };

    /**
     * The combined times of one phase.
     */
    struct Row
    {
      std::string name;
      double      calls        = 0.; ///< most calls on any rank
      double      seconds      = 0.; ///< of the slowest rank
      double      mean_seconds = 0.; ///< average over the ranks
      double      points       = 0.; ///< sum over the ranks; 0: not counted
    };

    /** The clock of the total starts here. */
    explicit Phases(const MPI_Comm communicator);

    /**
     * Time the phase with this name until the returned object ends.
     * @pre No other scope of this object is open: phases do not nest.
     */
    Scope
    scope(const std::string_view phase);

    /**
     * Note that the phase dealt with @p n_points more points (or other
     * items) on this rank, for the column "points per second".
     */
    void
    add_count(const std::string_view phase, const std::size_t n_points);

    /**
     * Collective: the phases in the order of their first use, combined over
     * the ranks. A phase that some ranks never entered counts as zero there.
     */
    std::vector<Row>
    rows() const;

    /**
     * Collective: a table with one line per phase (calls, seconds, share of
     * the total, points per second), the time outside all phases, and the
     * total. Only rank 0 writes to @p out.
     */
    void
    print(std::ostream &out) const;

    /**
     * Collective: the same numbers as a JSON file, written by rank 0. Throws
     * ExcRun on all ranks if the file cannot be written.
     */
    void
    write_json(const std::string &filename) const;

  private:
    struct Entry
    {
      std::string name;
      std::size_t calls   = 0;
      double      seconds = 0.;
      std::size_t points  = 0;
    };

    /** The index of the phase, which is new if the name is. */
    std::size_t
    find_or_add(const std::string_view phase);

    /** Collective: seconds since construction, of the slowest rank. */
    double
    total_seconds() const;

    const MPI_Comm                              communicator;
    const std::chrono::steady_clock::time_point start;
    std::vector<Entry>                          entries;
    bool                                        scope_is_open = false;
  };
} // namespace emmy

#endif
