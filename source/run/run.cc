#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/base/whole_file.h>
#include <emmy/output/ledger.h>
#include <emmy/output/progress.h>
#include <emmy/output/report_page.h>
#include <emmy/output/run_directory.h>
#include <emmy/run/checkpoints.h>
#include <emmy/run/closing_lines.h>
#include <emmy/run/failure_bundle.h>
#include <emmy/run/frames.h>
#include <emmy/run/price.h>
#include <emmy/run/restart.h>
#include <emmy/run/run.h>
#include <emmy/run/scene_advice.h>
#include <emmy/run/scene_card.h>
#include <emmy/run/scene_memory.h>

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

    /** Whether a run with these limits has made its last step. */
    bool
    is_at_end(const StepReport &last, const TimeParameters &limits)
    {
      // a step that ends within round-off of the end time is the last
      return last.time >= limits.end_time * (1. - 1e-12) ||
             (limits.maximum_steps > 0 && last.step >= limits.maximum_steps);
    }

    /** What a run that is at its end needs to go on. */
    std::string
    way_to_go_on(const TimeParameters &limits, const StepReport &last)
    {
      const bool is_by_time = last.time >= limits.end_time * (1. - 1e-12);
      return is_by_time ? "t = " + brief(last.time) +
                            " s is its end; to go on raise it: "
                            "--set \"Time/End time=" +
                            brief(2. * limits.end_time) + "\""
                        : "step " + std::to_string(last.step) +
                            " is its last; to go on "
                            "raise it: --set \"Time/Maximum steps=" +
                            std::to_string(2 * limits.maximum_steps) + "\"";
    }

    /**
     * Does the parts of a run one after the other. What goes wrong on the way
     * is reported after the results so far: all ranks throw it together; any
     * other error passes, as one rank alone can not finish the output. The
     * first failure counts: a full disk has many.
     */
    class Attempts
    {
    public:
      Attempts(std::ostream &screen, std::ostream &log)
        : screen(screen)
        , log(log)
      {}

      void
      operator()(const std::function<void()> &work)
      {
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
      }

      /** Null: none. */
      std::exception_ptr failure;

    private:
      std::ostream &screen, &log;
    };

    /** What a run works with and on. */
    template <int dim>
    struct Parts
    {
      Scene<dim>                 &scene;
      const SceneParameters<dim> &parameters;
      const RunDirectory         &directory;
      Ledger                     &ledger;
      Frames<dim>                &frames;
      Checkpoints<dim>           &checkpoints;
      Progress                   &progress;
      Course                     &course;
    };

    /**
     * Step after step until the limits are met, or a signal comes. The course
     * is right also when this throws. Collective.
     */
    template <int dim>
    void
    advance_to_end(const Parts<dim> &parts)
    {
      Scene<dim>           &scene  = parts.scene;
      Course               &course = parts.course;
      StepReport           &report = course.report;
      const TimeParameters &limits = parts.parameters.time;
      while (!is_at_end(report, limits) && !parts.checkpoints.is_interrupted())
        {
          course.makes_step = true;
          report            = scene.advance();
          course.makes_step = false;
          for (const std::string &note : report.notes)
            parts.progress.note(note);
          for (const std::string &finding : report.findings)
            parts.progress.record(finding);
          parts.ledger.add(report);
          throw_together(scene.grid.communicator(),
                         "Output",
                         course.file_problem(),
                         file_remedy + " What was written so far is kept.");
          parts.frames.after(report);
          if (is_at_end(report, limits)) // so that the checkpoint has it
            parts.frames.at_end(report);
          course.largest_energy =
            std::max(course.largest_energy, parts.ledger.total_energy());
          ++course.counts.steps;
          course.counts.rebalancings = scene.rank_balance.n_times();
          course.counts.halvings += report.halvings;
          course.counts.damped += report.is_damped;
          scene.state.struggles.halvings += report.halvings;
          scene.state.struggles.damped += report.is_damped;
          parts.progress.step(report.step,
                              report.time,
                              report.time_step,
                              report.newton_iterations,
                              course.largest_energy > 0.
                                ? parts.ledger["balance_error"] /
                                    course.largest_energy
                                : 0.);
          if (const std::string problem = parts.checkpoints.after_step();
              !problem.empty())
            parts.progress.note(problem);
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

    /**
     * What a run that ended leaves: the bundle of a failed step, the last
     * checkpoint, the last frame and the pictures. Collective.
     */
    template <int dim>
    void
    finish_files(const Parts<dim> &parts,
                 const bool        is_repeated_failure,
                 const bool        is_interrupted,
                 Attempts         &attempt)
    {
      const bool has_failed = attempt.failure != nullptr;
      if (parts.course.makes_step && has_failed && !is_repeated_failure)
        parts.progress.note(leave_failure_bundle(
          parts.scene, parts.parameters, parts.directory, attempt.failure));
      if (is_interrupted) // the last frame and the pictures are still to come
        return;
      if (const std::string problem = parts.checkpoints.at_end();
          !problem.empty())
        parts.progress.note(problem);
      attempt([&] {
        for (const std::string &warning :
             parts.frames.finish(parts.course.report,
                                 /*is_complete=*/!has_failed))
          parts.progress.note(warning);
      });
    }

    /** The closing lines and timing.json. Collective. */
    template <int dim>
    std::string
    close(const Parts<dim> &parts, const SceneCard &card, Attempts &attempt)
    {
      Scene<dim>        &scene = parts.scene;
      std::ostringstream tail;
      tail << "linear solver " << scene.stepper->solver_name() << '\n';
      tell_of_overshoot(parts.parameters.time, parts.course.report.time, tail);
      summarise(tail,
                parts.ledger,
                parts.course.largest_energy,
                scene.state.struggles);
      std::vector<EffectCard> present;
      for (const CountedEffect &effect : card.effects)
        if (effect.card.is_present)
          present.push_back(effect.card);
      scene.rank_balance.print(tail, scene.state);
      const Price price(scene.phases, present, scene.grid.communicator());
      price.print(tail, parts.ledger);
      attempt([&] {
        price.write_json(parts.directory.file("timing.json"),
                         parts.ledger,
                         parts.course.counts);
      });
      return tail.str();
    }

    /** For the first rank. */
    template <int dim>
    void
    leave_report(const Parts<dim> &parts, std::ostream &screen)
    {
      const SceneParameters<dim> &parameters = parts.parameters;
      if (!parameters.output.report)
        return;
      const std::string folder  = parts.directory.path();
      const auto        n_ranks = dealii::Utilities::MPI::n_mpi_processes(
        parts.scene.grid.communicator());
      const std::string problem = write_report(
        folder,
        parts.ledger,
        {parameters.general.title.empty() ? folder : parameters.general.title,
         (n_ranks > 1 ? "mpirun -np " + std::to_string(n_ranks) + " " : "") +
           "emmy " + parts.directory.file("parameters.prm") + " --overwrite",
         parameters.measurement_names.names,
         parts.frames.film()});
      if (!problem.empty())
        screen << "note: " << problem << '\n';
    }

    /** From the first step to the last line. Collective. */
    template <int dim>
    RunEnd
    run_parts(const Parts<dim> &parts,
              const SceneCard  &card,
              const RunOptions &options,
              std::ostream     &screen,
              std::ostream     &log)
    {
      Phases                 &phases       = parts.scene.phases;
      const MPI_Comm          communicator = parts.scene.grid.communicator();
      const Checkpoints<dim> &checkpoints  = parts.checkpoints;
      if (dealii::Utilities::MPI::this_mpi_process(communicator) == 0)
        phases.set_listener(
          [&](const std::string &news) { parts.progress.working(news); });
      Attempts attempt(screen, log);
      attempt([&] { advance_to_end(parts); });
      phases.set_listener(nullptr);
      parts.progress.finish();
      const bool is_interrupted =
        checkpoints.is_interrupted() && !attempt.failure &&
        !is_at_end(parts.course.report, parts.parameters.time);
      finish_files(parts,
                   options.restart && options.restart->is_failure,
                   is_interrupted,
                   attempt);
      const std::string tail = close(parts, card, attempt);
      screen << tail << std::flush;
      log << tail << std::flush;
      if (is_interrupted) // the report says so too
        log << checkpoints.farewell() << std::endl;
      if (dealii::Utilities::MPI::this_mpi_process(communicator) == 0)
        leave_report(parts, screen);
      attempt([&] {
        throw_together(communicator,
                       "Output",
                       parts.course.file_problem(),
                       file_remedy);
      });
      if (attempt.failure)
        std::rethrow_exception(attempt.failure);
      if (is_interrupted)
        {
          AssertThrow(checkpoints.is_there(),
                      ExcRun("Interrupted",
                             checkpoints.farewell(),
                             file_remedy));
          screen << checkpoints.farewell() << '\n';
          return RunEnd::interrupted;
        }
      screen << "results in " << parts.directory.path() << '\n';
      return RunEnd::complete;
    }

    /** The folder of results, with what stands there before the first step. */
    template <int dim>
    RunDirectory
    begin_directory(const SceneParameters<dim> &parameters,
                    const RunOptions           &options,
                    Scene<dim>                 &scene,
                    Ledger                     &ledger)
    {
      const MPI_Comm     communicator = scene.grid.communicator();
      const std::string &path         = parameters.output.directory;
      const RunDirectory directory =
        options.restart
          ? RunDirectory::of_run(path, communicator)
          : RunDirectory(path,
                         options.overwrite || parameters.output.overwrite,
                         communicator);
      if (options.restart)
        go_on(*options.restart, directory, scene, ledger);
      else if (!scene.started.path.empty())
        keep_start(scene.started, directory, communicator);
      return directory;
    }

    /**
     * Opens the log, and writes parameters and the first row of the ledger.
     * For the first rank. @return what could not be written, or empty
     */
    std::string
    begin_files(const RunDirectory &directory,
                const std::string  &head,
                const std::string  &parameters,
                const bool          is_restart,
                std::ofstream      &log,
                Ledger             &ledger)
    {
      log.open(directory.file("run.log"),
               is_restart ? std::ios::app : std::ios::out);
      log << head << std::flush;
      const std::string problem =
        write_whole_file(directory.file("parameters.prm"), parameters);
      if (!is_restart)
        ledger.write_to(directory.file("ledger.csv"));
      return problem;
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
    const auto describe = [&](std::ostream &out) {
      scene.describe(out, initial, card, options.with_absent);
      list_unused(file, parameters, out);
    };
    if (options.only_check)
      {
        describe(screen);
        print_memory(predict_memory(scene, parameters, card.n_matrices),
                     screen);
        advise(scene, parameters, initial, screen);
        if (options.with_step)
          calibrate(scene, parameters, screen);
        return RunEnd::complete;
      }

    const RunDirectory directory =
      begin_directory(parameters, options, scene, ledger);
    std::ostringstream head;
    head << "emmy " EMMY_VERSION ": " << directory.path() << '\n';
    if (saved)
      describe_restart(*saved, changes, n_ranks, head);
    else
      describe(head);
    // not open, and so mute, on all ranks but the first
    std::ofstream     log;
    const std::string log_name = directory.file("run.log");
    Course            course{initial, ledger.largest_energy(), {}, false, [&] {
                    return is_first && !log ? cannot_write(log_name)
                                                       : ledger.problem();
                  }};
    std::string       file_problem;
    if (is_first)
      file_problem = begin_files(
        directory, head.str(), text_of(parameters), saved, log, ledger);
    screen << head.str() << std::flush;
    throw_together(communicator,
                   "Output",
                   file_problem.empty() ? course.file_problem() : file_problem,
                   file_remedy);
    course.report.step = scene.state.step;
    course.report.time = scene.state.time;
    const bool is_over = saved && is_at_end(course.report, parameters.time);
    if (is_over)
      screen << "  the run is finished: "
             << way_to_go_on(parameters.time, course.report) << std::endl;
    Frames<dim> frames(scene, parameters, directory);
    if (saved)
      frames.go_on(is_over);
    else
      frames.initial();
    Checkpoints<dim> checkpoints(
      scene, parameters, ledger, directory.path(), options.signals);
    // mpirun shows a pseudo-terminal even when it writes to a file
    Progress         progress(screen,
                      is_first && !options.is_quiet && isatty(STDOUT_FILENO) &&
                        n_ranks == 1,
                      log,
                      parameters.time.end_time,
                      parameters.time.maximum_steps);
    const Parts<dim> parts{scene,
                           parameters,
                           directory,
                           ledger,
                           frames,
                           checkpoints,
                           progress,
                           course};

    return run_parts(parts, card, options, screen, log);
  }

  template RunEnd
  run<2>(const ParameterFile &, const RunOptions &, const MPI_Comm);
  template RunEnd
  run<3>(const ParameterFile &, const RunOptions &, const MPI_Comm);
} // namespace emmy
