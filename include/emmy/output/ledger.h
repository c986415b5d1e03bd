#ifndef emmy_output_ledger_h
#define emmy_output_ledger_h

#include <emmy/effects/step_report.h>

#include <fstream>
#include <string>
#include <vector>

namespace emmy
{
  /**
   * Where every joule went: one row per accepted step. The balance
   *   kinetic energy gained + stored + dissipated - work = 0
   * holds to round-off in each step; `balance_error` is its cumulative sum.
   * Row 0 is the initial state. Written by rank 0 as comma-separated text with
   * a header; a column is there only where its effect is.
   */
  class Ledger
  {
  public:
    /** One line of the ledger, by column. */
    using Row = std::vector<double>;

    /**
     * @param initial  the state before the first step; its energy entries and
     *   measures are those of all later reports, and what is in the entries is
     *   what there was before
     * @param dim      2: only momenta in the plane
     * @param sums     where the sums are kept; null: in the ledger
     */
    Ledger(const StepReport  &initial,
           const unsigned int dim,
           LedgerSums        *sums = nullptr);
    Ledger(const Ledger &) = delete;

    /**
     * From now on write rows, those so far included, to a file.
     */
    void
    write_to(const std::string &filename);

    /**
     * Go on with the ledger that a file holds up to a step, which is that of
     * the sums: rows after it, and half a row, are cut off, and new ones
     * follow. The file's other bytes stay. For rank 0.
     * @param time at the end of that step, s
     * @return what is wrong with the file; then it is as it was. Empty: nothing
     */
    std::string
    go_on(const std::string &filename,
          const unsigned int step,
          const double       time);

    /** The same on other ranks, with the rows of rank 0. */
    void
    set_rows(const std::vector<Row> &rows);

    /** Hand the rows to the disk. What went wrong; empty: nothing did. */
    std::string
    flush() const;

    /** A row. */
    void
    add(const StepReport &report);

    /** What went wrong with the file on this rank; empty: nothing. */
    const std::string &
    problem() const;

    /** Names, in their order. */
    const std::vector<std::string> &
    columns() const;

    /** So far, the first is that of the start. */
    const std::vector<Row> &
    rows() const;

    /** What each cause did to the energy so far. */
    const std::vector<EnergyEntry> &
    energies() const;

    /** A value of the last row. */
    double
    operator[](const std::string &column) const;

    /** Kinetic plus stored energy of the last row, J. */
    double
    total_energy() const;

    /** The same of the first row, J. */
    double
    energy_at_start() const;

    /** The largest of all rows, J. */
    double
    largest_energy() const;

  private:
    void
    write_row(const Row &row);
    double
    energy_of(const Row &row) const;

    const unsigned int       dim;
    std::vector<std::string> names;
    std::vector<Row>         all_rows;
    LedgerSums               own_sums;
    LedgerSums              &sums;
    std::string              name, write_problem;
    std::ofstream            file;
  };
} // namespace emmy

#endif
