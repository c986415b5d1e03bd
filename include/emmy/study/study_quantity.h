#ifndef emmy_study_study_quantity_h
#define emmy_study_study_quantity_h

#include <emmy/study/ledger_history.h>

#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace emmy
{
  /** Some columns of a ledger over a part of a run. */
  struct StudyPath
  {
    std::vector<double>              times;      ///< s, ascending
    std::vector<std::vector<double>> components; ///< of each point in time

    /** Values at a time, linear between rows, constant beyond the ends. */
    std::vector<double>
    at(const double time) const;

    /** The largest distance of two of its points along one component. */
    double
    range() const;
  };

  /**
   * Root of the mean square distance of two paths, over the rows of the one
   * with fewer; the other is interpolated.
   */
  double
  distance(const StudyPath &a, const StudyPath &b);


  /**
   * What a study compares, made of the ledger of each member. In words, with
   * `from T` and `to T` (s) behind it to look at a part of the run:
   *
   * - `COLUMN`: the last value;
   * - `largest COLUMN`: the largest in size;
   * - `time of largest COLUMN`: when it was that, with a parabola through the
   *   rows about it, so that the error is of second order in the step;
   * - `path of COLUMN`: all values. `path of NAME` is that of the columns
   *   NAME_x, NAME_y, NAME_z, so of a measured particle.
   */
  struct StudyQuantity
  {
    /** What is taken of a column. */
    enum class Kind
    {
      last,
      largest,
      time_of_largest,
      path
    };

    Kind kind = Kind::last; ///< of this quantity
    /** As written, and the ledger's. */
    std::string words, column;
    double      from = -std::numeric_limits<double>::infinity(); ///< s
    double      to   = std::numeric_limits<double>::infinity();  ///< s

    /** @return whether @p words say one; then @p quantity is it */
    static bool
    parse(const std::string &words, StudyQuantity &quantity);

    /** Its column in study.csv: the words with underscores. */
    std::string
    name() const;

    /** Whether the ledger has its columns. */
    bool
    is_in(const LedgerHistory &ledger) const;

    /** Of a ledger that has it, not of a path; NaN if no row is in its time. */
    double
    value(const LedgerHistory &ledger) const;

    /** The rows in its time; for a path. */
    StudyPath
    path(const LedgerHistory &ledger) const;

  private:
    /** First row in its time, and the one behind the last. */
    std::pair<std::size_t, std::size_t>
    rows(const std::vector<double> &times) const;
  };
} // namespace emmy

#endif
