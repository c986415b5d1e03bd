#ifndef emmy_base_effect_card_h
#define emmy_base_effect_card_h

#include <emmy/base/field.h>

#include <string>
#include <vector>

namespace emmy
{
  /**
   * What an effect, or a choice of method that costs something, says of
   * itself. Each returns it from its own pair of files; the scene card shows
   * those that are present, on request also those that are absent. Numbers
   * are not here: they are counted in the scene as it is built.
   */
  struct EffectCard
  {
    /** As in the parameter file; for entries of a library set by the scene. */
    std::string name = {};
    /** What to write to have it; set by the scene for entries of a library. */
    std::string setting = {};
    /** Where it enters the step, in words. */
    std::string enters = {};
    /** What it adds to each particle. */
    std::vector<Field> fields = {};
    /** The nodes that it couples beyond those of a cell; empty: none. */
    std::string couples = {};
    /** Its columns in ledger.csv. */
    std::vector<std::string> ledger_columns = {};
    /** What it adds to grid.pvd; particles.pvd has all fields. */
    std::vector<std::string> grid_output = {};
    /** Phases of the table of times that are its alone. */
    std::vector<std::string> phases = {};
    /** Matrices of the size of M~ that it keeps. */
    unsigned int n_matrices = 0;
    /** Whether the scene has it. */
    bool is_present = false;
  };
} // namespace emmy

#endif
