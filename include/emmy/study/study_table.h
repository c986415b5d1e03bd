#ifndef emmy_study_study_table_h
#define emmy_study_study_table_h

#include <emmy/study/study_plan.h>

#include <iosfwd>
#include <limits>
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

    unsigned int
    n_done() const;

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
      std::string         state = "not run", reason;
      std::vector<double> quantities; ///< unknown if the ledger has none
      std::vector<double> seconds;    ///< of the repetitions, ascending
      double balance_error = unknown, memory = unknown, ranks = unknown;
      double newton_iterations = unknown, linear_iterations = unknown;
      double steps = unknown;

      double
      median_seconds() const;
    };

    /** The columns of study.csv. */
    std::vector<std::string>
    column_names() const;

    /** Of a quantity, to the reference; unknown without one. */
    double
    difference(const unsigned int m, const unsigned int quantity) const;

    const StudyPlan         &plan;
    std::vector<Row>         rows;
    std::vector<std::string> ledger_columns; ///< of all members that are done
  };
} // namespace emmy

#endif
