#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/base/whole_file.h>
#include <emmy/study/study.h>
#include <emmy/study/study_html.h>
#include <emmy/study/study_page.h>
#include <emmy/study/study_pictures.h>
#include <emmy/study/study_runner.h>
#include <emmy/study/study_table.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>

namespace emmy
{
  namespace
  {
    namespace fs = std::filesystem;

    /**
     * Throws if the folder belongs to another study, else marks it as that of
     * this one. Rank 0 looks. Collective.
     */
    void
    claim_folder(const StudyPlan &plan,
                 const bool       overwrite,
                 const MPI_Comm   communicator)
    {
      std::string problem;
      if (dealii::Utilities::MPI::this_mpi_process(communicator) == 0)
        {
          const std::string name =
            fs::absolute(plan.file).lexically_normal().string();
          const std::string mark  = plan.directory + "/study.txt";
          std::string       owner = name;
          std::ifstream     there(mark);
          if (there && !overwrite)
            std::getline(there, owner);
          if (owner.empty()) // a full disk left it so
            owner = name;
          std::error_code ignored; // then the file cannot be opened
          fs::create_directories(plan.directory, ignored);
          if (owner != name)
            problem = "<" + plan.directory + "> has the results of study <" +
                      owner + ">";
          else
            problem = write_whole_file(mark, name + "\n");
        }
      throw_together(communicator,
                     "<Study/Directory>",
                     problem,
                     "give each study a folder that it may write to; "
                     "--overwrite replaces the results of another study.");
    }

    /** Run @p work on rank 0; what goes wrong is raised on all ranks. */
    void
    on_first_rank(const std::function<void()> &work,
                  const MPI_Comm               communicator)
    {
      throw_together(communicator,
                     "Study",
                     dealii::Utilities::MPI::this_mpi_process(communicator) == 0
                       ? failure_of(work, /*is_alone=*/true)
                       : std::string(),
                     "members that are done are kept: start the study again.");
    }

    /** The page and its pictures. For rank 0. */
    void
    write_report(const StudyPlan  &plan,
                 const StudyTable &table,
                 std::ostream     &screen)
    {
      const std::string  page = plan.directory + "/study.md";
      std::ostringstream text;
      write_study_page(text, plan, table);
      const std::string problem = write_whole_file(page, text.str());
      AssertThrow(problem.empty(), ExcRun("Study", problem, file_remedy));
      for (const std::string &warning : draw_study(plan, table))
        screen << "note: " << warning << '\n';
      const std::string html = plan.directory + "/report.html";
      const std::string html_problem =
        write_whole_file(html, study_as_html(text.str(), plan.directory));
      AssertThrow(html_problem.empty(),
                  ExcRun("Study", html_problem, file_remedy));
      screen << "page with pictures in " << page << ", for a browser in "
             << html << '\n';
    }

    /** Errors that only the results show. Collective. */
    void
    require_results(const StudyTable &table, const MPI_Comm communicator)
    {
      const bool is_first =
        dealii::Utilities::MPI::this_mpi_process(communicator) == 0;
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
  } // namespace

  void
  run_study(const StudyPlan &plan,
            const bool       overwrite,
            const MPI_Comm   communicator)
  {
    require_readable_members(plan);
    StudyTable table(plan);
    claim_folder(plan, overwrite, communicator);
    const bool is_first =
      dealii::Utilities::MPI::this_mpi_process(communicator) == 0;
    std::ostream      nowhere(nullptr);
    std::ostream     &screen    = is_first ? std::cout : nowhere;
    const std::size_t n_members = plan.members.size();
    const std::string csv       = plan.directory + "/study.csv";
    screen << "emmy " EMMY_VERSION ": study of " << n_members << " members, "
           << plan.repetitions << " run" << (plan.repetitions > 1 ? "s" : "")
           << " each, in " << plan.directory << '\n';

    StudyRunner  runner(plan, overwrite, communicator);
    unsigned int n_run = 0;
    for (unsigned int m = 0; m < n_members; ++m)
      {
        const StudyMember &member = plan.members[m];
        screen << member.name << " of " << n_members << ": "
               << plan.setting(member) << std::flush;
        const std::string failure = runner.run_member(member);
        n_run += runner.has_run;
        on_first_rank(
          [&] {
            if (failure.empty())
              table.add_done(m);
            else
              table.add_failed(m, failure);
            table.find_limits();
            table.write_csv(csv);
          },
          communicator);
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
    require_results(table, communicator);
    on_first_rank([&] { write_report(plan, table, screen); }, communicator);
  }

  void
  check_study(const StudyPlan &plan, const MPI_Comm communicator)
  {
    const bool is_first =
      dealii::Utilities::MPI::this_mpi_process(communicator) == 0;
    const StudyTable   table(plan); // names of columns
    std::ostringstream text;
    unsigned int       n_problems = 0;
    for (const StudyMember &member : plan.members)
      {
        const std::string problem = reading_problem(plan, member);
        n_problems += !problem.empty();
        text << member.name << ": " << plan.setting(member)
             << (problem.empty() ? "" : "\n  CANNOT BE READ: " + problem)
             << '\n';
      }
    if (is_first)
      std::cout << text.str();
    throw_together(communicator,
                   "Study",
                   n_problems == 0
                     ? ""
                     : std::to_string(n_problems) + " members cannot be read",
                   "see above; correct <Entries> or <Values> of its lists, or "
                   "its base scene.");
  }

  void
  answer_study(const StudyPlan &plan,
               const double     tolerance,
               const MPI_Comm   communicator)
  {
    require_readable_members(plan);
    const bool is_first =
      dealii::Utilities::MPI::this_mpi_process(communicator) == 0;
    StudyTable   table(plan);
    StudyRunner  runner(plan, /*overwrite=*/false, communicator);
    unsigned int n_there = 0;
    for (unsigned int m = 0; m < plan.members.size(); ++m)
      {
        std::string failure;
        if (!runner.look_up(plan.members[m], failure))
          continue;
        ++n_there;
        on_first_rank(
          [&] {
            if (failure.empty())
              table.add_done(m);
            else
              table.add_failed(m, failure);
          },
          communicator);
      }
    throw_together(communicator,
                   "Study",
                   n_there == 0 ? "none of its members has run with these "
                                  "parameters on this number of ranks"
                                : "",
                   "start the study, without --tolerance.");
    require_results(table, communicator);
    std::string problem;
    if (is_first)
      {
        table.find_limits();
        if (n_there < plan.members.size())
          std::cout << "only " << n_there << " of " << plan.members.size()
                    << " members have run: start the study to have all\n";
        if (!print_cheapest(std::cout, plan, table, tolerance))
          problem = "no member meets " + shortest(tolerance) +
                    " in each of the quantities";
      }
    throw_together(communicator,
                   "Study",
                   problem,
                   "add finer members to its lists, or ask for less.");
  }
} // namespace emmy
