#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/study/run.h>
#include <emmy/study/scene_parameters.h>
#include <emmy/study/study.h>
#include <emmy/study/study_table.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
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

    /**
     * Why @p work failed; empty if it did not. Only our own errors are raised
     * on all ranks together; others are caught if there is one rank.
     */
    std::string
    failure_of(const std::function<void()> &work, const bool is_alone)
    {
      const auto text = [](const std::string &message) {
        return message.empty() ? std::string("an error without words")
                               : message;
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

    /** Let the next peak be that of the next run. Without effect elsewhere
     * than on Linux: then the peak is that of the study so far. */
    void
    forget_peak_memory()
    {
      std::ofstream("/proc/self/clear_refs") << "5\n" << std::flush;
    }

    /** Runs what is not there yet, and keeps the time. Lives for one study. */
    class Runner
    {
    public:
      Runner(const StudyPlan &plan,
             const bool       overwrite,
             const MPI_Comm   communicator);

      /** All repetitions of a member; why one failed, or empty. Collective. */
      std::string
      run_member(const StudyMember &member);

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

    Runner::Runner(const StudyPlan &plan,
                   const bool       overwrite,
                   const MPI_Comm   communicator)
      : plan(plan)
      , overwrite(overwrite)
      , communicator(communicator)
      , is_first(dealii::Utilities::MPI::this_mpi_process(communicator) == 0)
      , is_alone(dealii::Utilities::MPI::n_mpi_processes(communicator) == 1)
    {}

    std::string
    Runner::run_member(const StudyMember &member)
    {
      has_run = false;
      std::string failure;
      for (unsigned int r = 0; r < plan.repetitions && failure.empty(); ++r)
        failure = run_once(member, r);
      return failure;
    }

    std::string
    Runner::outcome_there(const std::string &folder,
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
    Runner::record(const std::string &folder,
                   const std::string &outcome,
                   const std::string &key) const
    {
      std::string problem;
      if (is_first)
        {
          std::error_code ignored; // then the file cannot be opened
          fs::create_directories(folder, ignored);
          std::ofstream file(folder + "/member.txt");
          file << outcome << '\n' << key << std::flush;
          if (!file)
            problem = "cannot write <" + folder + "/member.txt>";
        }
      throw_together(communicator,
                     "Study",
                     problem,
                     "check the folder's permissions and the disk's free "
                     "space; then start the study again, which goes on here.");
    }

    std::string
    Runner::run_once(const StudyMember &member, const unsigned int repetition)
    {
      const std::string   folder = plan.folder(member, repetition);
      const ParameterFile scene  = plan.scene(member, repetition);
      std::string         key;
      std::string         failure =
        failure_of([&] { key = parameters_text(scene); }, is_alone);
      if (!failure.empty())
        return failure; // costs nothing: tried again each time
      key =
        "emmy " EMMY_VERSION ", ranks: " +
        std::to_string(dealii::Utilities::MPI::n_mpi_processes(communicator)) +
        "\n" + key;
      const std::string there = outcome_there(folder, key);
      if (there == "done")
        return {};
      if (!there.empty())
        return there.substr(there.find(' ') + 1);

      // an interrupted run has no outcome
      if (is_first)
        {
          std::error_code ignored; // there may be none
          fs::remove(folder + "/member.txt", ignored);
        }
      forget_peak_memory();
      RunOptions options;
      options.overwrite  = true;
      options.is_quiet   = true;
      const double start = MPI_Wtime();
      failure            = failure_of(
        [&] {
          if (dimension_of(scene) == 2)
            run<2>(scene, options, communicator);
          else
            run<3>(scene, options, communicator);
        },
        is_alone);
      seconds += MPI_Wtime() - start;
      ++n_runs;
      has_run = true;
      std::replace(failure.begin(), failure.end(), '\n', ' ');
      record(folder, failure.empty() ? "done" : "failed: " + failure, key);
      return failure;
    }

    /** Throws if no member can be read: a mistake of the study, not of one. */
    void
    require_readable_members(const StudyPlan &plan)
    {
      std::string first_problem;
      for (const StudyMember &member : plan.members)
        {
          const std::string problem =
            failure_of([&] { parameters_text(plan.scene(member, 0)); },
                       /*is_alone=*/false);
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
  } // namespace

  void
  run_study(const StudyPlan &plan,
            const bool       overwrite,
            const MPI_Comm   communicator)
  {
    require_readable_members(plan);
    const bool is_first =
      dealii::Utilities::MPI::this_mpi_process(communicator) == 0;
    std::ostream      nowhere(nullptr);
    std::ostream     &screen    = is_first ? std::cout : nowhere;
    const std::size_t n_members = plan.members.size();
    const std::string csv       = plan.directory + "/study.csv";
    screen << "emmy " EMMY_VERSION ": study of " << n_members << " members, "
           << plan.repetitions << " run" << (plan.repetitions > 1 ? "s" : "")
           << " each, in " << plan.directory << '\n';

    StudyTable   table(plan);
    Runner       runner(plan, overwrite, communicator);
    unsigned int n_run = 0;
    for (unsigned int m = 0; m < n_members; ++m)
      {
        const StudyMember &member = plan.members[m];
        screen << member.name << " of " << n_members << ": "
               << plan.setting(member) << std::flush;
        const std::string failure = runner.run_member(member);
        n_run += runner.has_run;
        // reading and writing is for rank 0; what goes wrong is for all
        const std::string problem =
          is_first ? failure_of(
                       [&] {
                         std::filesystem::create_directories(plan.directory);
                         if (failure.empty())
                           table.add_done(m);
                         else
                           table.add_failed(m, failure);
                         table.write_csv(csv);
                       },
                       /*is_alone=*/true)
                   : std::string();
        throw_together(
          communicator,
          "Study",
          problem,
          "members that are done are kept: start the study again.");
        screen << (failure.empty() ? "  done" : "  FAILED")
               << (runner.has_run ? "" : " (no new run)");
        if (m + 1 < n_members && runner.mean_seconds() > 0.)
          screen << ", at this pace "
                 << std::ceil(runner.mean_seconds() * plan.repetitions *
                              (n_members - m - 1))
                 << " s left";
        screen << std::endl;
        if (is_first && failure.empty() && table.n_done() == 1 &&
            !table.unknown_quantities().empty())
          screen << "  note: its ledger has no column "
                 << table.unknown_quantities() << std::endl;
      }

    table.print(screen);
    screen << "members that ran: " << n_run << ", done: " << table.n_done()
           << " of " << n_members << "; table in " << csv << '\n';
    throw_together(communicator,
                   "Study",
                   is_first && table.n_done() == 0 ? "no member is done" : "",
                   "see the reasons above and in each member's run.log.");
    const std::string unknown = is_first ? table.unknown_quantities() : "";
    throw_together(communicator,
                   "Study",
                   unknown.empty() ? ""
                                   : "<Study/Quantities>: no member's ledger "
                                     "has the column " +
                                       unknown,
                   "correct the name and start the study again: members are "
                   "not run again for that.");
  }
} // namespace emmy
