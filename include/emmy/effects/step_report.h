#ifndef emmy_effects_step_report_h
#define emmy_effects_step_report_h

#include <emmy/particles/totals.h>

#include <string>
#include <vector>

namespace emmy
{
  /** What one cause did to the energy in one step: a column of the ledger. */
  struct EnergyEntry
  {
    /** On which side of the balance of energy it stands. */
    enum class Kind
    {
      stored,     ///< kept in the body; the ledger shows the total
      dissipated, ///< gone for ever; the ledger shows the sum
      work        ///< put in from outside; the ledger shows the sum
    };
    std::string name;   ///< ledger column
    Kind        kind;   ///< of this entry
    double      change; ///< in this step, J
  };

  /** Add an entry; to that of its name, where several effects have one. */
  inline void
  add_entry(const EnergyEntry &entry, std::vector<EnergyEntry> &entries)
  {
    for (EnergyEntry &there : entries)
      if (there.name == entry.name)
        {
          there.change += entry.change;
          return;
        }
    entries.push_back(entry);
  }

  /** What the ledger has summed so far, J. */
  struct LedgerSums
  {
    std::vector<EnergyEntry> energies; ///< .change is the sum so far
    /** J: what residuals did, and what nothing accounts for. */
    double residual_work = 0., balance_error = 0.;
  };

  /** A number of a step that enters no balance: a column of the ledger. */
  struct StepMeasure
  {
    std::string name;  ///< ledger column
    double      value; ///< in the unit of its name
  };

  /** All that is to be told of an accepted step, summed over the ranks. */
  struct StepReport
  {
    unsigned int step      = 0;  ///< 0: the initial state
    double       time      = 0.; ///< at the end of the step, s
    double       time_step = 0.; ///< s
    Totals       totals;         ///< of the particles, at the end of the step
    /** Kinetic energy of the particles gained in the step, J. */
    double kinetic_energy_change = 0.;
    /** Kinetic energy 1/2 v.M~ v of the grid at both ends of the step, J. */
    double kinetic_energy_grid_old = 0., kinetic_energy_grid_new = 0.;
    std::vector<EnergyEntry> energies; ///< of all effects
    /**
     * Work of what the solvers left, J: r.u of Newton's residual, and
     * (v_new - v_old).(p - M~ v_old) of the point-to-grid map.
     */
    double residual_work = 0.;
    /** Of the accepted step. */
    unsigned int newton_iterations = 0, linear_iterations = 0;
    /** Over all ranks. */
    std::uint64_t active_cells = 0, active_dofs = 0;
    /** How often the step was tried again with half its size. */
    unsigned int halvings = 0;
    /** Whether Newton converged only with a damped matrix. */
    bool is_damped = false;
    /** What was measured besides; the same names in all reports. */
    std::vector<StepMeasure> measures;
    /** Things worth a line on the screen and in the log. */
    std::vector<std::string> notes;
    /** Things for the log alone. */
    std::vector<std::string> findings;
  };
} // namespace emmy

#endif
