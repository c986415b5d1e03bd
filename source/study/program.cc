#include <deal.II/base/mpi.h>

#include <emmy/base/exceptions.h>
#include <emmy/run/catalogue.h>
#include <emmy/run/interrupt.h>
#include <emmy/run/restart.h>
#include <emmy/run/run.h>
#include <emmy/run/scene_parameters.h>
#include <emmy/study/command_line.h>
#include <emmy/study/program.h>
#include <emmy/study/study.h>
#include <emmy/study/study_parameters.h>
#include <emmy/study/verify.h>

#include <cstdlib>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>

namespace emmy
{
  namespace
  {
    /** @param saved null: the run begins */
    template <int dim>
    RunEnd
    perform(const CommandLine   &line,
            const ParameterFile &file,
            const SavedRun      *saved,
            const SignalWatch   *signals,
            const bool           is_first)
    {
      if (line.task == CommandLine::Task::print_parameters)
        {
          const SceneParameters<dim> parameters(file);
          std::ostringstream         text; // deal.II throws if it is full
          parameters.print(text);
          if (is_first && line.file.empty())
            std::cout << "# The reference of all parameters, shown in three "
                         "dimensions with\n# one section per material and "
                         "shape. Not a scene. Components of vectors,\n# "
                         "also formulas, are separated by , or ;.\n\n";
          if (is_first)
            std::cout << text.str();
          return RunEnd::complete;
        }
      RunOptions options;
      options.only_check  = line.task == CommandLine::Task::check;
      options.with_absent = line.all;
      options.with_step   = line.step;
      options.overwrite   = line.overwrite;
      options.signals     = signals;
      options.restart     = saved;
      options.new_loads   = line.new_loads;
      return run<dim>(file, options, MPI_COMM_WORLD);
    }

    /** Go on with a run from its last checkpoint. */
    RunEnd
    perform_restart(const CommandLine &line,
                    const SignalWatch *signals,
                    const bool         is_first)
    {
      std::string directory = line.restart;
      while (directory.size() > 1 && directory.back() == '/')
        directory.pop_back();
      const SavedRun saved =
        read_saved_run(directory, MPI_COMM_WORLD, "Restart");
      const ParameterFile file =
        parameters_to_go_on(saved, line.file, line.assignments);
      const unsigned int dim = dimension_of(file);
      AssertThrow(dim == saved.dimension,
                  ExcRun("Restart",
                         "the scene has " + std::to_string(dim) +
                           " dimensions, and the run in <" + directory +
                           "> has " + std::to_string(saved.dimension),
                         "go on with the scene of that run."));
      return dim == 2 ? perform<2>(line, file, &saved, signals, is_first)
                      : perform<3>(line, file, &saved, signals, is_first);
    }

    void
    perform_study(const CommandLine   &line,
                  const ParameterFile &file,
                  const bool           is_first)
    {
      if (line.task != CommandLine::Task::print_parameters)
        {
          const StudyPlan plan = read_study(file, line.file);
          if (line.task == CommandLine::Task::check)
            check_study(plan, MPI_COMM_WORLD);
          else if (line.tolerance > 0.)
            answer_study(plan, line.tolerance, MPI_COMM_WORLD);
          else
            run_study(plan, line.overwrite, MPI_COMM_WORLD);
        }
      else if (is_first)
        {
          std::ostringstream text; // as above
          print_study_parameters(file, text);
          std::cout << text.str();
        }
    }

    /** Of scenes in three dimensions, or of studies. */
    void
    print_topic(const CommandLine &line, std::ostream &out)
    {
      std::ostringstream listing;
      if (line.is_study)
        print_study_parameters(reference_study(), listing);
      else
        SceneParameters<3>(reference_file()).print(listing);
      const std::string parameters = parameters_on(line.topic, listing.str());
      print_catalogue(out, line.topic);
      out << parameters;
    }

