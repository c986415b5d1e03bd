#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/base/whole_file.h>
#include <emmy/output/ledger.h>
#include <emmy/output/progress.h>
#include <emmy/output/run_directory.h>
#include <emmy/run/checkpoints.h>
#include <emmy/run/failure_bundle.h>
#include <emmy/run/frames.h>
#include <emmy/run/price.h>
#include <emmy/run/restart.h>
#include <emmy/run/run.h>
#include <emmy/run/scene_card.h>

#include <unistd.h>

#include <algorithm>
#include <exception>
#include <fstream>
#include <functional>
#include <iostream>
#include <sstream>

namespace emmy
{
  namespace
  {
    /** What stands in the file but has no effect. */
    template <int dim>
    void
    list_unused(const ParameterFile        &file,
                const SceneParameters<dim> &parameters,
                std::ostream               &out)
    {
      const auto &named = parameters.effect_names.names;
      for (const std::string &effect : effect_library<dim>().names())
        if (file.has_section(effect_section(effect)) &&
            std::find(named.begin(), named.end(), effect) == named.end())
          out << "  note: section " << effect_section(effect)
              << " is not used, because Effects/Names does not list <" << effect
              << ">\n";
      const std::string &rule = parameters.time.step_rule;
      if (rule != "fixed" && !file.value("Time/Step size", "").empty())
        out << "  note: Time/Step size is not used, because Time/Step rule is <"
            << rule << ">; set Step rule = fixed, or remove it\n";
    }

    /** A line if the last step went beyond the end time; or nothing. */
    void
    tell_of_overshoot(const TimeParameters &limits,
                      const double          time,
                      std::ostream         &out)
    {
      if (time > limits.end_time * (1. + 1e-9))
        out << "note: the run ended at t = " << time << " s, "
            << time - limits.end_time
            << " s after End time, as Time/Shorten last step is false\n";
    }

    /** What is known of a run on the way. */
    struct Course
    {
      StepReport report;              ///< of the last accepted step
      double     largest_energy = 0.; ///< of all steps, J
      RunCounts  counts;
      bool       makes_step = false; ///< still true: a step failed
      /** Of the ledger and the log on this rank; empty: none. */
      std::function<std::string()> file_problem;
    };

    /**
     * The work that solves left, J: its sum, and a line if that may matter.
     * The magnitudes of all steps are added, so that none hides another: a
     * step may leave a rest that does not matter alone.
     */
    void
    tell_of_residuals(std::ostream &out,
                      const Ledger &ledger,
                      const double  energy)
    {
      constexpr double matters = 1e-8; // of the energy
      const auto      &names   = ledger.columns();
      const auto       column =
        std::find(names.begin(), names.end(), "residual_work") - names.begin();
      double all = 0.;
      for (unsigned int row = 1; row < ledger.rows().size(); ++row)
        all +=
          std::abs(ledger.rows()[row][column] - ledger.rows()[row - 1][column]);
      out << "work of residuals " << ledger["residual_work"]
          << " J, of all steps without their signs " << all << " J\n";
      if (!(all <= matters * energy))
        out << "note: that is "
            << (energy > 0. ? brief(all / energy) + " of the largest energy"
                            : "all energy that there was")
            << ", more than " << matters
            << ": what the solves left may matter. Lower Solver/Newton "
               "tolerance and Linear tolerance, or shorten the steps that "
               "run.log names\n";
    }

    /** The closing lines of a run: what was conserved, and how well. */
    void
    summarise(std::ostream     &out,
              const Ledger     &ledger,
              const StepReport &initial,
              const Course     &course,
              const Struggles  &struggles)
    {
      double smallest = 0., largest = 0.;
      for (unsigned int row = 1; row < ledger.rows().size(); ++row)
        {
          const double dt = ledger.rows()[row][2];
          smallest        = row == 1 ? dt : std::min(smallest, dt);
          largest         = std::max(largest, dt);
        }
      out << "steps " << ledger["step"] << ", t = " << ledger["time"]
          << " s, time step " << smallest << " to " << largest << " s\n"
          << "kinetic + stored energy " << ledger.total_energy()
          << " J, at the start " << initial.totals.kinetic_energy << " J\n";
      tell_of_residuals(out, ledger, course.largest_energy);
      out << "balance error " << ledger["balance_error"] << " J";
      if (course.largest_energy > 0.)
        out << ", " << std::abs(ledger["balance_error"]) / course.largest_energy
            << " of the largest energy";
      out << '\n';
      const auto &names = ledger.columns();
      for (const auto &[column, matrix] :
           {std::make_pair("mass_condition", "mass matrix"),
            std::make_pair("jacobian_condition", "Jacobian")})
        {
          const auto name =
            std::find(names.begin(), names.end(), column) - names.begin();
          if (name == static_cast<std::ptrdiff_t>(names.size()))
            continue;
          const auto &worst =
            *std::max_element(ledger.rows().begin(),
                              ledger.rows().end(),
                              [name](const auto &a, const auto &b) {
                                return a[name] < b[name];
                              });
          out << "largest condition of the scaled " << matrix << ' '
              << worst[name] << ", at step " << worst[0] << '\n';
        }
      if (struggles.halvings > 0)
        out << "times a step was halved: " << struggles.halvings
            << " (named in run.log)\n";
      if (struggles.damped > 0)
        out << "steps that needed a damped Newton matrix: " << struggles.damped
            << " (named in run.log)\n";
    }

