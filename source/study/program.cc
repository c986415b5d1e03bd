#include <deal.II/base/mpi.h>

#include <emmy/base/exceptions.h>
#include <emmy/study/catalogue.h>
#include <emmy/study/program.h>
#include <emmy/study/run.h>
#include <emmy/study/scene_parameters.h>
#include <emmy/study/study.h>
#include <emmy/study/study_parameters.h>

#include <iostream>
#include <sstream>
#include <string>
#include <vector>

namespace emmy
{
  namespace
  {
    constexpr const char *help =
      R"(emmy: implicit, energy- and momentum-conserving material point method

  emmy FILE.prm [options]          run the scene of a parameter file
  emmy study FILE.prm [options]    run the study of a parameter file: a scene
                                   with many settings, compared in study.csv
                                   and on a page with pictures
  emmy --check FILE.prm            read it, build the scene, say what each part
                                   will cost; run nothing
  emmy study --check FILE.prm      read all members of a study; run nothing
  emmy --check --all FILE.prm      and what each absent effect would cost
  emmy --list                      the effects, materials, shapes, shape
                                   functions and solvers that there are
  emmy --print-parameters          all parameters there are, with units
  emmy --print-parameters FILE.prm all parameters of that file as it sets them
  emmy study --print-parameters    all parameters of a study
  emmy --version | --help

options
  --set "Section/Name=value"       override an entry; may be repeated
  --tolerance NUMBER               of a study: the cheapest of its members that
                                   have run with errors of at most this; run
                                   nothing
  --all                            of a run: say at its head what each absent
                                   effect would cost too
  --overwrite                      replace the results of an earlier run; run
                                   all members of a study again

In parallel: mpirun -np 2 emmy FILE.prm
)";

    struct CommandLine
    {
      enum class Task
      {
        run,
        check,
        list,
        print_parameters,
        version,
        help
      } task = Task::run;
      std::string              file;
      std::vector<std::string> assignments;
      bool                     overwrite = false, all = false;
      double                   tolerance = 0.; ///< 0: not asked for
      bool                     is_study  = false;
    };

    CommandLine
    parse(const std::vector<std::string> &words)
    {
      const auto refuse = [](const std::string &what,
                             const std::string &remedy) {
        AssertThrow(false, ExcRun("Command line", what, remedy));
      };
      CommandLine line;
      for (auto word = words.begin(); word != words.end(); ++word)
        if (*word == "study" && word == words.begin())
          line.is_study = true;
        else if (*word == "--help" || *word == "-h")
          line.task = CommandLine::Task::help;
        else if (*word == "--version")
          line.task = CommandLine::Task::version;
        else if (*word == "--print-parameters")
          line.task = CommandLine::Task::print_parameters;
        else if (*word == "--check")
          line.task = CommandLine::Task::check;
        else if (*word == "--list")
          line.task = CommandLine::Task::list;
        else if (*word == "--all")
          line.all = true;
        else if (*word == "--overwrite")
          line.overwrite = true;
        else if (*word == "--set")
          {
            if (word + 1 == words.end())
              refuse("--set has no value",
                     "write --set \"Section/Name=value\".");
            line.assignments.push_back(*++word);
          }
        else if (*word == "--tolerance")
          {
            const std::string number = word + 1 == words.end() ? "" : *++word;
            char             *end    = nullptr;
            line.tolerance           = std::strtod(number.c_str(), &end);
            if (*end != '\0' || !(line.tolerance > 0.))
              refuse("--tolerance <" + number + ">",
                     "write a positive number behind it, e.g. --tolerance "
                     "1e-3.");
          }
        else if (word->substr(0, 1) == "-")
          refuse("unknown option <" + *word + ">", "emmy --help lists them.");
        else if (!line.file.empty())
          refuse("two parameter files, <" + line.file + "> and <" + *word + ">",
                 "give one; start emmy once per file.");
        else
          line.file = *word;
      if (line.is_study && line.task == CommandLine::Task::list)
        refuse("study with --list", "emmy --list alone lists what there is.");
      if (line.tolerance > 0. &&
          !(line.is_study && line.task == CommandLine::Task::run))
        refuse("--tolerance without a study",
               "write emmy study FILE.prm --tolerance 1e-3.");
      if (line.all &&
          (line.is_study || (line.task != CommandLine::Task::check &&
                             line.task != CommandLine::Task::run)))
        refuse("--all without a scene to check or run",
               "write emmy --check --all FILE.prm to see what the effects "
               "would cost that the scene does not have.");
      if (line.task == CommandLine::Task::list &&
          !(line.file.empty() && line.assignments.empty()))
        refuse("--list with <" + (line.file.empty() ? "--set" : line.file) +
                 ">",
               "give --list alone: it lists what there is for any file. emmy "
               "--check FILE.prm says what a file uses.");
      if (line.file.empty() && (line.task == CommandLine::Task::run ||
                                line.task == CommandLine::Task::check))
        refuse("no parameter file",
               "name one, e.g. emmy prm/paper/7.2.prm; emmy --help says more.");
      return line;
    }

    template <int dim>
    void
    perform(const CommandLine   &line,
            const ParameterFile &file,
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
        }
      else
        {
          RunOptions options;
          options.only_check  = line.task == CommandLine::Task::check;
          options.with_absent = line.all;
          options.overwrite   = line.overwrite;
          run<dim>(file, options, MPI_COMM_WORLD);
        }
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

    void
    perform(const CommandLine &line, const bool is_first)
    {
      using Task = CommandLine::Task;
      if (line.task == Task::help || line.task == Task::version)
        {
          if (is_first)
            std::cout << (line.task == Task::help ? help
                                                  : "emmy " EMMY_VERSION "\n");
          return;
        }
      if (line.task == Task::list)
        {
          if (is_first)
            print_catalogue(std::cout);
          return;
        }
      ParameterFile file = !line.file.empty() ? ParameterFile(line.file)
                           : line.is_study    ? reference_study()
                                              : reference_file();
      for (const std::string &assignment : line.assignments)
        file.set(assignment);
      if (line.is_study)
        {
          perform_study(line, file, is_first);
          return;
        }
      AssertThrow(!file.has_section("Study"),
                  ExcRun("Section Study",
                         "<" + line.file + "> describes a study, not a scene",
                         "run it with emmy study " + line.file + "."));
      if (dimension_of(file) == 2)
        perform<2>(line, file, is_first);
      else
        perform<3>(line, file, is_first);
    }
  } // namespace

  int
  run_program(int argc, char *argv[])
  {
    dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
    const bool                               is_first =
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
    try
      {
        perform(parse({argv + 1, argv + argc}), is_first);
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
    return 0;
  }
} // namespace emmy
