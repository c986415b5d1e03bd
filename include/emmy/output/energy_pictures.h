#ifndef emmy_output_energy_pictures_h
#define emmy_output_energy_pictures_h

#include <iosfwd>
#include <string>
#include <vector>

namespace emmy
{
  /**
   * The gnuplot script that shows the energies of a run over time: what is
   * stored and where energy went, their sum, and beside it what the energy at
   * the start and works from outside make. Used by Pictures.
   * @param title printed above, plain text; may be empty
   * @param columns of the ledger
   */
  void
  write_energies_script(std::ostream                   &script,
                        const std::string              &title,
                        const std::vector<std::string> &columns);

  /** The same for |balance_error|, relative to the energy at the start. */
  void
  write_balance_error_script(std::ostream                   &script,
                             const std::string              &title,
                             const std::vector<std::string> &columns);
} // namespace emmy

#endif