    /** Whether a run with these limits has made its last step. */
    bool
    is_at_end(const StepReport &last, const TimeParameters &limits)
    {
      // a step that ends within round-off of the end time is the last
      return last.time >= limits.end_time * (1. - 1e-12) ||
             (limits.maximum_steps > 0 && last.step >= limits.maximum_steps);
    }

    /**
     * Step after step until the limits are met, or a signal comes. @p course
     * is right also when this throws. Collective.
     */
    template <int dim>
    void
    advance_to_end(Scene<dim>           &scene,
                   const TimeParameters &limits,
                   Ledger               &ledger,
                   Frames<dim>          &frames,
                   Checkpoints<dim>     &checkpoints,
                   Progress             &progress,
                   Course               &course)
    {
      StepReport &report = course.report;
      while (!is_at_end(report, limits) && !checkpoints.is_interrupted())
        {
          course.makes_step = true;
          report            = scene.advance();
          course.makes_step = false;
          for (const std::string &note : report.notes)
            progress.note(note);
          for (const std::string &finding : report.findings)
            progress.record(finding);
          ledger.add(report);
          throw_together(scene.grid.communicator(),
                         "Output",
                         course.file_problem(),
                         file_remedy + " What was written so far is kept.");
          frames.after(report);
          if (is_at_end(report, limits)) // so that the checkpoint has it
            frames.at_end(report);
          course.largest_energy =
            std::max(course.largest_energy, ledger.total_energy());
          ++course.counts.steps;
          course.counts.halvings += report.halvings;
          course.counts.damped += report.is_damped;
          scene.state.struggles.halvings += report.halvings;
          scene.state.struggles.damped += report.is_damped;
          progress.step(report.step,
                        report.time,
                        report.time_step,
                        report.newton_iterations,
                        course.largest_energy > 0.
                          ? ledger["balance_error"] / course.largest_energy
                          : 0.);
          if (const std::string problem = checkpoints.after_step();
              !problem.empty())
            progress.note(problem);
        }
    }
    /** The bundle of a failed step, and a line that says so. Collective. */
    template <int dim>
    std::string
    leave_failure_bundle(Scene<dim>                 &scene,
                         const SceneParameters<dim> &parameters,
                         const RunDirectory         &directory,
                         const std::exception_ptr   &failure)
    {
      std::string cause;
      try
        {
          std::rethrow_exception(failure);
        }
      catch (const ExcRun &error)
        {
          cause = message_of(error);
        }
      const std::string problem =
        write_failure_bundle(scene, text_of(parameters), directory, cause);
      const std::string folder = directory.file("failure");
      return problem.empty()
               ? "what is known of the failed step is in " + folder +
                   "; it is repeated with: emmy --restart " + folder
               : "what is known of the failed step could not be written: " +
                   problem;
    }
  } // namespace

