#ifndef emmy_study_ledger_history_h
#define emmy_study_ledger_history_h

#include <string>
#include <vector>

namespace emmy
{
  /**
   * A ledger.csv, read back, with three columns that follow from it:
   *
   * - `total_energy`: what the body has, kinetic + strain + hardening energy;
   * - `lost_energy`: what left without a physical cause since row 0, so works
   *   less dissipation less the gain of total_energy. That is the sum of all
   *   columns of losses, less residual_work and balance_error, J;
   * - `lost_share`: lost_energy over the largest total_energy of the run.
   */
  class LedgerHistory
  {
  public:
    /** Throws ExcRun if the file cannot be read. */
    explicit LedgerHistory(const std::string &filename);

    /** Whether there is such a column. */
    bool
    has(const std::string &column) const;

    /** A value per row. The ledger must have the column. */
    const std::vector<double> &
    column(const std::string &name) const;

    std::vector<std::string> names; ///< of columns

  private:
    void
    derive_energies();

    std::vector<std::vector<double>> columns;
  };
} // namespace emmy

#endif