    /** Says what the task asks for, if it asks for words alone. */
    bool
    tells(const CommandLine &line, const bool is_first)
    {
      std::ostringstream text;
      switch (line.task)
        {
          case CommandLine::Task::help:
            if (line.topic.empty())
              print_help(text);
            else
              print_topic(line, text);
            break;
          case CommandLine::Task::version:
            text << "emmy " EMMY_VERSION "\n";
            break;
          case CommandLine::Task::list:
            print_catalogue(text);
            break;
          case CommandLine::Task::completion:
            print_completion(text);
            break;
          default:
            return false;
        }
      if (is_first)
        std::cout << text.str();
      return true;
    }

    RunEnd
    perform(const CommandLine            &line,
            std::unique_ptr<SignalWatch> &watch,
            const bool                    is_first)
    {
      if (line.is_study || line.task != CommandLine::Task::run)
        {
          const int signal = watch->received();
          watch.reset(); // others end at once
          if (signal != 0)
            std::raise(signal);
        }
      const SignalWatch *const signals = watch.get();

      if (tells(line, is_first))
        return RunEnd::complete;
      if (line.task == CommandLine::Task::verify ||
          line.task == CommandLine::Task::verify_full)
        return verify(line.task == CommandLine::Task::verify_full,
                      MPI_COMM_WORLD)
                 ? RunEnd::complete
                 : RunEnd::refuted;
      if (!line.restart.empty())
        return perform_restart(line, signals, is_first);
      ParameterFile file = !line.file.empty() ? ParameterFile(line.file)
                           : line.is_study    ? reference_study()
                                              : reference_file();
      for (const std::string &assignment : line.assignments)
        file.set(assignment);
      if (line.is_study)
        {
          perform_study(line, file, is_first);
          return RunEnd::complete;
        }
      AssertThrow(!file.has_section("Study"),
                  ExcRun("Section Study",
                         "<" + line.file + "> describes a study, not a scene",
                         "run it with emmy study " + line.file + "."));
      return dimension_of(file) == 2
               ? perform<2>(line, file, nullptr, signals, is_first)
               : perform<3>(line, file, nullptr, signals, is_first);
    }
  } // namespace

  int
  run_program(int argc, char *argv[])
  {
    auto watch = std::make_unique<SignalWatch>(); // starting takes seconds
    // one process without mpirun: Open MPI starts no daemon for it, 0.2 s
    setenv("OMPI_MCA_ess_singleton_isolated", "1", /*overwrite=*/0);
    dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
    watch->renew();
    const bool is_first =
      dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0;

    // Errors of ours are raised on all ranks together; the first speaks.
    const auto report = [is_first](const dealii::ExceptionBase &error) {
      if (is_first)
        {
          std::cout << std::flush;
          std::cerr << "\nemmy: error: " << message_of(error) << std::endl;
        }
      return 1;
    };
    RunEnd end = RunEnd::complete;
    try
      {
        end =
          perform(parse_command_line({argv + 1, argv + argc}), watch, is_first);
      }
    catch (const ExcParameter &error)
      {
        return report(error);
      }
    catch (const ExcRun &error)
      {
        return report(error);
      }
    catch (const std::exception &error)
      {
        std::cerr << "\nemmy: unexpected error:\n" << error.what() << std::endl;
        // other ranks may wait for this one
        MPI_Abort(MPI_COMM_WORLD, 1);
      }
    catch (...) // Epetra throws numbers
      {
        std::cerr << "\nemmy: unexpected error of an unknown kind" << std::endl;
        MPI_Abort(MPI_COMM_WORLD, 1);
      }
    if (!std::cout.flush())
      {
        std::cerr << "\nemmy: error: Screen: not all that emmy said could be "
                     "written to the standard output\n  Remedy: if it goes to "
                     "a file, check that the disk is not full. Results in "
                     "files are whole."
                  << std::endl;
        return 1;
      }
    return end == RunEnd::interrupted ? interrupted_exit_code
           : end == RunEnd::refuted   ? 1
                                      : 0;
  }
} // namespace emmy