  template <int dim>
  RunEnd
  run(const ParameterFile &file,
      const RunOptions    &options,
      const MPI_Comm       communicator)
  {
    const bool is_first =
      dealii::Utilities::MPI::this_mpi_process(communicator) == 0;
    // mpirun shows a pseudo-terminal even when it writes to a file
    const unsigned int n_ranks =
      dealii::Utilities::MPI::n_mpi_processes(communicator);
    // swallows everything, for all ranks but the first
    std::ostream  nowhere(nullptr);
    std::ostream &screen = is_first && !options.is_quiet ? std::cout : nowhere;

    const SceneParameters<dim> parameters(file);
    parameters.output.validate();
    parameters.start.validate(parameters.output.directory);
    parameters.solver.validate(); // not only when the first step needs it
    const SavedRun *const          saved = options.restart;
    const std::vector<std::string> changes =
      saved ? changes_to_go_on(*saved, text_of(parameters), options.new_loads)
            : std::vector<std::string>();
    Scene<dim>       scene(parameters, communicator);
    const StepReport initial = scene.initial_report();
    Ledger           ledger(initial, dim, &scene.state.ledger);
    const SceneCard  card = [&] {
      const auto timed = scene.phases.scope("scene card");
      return make_card(scene, parameters, options.with_absent);
    }();

    if (options.only_check)
      {
        scene.describe(screen, initial, card, options.with_absent);
        list_unused(file, parameters, screen);
        return RunEnd::complete;
      }

    const RunDirectory directory =
      saved ? RunDirectory::of_run(parameters.output.directory, communicator)
            : RunDirectory(parameters.output.directory,
                           options.overwrite || parameters.output.overwrite,
                           communicator);
    if (saved)
      go_on(*saved, directory, scene, ledger);
    else if (!scene.started.path.empty())
      keep_start(scene.started, directory, communicator);
    const std::string log_name = directory.file("run.log");
    // not open, and so mute, on all ranks but the first
    std::ofstream log;
    std::string   file_problem;
    if (is_first)
      {
        log.open(log_name, saved ? std::ios::app : std::ios::out);
        file_problem = write_whole_file(directory.file("parameters.prm"),
                                        text_of(parameters));
      }

    std::ostringstream head;
    head << "emmy " EMMY_VERSION ": " << directory.path() << '\n';
    if (saved)
      describe_restart(*saved, changes, n_ranks, head);
    else
      {
        scene.describe(head, initial, card, options.with_absent);
        list_unused(file, parameters, head);
      }
    screen << head.str() << std::flush;
    log << head.str() << std::flush;

    if (is_first && !saved)
      ledger.write_to(directory.file("ledger.csv"));
    Course course{initial, ledger.largest_energy(), {}, false, [&] {
                    return is_first && !log ? cannot_write(log_name)
                                            : ledger.problem();
                  }};
    throw_together(communicator,
                   "Output",
                   file_problem.empty() ? course.file_problem() : file_problem,
                   file_remedy);
    course.report.step = scene.state.step;
    course.report.time = scene.state.time;
    Frames<dim> frames(scene, parameters, directory);
    if (saved)
      frames.go_on(is_at_end(course.report, parameters.time));
    else
      frames.initial();
    Checkpoints<dim> checkpoints(
      scene, parameters, ledger, directory.path(), options.signals);
    Progress progress(screen,
                      is_first && !options.is_quiet && isatty(STDOUT_FILENO) &&
                        n_ranks == 1,
                      log,
                      parameters.time.end_time,
                      parameters.time.maximum_steps);

    if (is_first)
      scene.phases.set_listener(
        [&progress](const std::string &news) { progress.working(news); });

    // What goes wrong on the way is reported after the results so far. All
    // ranks throw it together; any other error passes, as one rank alone can
    // not finish the output. The first failure counts: a full disk has many.
    std::exception_ptr failure;
    const auto         attempt = [&](const std::function<void()> &work) {
      try
        {
          work();
        }
      catch (const ExcRun &error)
        {
          log << "stopped: " << message_of(error) << std::endl;
          if (failure)
            screen << "note: " << message_of(error) << std::endl;
          else
            failure = std::current_exception();
        }
    };
    attempt([&] {
      advance_to_end(
        scene, parameters.time, ledger, frames, checkpoints, progress, course);
    });
    scene.phases.set_listener(nullptr);
    progress.finish();
    const bool is_interrupted = checkpoints.is_interrupted() && !failure &&
                                !is_at_end(course.report, parameters.time);
    if (course.makes_step && failure && !(saved && saved->is_failure))
      progress.note(
        leave_failure_bundle(scene, parameters, directory, failure));
    if (!is_interrupted)
      if (const std::string problem = checkpoints.at_end(); !problem.empty())
        progress.note(problem);
    if (!is_interrupted) // the last frame and the pictures are still to come
      attempt([&] {
        for (const std::string &warning :
             frames.finish(course.report, /*is_complete=*/!failure))
          progress.note(warning);
      });

    std::ostringstream tail;
    tail << "linear solver " << scene.stepper->solver_name() << '\n';
    tell_of_overshoot(parameters.time, course.report.time, tail);
    summarise(tail, ledger, initial, course, scene.state.struggles);
    std::vector<EffectCard> present;
    for (const CountedEffect &effect : card.effects)
      if (effect.card.is_present)
        present.push_back(effect.card);
    const Price price(scene.phases, present, communicator);
    price.print(tail, ledger);
    screen << tail.str() << std::flush;
    log << tail.str() << std::flush;
    attempt([&] {
      price.write_json(directory.file("timing.json"), ledger, course.counts);
    });
    attempt([&] {
      throw_together(communicator,
                     "Output",
                     course.file_problem(),
                     file_remedy);
    });
    if (failure)
      std::rethrow_exception(failure);
    if (is_interrupted)
      {
        log << checkpoints.farewell() << std::endl;
        AssertThrow(checkpoints.is_there(),
                    ExcRun("Interrupted", checkpoints.farewell(), file_remedy));
        screen << checkpoints.farewell() << '\n';
        return RunEnd::interrupted;
      }
    screen << "results in " << directory.path() << '\n';
    return RunEnd::complete;
  }

  template RunEnd
  run<2>(const ParameterFile &, const RunOptions &, const MPI_Comm);
  template RunEnd
  run<3>(const ParameterFile &, const RunOptions &, const MPI_Comm);
} // namespace emmy
