#ifndef emmy_run_price_h
#define emmy_run_price_h

#include <emmy/base/effect_card.h>
#include <emmy/base/phases.h>
#include <emmy/output/ledger.h>

#include <iosfwd>
#include <string>
#include <vector>

namespace emmy
{
  /** Counts of a run that stand in no other table. */
  struct RunCounts
  {
    unsigned int steps        = 0; ///< that were made
    unsigned int halvings     = 0; ///< how often a step was tried again
    unsigned int damped       = 0; ///< steps that needed a damped Newton matrix
    unsigned int rebalancings = 0; ///< how often cells went to other ranks
  };

  /**
   * What a run cost: seconds by phase, and seconds and joules by effect. Made
   * by the run at its end, for run.log and timing.json.
   *
   * The seconds of an effect are those that were booked to it, or those of the
   * phases that are its alone. What all effects share (gather, solves, output)
   * belongs to none.
   */
  class Price
  {
  public:
    /**
     * Collective.
     * @param cards of the effects that are present
     */
    Price(const Phases                  &phases,
          const std::vector<EffectCard> &cards,
          const MPI_Comm                 communicator);

    /**
     * The tables of phases and of effects; under each effect what the ledger
     * says of it, a line for each column. For rank 0.
     */
    void
    print(std::ostream &out, const Ledger &ledger) const;

    /**
     * All of this as JSON (doc/timing.md has the keys). Written by rank 0;
     * throws ExcRun on all ranks if that fails. Collective.
     */
    void
    write_json(const std::string &filename,
               const Ledger      &ledger,
               const RunCounts   &counts) const;

  private:
    /** An effect: its times, and its columns in the ledger that are energies.
     */
    struct Line
    {
      Phases::Row              time;
      std::vector<std::string> ledger_columns;
    };

    const Phases                  &phases;
    const MPI_Comm                 communicator;
    const std::vector<Phases::Row> phase_rows;
    const double                   total;
    std::vector<Line>              lines;
    /** Largest memory that a rank ever had, and the sum of them, bytes. */
    double largest_memory = 0., sum_of_memory = 0.;
  };
} // namespace emmy

#endif
