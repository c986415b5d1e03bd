#ifndef emmy_study_study_runner_h
#define emmy_study_study_runner_h

#include <emmy/study/study_plan.h>

#include <deal.II/base/mpi.h>

#include <functional>

namespace emmy
{
  /**
   * Why @p work failed; empty if it did not. Only our own errors are raised
   * on all ranks together; others are caught if there is one rank.
   */
  std::string
  failure_of(const std::function<void()> &work, const bool is_alone);

  /** Why the scene of a member cannot be read; empty if it can. */
  std::string
  reading_problem(const StudyPlan &plan, const StudyMember &member);

  /**
   * Throws ExcRun if no member can be read: a mistake of the study, not of
   * one member.
   */
  void
  require_readable_members(const StudyPlan &plan);

  /** Runs what is not there yet, and keeps the time. Lives for one study. */
  class StudyRunner
  {
  public:
    /** Of a plan, with this program. */
    StudyRunner(const StudyPlan &plan,
                const bool       overwrite,
                const MPI_Comm   communicator);

    /** All repetitions of a member; why one failed, or empty. Collective. */
    std::string
    run_member(const StudyMember &member);

    /** The same of a member that is there; @return false if it is not, or
     * not all of its repetitions. Collective. */
    bool
    look_up(const StudyMember &member, std::string &failure) const;

    /** Whether the last member, or a repetition of it, ran just now. */
    bool has_run = false;

    /** Of the runs so far, on the average; 0 without any. */
    double
    mean_seconds() const
    {
      return n_runs > 0 ? seconds / n_runs : 0.;
    }

  private:
    std::string
    run_once(const StudyMember &member, const unsigned int repetition);

    /** What a run must have been made with to count. May throw. */
    std::string
    key(const StudyMember &member, const unsigned int repetition) const;

    /** On so many ranks; why it failed, or empty. Collective. */
    std::string
    run_scene(const ParameterFile &scene, const unsigned int n_ranks) const;

    /** How a run with this @p key ended that is there already; empty if
     * none is. Rank 0 looks. Collective. */
    std::string
    outcome_there(const std::string &folder, const std::string &key) const;

    /** Write member.txt. Collective. */
    void
    record(const std::string &folder,
           const std::string &outcome,
           const std::string &key) const;

    const StudyPlan &plan;
    const bool       overwrite;
    const MPI_Comm   communicator;
    const bool       is_first, is_alone;
    unsigned int     n_runs  = 0;
    double           seconds = 0.;
  };

} // namespace emmy

#endif
