#ifndef emmy_study_study_h
#define emmy_study_study_h

#include <emmy/study/study_plan.h>

#include <deal.II/base/mpi.h>

namespace emmy
{
  /**
   * Run the members of a study one after another, each on all ranks or on as
   * many as it says, and write study.csv, the page study.md and its pictures.
   * Collective.
   *
   * A member that fails is noted with its reason, and the study goes on. Each
   * run leaves a file member.txt in its folder, once it has ended: how, and
   * with which parameters, ranks and version of emmy. Where all of these are
   * the same the run, done or failed, is not repeated, unless @p overwrite is
   * set. Other results in a member's folder are replaced.
   *
   * Throws ExcParameter or ExcRun on all ranks if no member can be read or
   * none is done, or if no ledger has a quantity; study.csv is there then.
   * An error that one of several ranks may meet alone is not caught.
   */
  void
  run_study(const StudyPlan &plan,
            const bool       overwrite,
            const MPI_Comm   communicator);

  /**
   * List the members, and read the scene of each. Runs nothing. Collective.
   * Throws ExcRun on all ranks if one cannot be read.
   */
  void
  check_study(const StudyPlan &plan, const MPI_Comm communicator);

  /**
   * Say on the screen which member that has run is the cheapest with at most
   * this @p tolerance, for each quantity. Runs nothing. Collective. Throws
   * ExcRun on all ranks if there is none.
   */
  void
  answer_study(const StudyPlan &plan,
               const double     tolerance,
               const MPI_Comm   communicator);
} // namespace emmy

#endif
