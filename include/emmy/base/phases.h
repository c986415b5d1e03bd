#ifndef emmy_base_phases_h
#define emmy_base_phases_h

#include <deal.II/base/exceptions.h>
#include <deal.II/base/mpi.h>

#include <chrono>
#include <cstddef>
#include <functional>
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
   * Within and across phases, the time of effects is booked a second time by
   * name, for their price: see effect().
   *
   * One object per run, owned by the run loop and lent to the step and the
   * solver. A scope costs two readings of the clock and a look-up among a few
   * names, well below a microsecond; it does not communicate. Ranks are
   * combined in rows(), effects() and print() only, where the seconds of a
   * phase are those of its slowest rank. (dealii::TimerOutput communicates
   * whenever a section ends.)
   */
  class Phases
  {
  public:
    /** Times a phase or an effect from its construction to its destruction. */
    class [[nodiscard]] Scope
    {
    public:
      ~Scope();
      Scope(const Scope &) = delete;
      Scope &
      operator=(const Scope &) = delete;

    private:
      friend class Phases;
      friend Scope
      effect_scope(Phases *, const std::string_view);
      /** Times nothing. */
      Scope() = default;
      Scope(Phases &phases, const std::size_t index, const bool is_effect);

      Phases                                     *phases    = nullptr;
      const std::size_t                           index     = 0;
      const bool                                  is_effect = false;
      const std::size_t                           outer     = no_effect;
      const std::chrono::steady_clock::time_point start     = {};
    };

    /** The combined times of one phase or effect. */
    struct Row
    {
      std::string name;   ///< as in the table of times
      std::string within; ///< the effect that it is a part of; empty: none
      double      calls        = 0.; ///< most calls on any rank
      double      seconds      = 0.; ///< of the slowest rank
      double      mean_seconds = 0.; ///< average over the ranks
      double      points       = 0.; ///< sum over the ranks; 0: not counted
      double      iterations   = 0.; ///< of linear solvers; 0: none

      /** 0 if not counted. */
      double
      points_per_second() const
      {
        return seconds > 0. ? points / seconds : 0.;
      }
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
     * Book the time until the returned object ends to an effect, within or
     * outside a phase. Within the scope of another effect it is a part of that
     * one's time; a name always has the same place.
     */
    Scope
    effect(const std::string_view name);

    /**
     * Note that the phase dealt with @p n_points more points (or other
     * items) on this rank, for the column "points per second".
     */
    void
    add_count(const std::string_view phase, const std::size_t n_points);

    /** The same for the points of an effect. */
    void
    add_effect_count(const std::string_view effect, const std::size_t n_points);

    /** Iterations of a solve in a phase, and in the open effect; all ranks. */
    void
    add_iterations(const std::string_view phase, const std::size_t n);

    /**
     * Who listens to news from within a step, e.g. the progress on the
     * screen; on any ranks. He must outlive the run.
     */
    void
    set_listener(std::function<void(const std::string &)> listener);

    /** What is done from now on, e.g. "Step 3 from t = 0.2 s". */
    void
    begin_task(const std::string &task);

    /** News of that task; nothing happens where nobody listens. */
    void
    tell(const std::string &news) const;

    /**
     * Collective: the phases in the order of their first use, combined over
     * the ranks. A phase that some ranks never entered counts as zero there.
     */
    std::vector<Row>
    rows() const;

    /** Collective: the effects, in the same way. */
    std::vector<Row>
    effects() const;

    /**
     * Seconds of this rank in effects whose names begin so, and that are not
     * part of one another. No communication.
     */
    double
    seconds_here(const std::string_view effects) const;

    /** Collective: seconds since construction, of the slowest rank. */
    double
    total_seconds() const;

    /**
     * Seconds of the run that no phase accounts for, on average.
     * @param rows,total what rows() and total_seconds() returned
     */
    static double
    seconds_outside(const std::vector<Row> &rows, const double total);

    /**
     * A table with one line per phase (calls, seconds, share of the total,
     * points per second, iterations), the time outside all phases, and the
     * total. For rank 0.
     *
     * @param rows,total what rows() and total_seconds() returned
     */
    void
    print(std::ostream           &out,
          const std::vector<Row> &rows,
          const double            total) const;

  private:
    struct Entry
    {
      std::string name, within;
      std::size_t calls      = 0;
      double      seconds    = 0.;
      std::size_t points     = 0;
      std::size_t iterations = 0;
    };
    using Entries = std::vector<Entry>;

    static constexpr std::size_t no_effect = static_cast<std::size_t>(-1);

    /** The index of a name, which is new if the name is. */
    static std::size_t
    find_or_add(Entries &entries, const std::string_view name);

    /** Collective. */
    std::vector<Row>
    combined(const Entries &entries) const;

    const MPI_Comm                              communicator;
    const std::chrono::steady_clock::time_point start;
    Entries                                     phases, effects_of_run;
    bool                                        phase_is_open = false;
    std::size_t open_effect = no_effect; ///< the innermost
    std::function<void(const std::string &)> listener;
    std::string                              task;
  };

  /** Phases::effect() where there is a table of phases; null: nothing. */
  inline Phases::Scope
  effect_scope(Phases *phases, const std::string_view effect)
  {
    return phases ? phases->effect(effect) : Phases::Scope();
  }

  /**
   * A line of a table of times: name, calls, seconds, share of @p total,
   * points per second, iterations; what was not counted stays empty. No line
   * break.
   */
  std::string
  time_line(const Phases::Row &row,
            const double       total,
            const std::size_t  name_width);

  /** The headings of such lines, up to the points. */
  std::string
  time_headings(const std::string &what, const std::size_t name_width);
} // namespace emmy

#endif
