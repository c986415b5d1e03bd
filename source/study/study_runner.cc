#include <emmy/base/exceptions.h>
#include <emmy/base/whole_file.h>
#include <emmy/run/run.h>
#include <emmy/run/scene_parameters.h>
#include <emmy/study/study_runner.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace emmy
{
  namespace
  {
    namespace fs = std::filesystem;

    template <int dim>
    std::string
    parameters_text(const ParameterFile &file)
    {
      std::ostringstream         text;
      const SceneParameters<dim> parameters(file);
      parameters.print(text);
      return text.str();
    }

    /** All parameters of a scene. Throws ExcParameter or ExcRun. */
    std::string
    parameters_text(const ParameterFile &file)
    {
      return dimension_of(file) == 2 ? parameters_text<2>(file)
                                     : parameters_text<3>(file);
    }

    /** Let the next peak be that of the next run. Without effect elsewhere
     * than on Linux: then the peak is that of the study so far. */
    void
    forget_peak_memory()
    {
      std::ofstream("/proc/self/clear_refs") << "5\n" << std::flush;
    }

  } // namespace

  std::string
  failure_of(const std::function<void()> &work, const bool is_alone)
  {
    const auto text = [](const std::string &message) {
      return message.empty() ? std::string("an error without words") : message;
    };
    try
      {
        work();
      }
    catch (const ExcParameter &error)
      {
        return text(message_of(error));
      }
    catch (const ExcRun &error)
      {
        return text(message_of(error));
      }
    catch (const dealii::ExceptionBase &error)
      {
        if (!is_alone)
          throw;
        return "unexpected error: " + message_of(error);
      }
    catch (const std::exception &error)
      {
        if (!is_alone)
          throw;
        return std::string("unexpected error: ") + error.what();
      }
    catch (...) // Epetra throws numbers
      {
        if (!is_alone)
          throw;
        return "unexpected error of an unknown kind";
      }
    return {};
  }

  std::string
  reading_problem(const StudyPlan &plan, const StudyMember &member)
  {
    return failure_of([&] { parameters_text(plan.scene(member, 0)); },
                      /*is_alone=*/false);
  }

  void
  require_readable_members(const StudyPlan &plan)
  {
    std::string first_problem;
    for (const StudyMember &member : plan.members)
      {
        const std::string problem = reading_problem(plan, member);
        if (problem.empty())
          return;
        if (first_problem.empty())
          first_problem = member.name + ": " + problem;
      }
    AssertThrow(false,
                ExcRun("Study",
                       "no member can be read. The first: " + first_problem,
                       "correct <Entries> or <Values> of the study's lists, "
                       "or its base scene."));
  }

  StudyRunner::StudyRunner(const StudyPlan &plan,
                           const bool       overwrite,
                           const MPI_Comm   communicator)
    : plan(plan)
    , overwrite(overwrite)
    , communicator(communicator)
    , is_first(dealii::Utilities::MPI::this_mpi_process(communicator) == 0)
    , is_alone(dealii::Utilities::MPI::n_mpi_processes(communicator) == 1)
  {}

  std::string
  StudyRunner::run_member(const StudyMember &member)
  {
    has_run = false;
    std::string failure;
    for (unsigned int r = 0; r < plan.repetitions && failure.empty(); ++r)
      failure = run_once(member, r);
    return failure;
  }

  std::string
  StudyRunner::outcome_there(const std::string &folder,
                             const std::string &key) const
  {
    std::string outcome;
    if (is_first && !overwrite)
      {
        std::ifstream      file(folder + "/member.txt");
        std::ostringstream rest;
        std::getline(file, outcome);
        rest << file.rdbuf();
        if (rest.str() != key ||
            (outcome == "done" && !(fs::exists(folder + "/ledger.csv") &&
                                    fs::exists(folder + "/timing.json"))))
          outcome.clear();
      }
    return dealii::Utilities::MPI::broadcast(communicator, outcome);
  }

  void
  StudyRunner::record(const std::string &folder,
                      const std::string &outcome,
                      const std::string &key) const
  {
    std::string problem;
    if (is_first)
      {
        std::error_code ignored; // then the file cannot be opened
        fs::create_directories(folder, ignored);
        problem =
          write_whole_file(folder + "/member.txt", outcome + '\n' + key);
      }
    throw_together(communicator,
                   "Study",
                   problem,
                   file_remedy +
                     " Then start the study again, which goes on here.");
  }

  std::string
  StudyRunner::key(const StudyMember &member,
                   const unsigned int repetition) const
  {
    const unsigned int n_ranks = plan.ranks(member);
    return "emmy " EMMY_VERSION ", ranks: " +
           std::to_string(n_ranks > 0 ? n_ranks
                                      : dealii::Utilities::MPI::n_mpi_processes(
                                          communicator)) +
           "\n" + parameters_text(plan.scene(member, repetition));
  }

  bool
  StudyRunner::look_up(const StudyMember &member, std::string &failure) const
  {
    for (unsigned int r = 0; r < plan.repetitions && failure.empty(); ++r)
      {
        std::string wanted;
        failure = failure_of([&] { wanted = key(member, r); }, is_alone);
        if (!failure.empty())
          return true;
        const std::string there = outcome_there(plan.folder(member, r), wanted);
        if (there.empty())
          return false;
        if (there != "done")
          failure = there.substr(there.find(' ') + 1);
      }
    return true;
  }

  std::string
  StudyRunner::run_scene(const ParameterFile &scene,
                         const unsigned int   n_ranks) const
  {
    const auto run_on = [&scene](const MPI_Comm ranks) {
      RunOptions options;
      options.overwrite = true;
      options.is_quiet  = true;
      if (dimension_of(scene) == 2)
        run<2>(scene, options, ranks);
      else
        run<3>(scene, options, ranks);
    };
    const unsigned int n_there =
      dealii::Utilities::MPI::n_mpi_processes(communicator);
    if (n_ranks == 0 || n_ranks == n_there)
      return failure_of([&] { run_on(communicator); }, is_alone);
    // the others wait for the outcome
    const unsigned int rank =
      dealii::Utilities::MPI::this_mpi_process(communicator);
    const bool  takes_part = rank < n_ranks;
    MPI_Comm    some       = MPI_COMM_NULL;
    std::string failure;
    MPI_Comm_split(communicator, takes_part ? 0 : MPI_UNDEFINED, rank, &some);
    if (takes_part)
      {
        failure = failure_of([&] { run_on(some); }, n_ranks == 1);
        MPI_Comm_free(&some);
      }
    return dealii::Utilities::MPI::broadcast(communicator, failure);
  }

  std::string
  StudyRunner::run_once(const StudyMember &member,
                        const unsigned int repetition)
  {
    const std::string folder = plan.folder(member, repetition);
    std::string       wanted;
    std::string       failure =
      failure_of([&] { wanted = key(member, repetition); }, is_alone);
    if (!failure.empty())
      return failure; // costs nothing: tried again each time
    const std::string there = outcome_there(folder, wanted);
    if (there == "done")
      return {};
    const unsigned int n_ranks = plan.ranks(member);
    const unsigned int n_there =
      dealii::Utilities::MPI::n_mpi_processes(communicator);
    if (n_ranks > n_there) // may be mended by the next start
      return "it wants " + std::to_string(n_ranks) + " ranks, there are " +
             std::to_string(n_there) + ": start with mpirun -np " +
             std::to_string(n_ranks);

    // An interrupted run has no outcome. One that failed is tried again: the
    // disk may have been full, or a rank lost.
    if (is_first)
      {
        std::error_code ignored; // there may be none
        fs::remove(folder + "/member.txt", ignored);
      }
    forget_peak_memory();
    const double start = MPI_Wtime();
    failure            = run_scene(plan.scene(member, repetition), n_ranks);
    seconds += MPI_Wtime() - start;
    ++n_runs;
    has_run = true;
    std::replace(failure.begin(), failure.end(), '\n', ' ');
    record(folder, failure.empty() ? "done" : "failed: " + failure, wanted);
    return failure;
  }

} // namespace emmy
