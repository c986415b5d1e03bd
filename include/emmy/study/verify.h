#ifndef emmy_study_verify_h
#define emmy_study_verify_h

#include <deal.II/base/mpi.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace emmy
{
  /** The ledger of a scene, by its columns; a value a row. */
  using LedgerColumns = std::map<std::string, std::vector<double>>;

  /** A number of a scene, and what it has to be. */
  struct Claim
  {
    std::string what;      ///< with its unit
    double      reference; ///< paper's, closed form, or another program's
    /**
     * How far from the reference the number may be, in the reference's unit;
     * of a reference that is 0 the largest number that is allowed.
     */
    double allowed;
    /** Where it is published. */
    std::string source;
    /** From the ledger's columns. */
    std::function<double(const LedgerColumns &)> value;
  };

  /** A scene that emmy brings along, and what is claimed of it. */
  struct VerificationCase
  {
    std::string scene; ///< as in prm/, without the ending
    /** As of --set. */
    std::vector<std::string> settings, short_settings;
    /** Of all runs; of full runs only. */
    std::vector<Claim> claims, full_claims;
    bool               is_short = true; ///< whether short runs have it
  };

  /** All of them. */
  std::vector<VerificationCase>
  verification_cases();

  /** The text of a scene that the program holds, by its name in prm/. */
  const std::map<std::string, std::string> &
  verification_scenes();

  /**
   * Run the scenes and print a table: the number, what it should be, how far it
   * may be off, from where that is known, and the verdict. Nothing is written
   * to the disk and no file is read. Collective.
   *
   * @param full all scenes to their ends: a quarter of an hour; or else what
   *   two cores do in two minutes
   * @return whether all claims hold
   */
  bool
  verify(const bool full, const MPI_Comm communicator);
} // namespace emmy

#endif
