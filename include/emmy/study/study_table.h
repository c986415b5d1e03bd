#ifndef emmy_study_study_table_h
#define emmy_study_study_table_h

#include <emmy/study/study_analysis.h>
#include <emmy/study/study_plan.h>

#include <iosfwd>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace emmy
{
  /**
   * What became of the members of a study, read from their files, so that a
   * study that is resumed gives the same table bit by bit. For rank 0.
   */
  class StudyTable
  {
  public:
    /**
     * The table of a study none of whose members has run. Throws ExcParameter
     * if two columns have the same name.
     */
    explicit StudyTable(const StudyPlan &plan);

    /**
     * Member number @p m and its repetitions ran to their end: read
     * ledger.csv and timing.json. Throws ExcRun if one cannot be read.
     */
    void
    add_done(const unsigned int m);

    /** It failed: its reason stands in the table, and no numbers. */
    void
    add_failed(const unsigned int m, const std::string &reason);

    /**
     * Limits of quantities that ask for one, from the members that are done.
     * To be called when no more is added, before errors are asked for.
     */
    void
    find_limits();

    /** Members that have run. */
    unsigned int
    n_done() const;

    /** Whether member m has run. */
    bool
    is_done(const unsigned int m) const;

    /** "done", "not run", or the reason of a failure. */
    std::string
    state(const unsigned int m) const;

    /** What is subtracted from a quantity; NaN: nothing, or not known. */
    double
    reference(const unsigned int quantity) const;

    /** Order of the limit that is the reference; NaN: it is none. */
    double
    limit_order(const unsigned int quantity) const;

    /**
     * Size of a quantity's difference to its reference, over its scale; of a
     * path the distance(). NaN: not known, and for the reference itself.
     */
    double
    error(const unsigned int m, const unsigned int quantity) const;

    /** Median of the repetitions, s; NaN: not known. */
    double
    seconds(const unsigned int m) const;

    /** Longest less shortest, s; NaN: not known. */
    double
    spread(const unsigned int m) const;

    /** One per member. */
    std::vector<double>
    all_seconds() const;
    /** By member; NaN: none. */
    std::vector<double>
    errors(const unsigned int quantity) const;

    /** Columns by name, of a member that is done; NaN: not known. */
    double
    number(const unsigned int m, const std::string &column) const;

    /**
     * The quantities that no member's ledger has, although at least one is
     * done, each with the nearest column that there is. Empty: none.
     */
    std::string
    unknown_quantities() const;

    /**
     * study.csv: one row per member (doc/study.md has the columns). What is
     * not known is left empty. Throws ExcRun if it cannot be written.
     */
    void
    write_csv(const std::string &filename) const;

    /** A short table for the screen, with the reasons of failures. */
    void
    print(std::ostream &out) const;

  private:
    static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

    struct Row
    {
      std::string            state = "not run", reason;
      std::vector<double>    values;  ///< of quantities; unknown: none
      std::vector<StudyPath> paths;   ///< of those that are paths
      std::vector<double>    seconds; ///< of the repetitions, ascending
      /** Further columns; those of phases are in phase_columns. */
      std::map<std::string, double> numbers;
    };

    /** The columns of study.csv. */
    std::vector<std::string>
    column_names() const;

    bool
    has_difference(const unsigned int quantity) const;

    /** Of a quantity, to the reference; unknown without one. */
    double
    difference(const unsigned int m, const unsigned int quantity) const;

    const StudyPlan         &plan;
    std::vector<Row>         rows;
    std::vector<std::string> ledger_columns; ///< of all members that are done
    std::vector<std::string> phase_columns;  ///< likewise
    std::vector<StudyLimit>  limits;         ///< one per quantity
  };
} // namespace emmy

#endif
