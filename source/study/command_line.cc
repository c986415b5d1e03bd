#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/study/command_line.h>

#include <boost/program_options.hpp>

#include <algorithm>
#include <cstdlib>
#include <ostream>

namespace emmy
{
  namespace
  {
    namespace po = boost::program_options;

    [[noreturn]] void
    refuse(const std::string &what, const std::string &remedy)
    {
      AssertThrow(false, ExcRun("Command line", what, remedy));
    }

    struct Options
    {
      po::options_description tasks{"instead of a run"}, of_runs{"options"},
        all;

      Options()
      {
        const auto text = [](const char *name) {
          return po::value<std::string>()->value_name(name);
        };
        tasks.add_options()(
          "check",
          "read the file, build the scene, say what each part will cost; of a "
          "study: read all its members")(
          "list",
          "the effects, materials, shapes, shape functions, measurements and "
          "solvers that there are")(
          "print-parameters",
          "all parameters with units: of FILE.prm as it sets them, or else all "
          "that there are")("version", "the version")(
          "help,h",
          text("[TOPIC]")->implicit_value("", ""),
          "this text; or what parameter files say of a section or an entry: "
          "--help effects, --help Effects/Gravity, --help \"step size\"");
        of_runs.add_options()(
          "set",
          text("Section/Name=value"),
          "override an entry; may be repeated, the last counts")(
          "tolerance",
          text("NUMBER"),
          "of a study: the cheapest of its members that have run with errors "
          "of at most this; run nothing")(
          "all",
          "of a run or --check: say what each absent effect would cost too")(
          "step",
          "of --check: make the first step, and say how long the run will take "
          "and what memory it needs")(
          "overwrite",
          "replace the results of an earlier run; run all members of a study "
          "again")("restart",
                   text("DIRECTORY"),
                   "go on with the run whose results are there, from its last "
                   "checkpoint, on any number of ranks")(
          "new-loads",
          "of a restart: loads and the motion of walls may be others");
        all.add(tasks).add(of_runs);
      }

      /** With their dashes. */
      std::vector<std::string>
      names() const
      {
        std::vector<std::string> result;
        for (const auto &option : all.options())
          result.push_back("--" + option->long_name());
        return result;
      }
    };

    /** The words in their order, as options and what is none. */
    std::vector<po::option>
    options_in(const std::vector<std::string> &words)
    {
      const Options known;
      try
        {
          return po::command_line_parser(words)
            .options(known.all)
            .run()
            .options;
        }
      catch (const po::unknown_option &error)
        {
          const std::string name    = error.get_option_name();
          const std::string nearest = nearest_name(name, known.names());
          refuse("unknown option <" + name + ">",
                 (nearest.empty() ? "" : "did you mean <" + nearest + ">? ") +
                   "emmy --help lists them.");
        }
      catch (const po::invalid_command_line_syntax &error)
        {
          const std::string name = error.get_option_name();
          if (error.kind() == po::invalid_syntax::extra_parameter)
            refuse(name + " with a value", "write " + name + " alone.");
          refuse(name + " has no value",
                 name == "--set" ? "write --set \"Section/Name=value\"."
                                 : "write " + name + " VALUE.");
        }
      catch (const po::error &error)
        {
          refuse(error.what(), "emmy --help lists the options.");
        }
    }

    double
    positive(const std::string &text)
    {
      char        *end    = nullptr;
      const double number = std::strtod(text.c_str(), &end);
      if (*end != '\0' || !(number > 0.))
        refuse("--tolerance <" + text + ">",
               "write a positive number behind it, e.g. --tolerance 1e-3.");
      return number;
    }

    void
    take_option(const po::option &option, CommandLine &line)
    {
      using Task              = CommandLine::Task;
      const std::string &name = option.string_key;
      const std::string  value =
        option.value.empty() ? std::string() : option.value[0];
      const std::vector<std::pair<std::string, Task>> tasks{
        {"check", Task::check},
        {"list", Task::list},
        {"print-parameters", Task::print_parameters},
        {"version", Task::version}};
      const auto task =
        std::find_if(tasks.begin(), tasks.end(), [&](const auto &one) {
          return one.first == name;
        });
      if (name == "help")
        line.task = Task::help;
      else if (task != tasks.end() && line.task != Task::help)
        line.task = task->second;
      else if (name == "set")
        line.assignments.push_back(value);
      else if (name == "tolerance")
        line.tolerance = positive(value);
      else if (name == "overwrite")
        line.overwrite = true;
      else if (name == "all")
        line.all = true;
      else if (name == "step")
        line.step = true;
      else if (name == "restart")
        line.restart = value;
      else if (name == "new-loads")
        line.new_loads = true;
    }

    /** Whether what was asked for goes together. */
    void
    check(const CommandLine &line)
    {
      using Task = CommandLine::Task;
      if (line.is_study && line.task == Task::list)
        refuse("study with --list", "emmy --list alone lists what there is.");
      if (line.tolerance > 0. && !(line.is_study && line.task == Task::run))
        refuse("--tolerance without a study",
               "write emmy study FILE.prm --tolerance 1e-3.");
      if (line.all && (line.is_study ||
                       (line.task != Task::check && line.task != Task::run)))
        refuse("--all without a scene to check or run",
               "write emmy --check --all FILE.prm to see what the effects "
               "would cost that the scene does not have.");
      if (line.step && (line.is_study || line.task != Task::check))
        refuse("--step without a scene to check",
               "write emmy --check --step FILE.prm to see how long a run will "
               "take.");
      if (line.task == Task::list &&
          !(line.file.empty() && line.assignments.empty()))
        refuse("--list with <" + (line.file.empty() ? "--set" : line.file) +
                 ">",
               "give --list alone: it lists what there is for any file. emmy "
               "--check FILE.prm says what a file uses.");
      if (line.new_loads && line.restart.empty())
        refuse("--new-loads without --restart",
               "write emmy --restart DIRECTORY --new-loads.");
      if (!line.restart.empty())
        {
          if (line.is_study || line.task != Task::run)
            refuse("--restart with " +
                     std::string(line.is_study ? "a study" : "another task"),
                   "write emmy --restart DIRECTORY. A study goes on with what "
                   "it lacks when it is started again.");
          if (line.overwrite)
            refuse("--restart with --overwrite",
                   "a run goes on in its folder. Leave one of them out.");
          return;
        }
      if (line.file.empty() &&
          (line.task == Task::run || line.task == Task::check))
        refuse("no parameter file",
               "name one, e.g. emmy prm/paper/7.2.prm; emmy --help says more.");
    }
  } // namespace

  CommandLine
  parse_command_line(const std::vector<std::string> &words)
  {
    CommandLine              line;
    std::vector<std::string> names;
    for (const po::option &option : options_in(words))
      {
        // versions of Boost differ in whether what follows --help is its value
        if (option.string_key.empty() || option.string_key == "help")
          names.insert(names.end(), option.value.begin(), option.value.end());
        if (!option.string_key.empty())
          take_option(option, line);
      }

    if (!names.empty() && names[0] == "study")
      {
        line.is_study = true;
        names.erase(names.begin());
      }
    else if (names.size() == 2 && names[0] == "completion")
      {
        if (names[1] != "bash")
          refuse("completion for <" + names[1] + ">",
                 "there is emmy completion bash.");
        line.task = CommandLine::Task::completion;
        names.clear();
      }
    else if (!names.empty() && names[0] == "verify")
      {
        if (names.size() > 2 || (names.size() == 2 && names[1] != "full"))
          refuse("verify <" + names[1] + ">",
                 "write emmy verify, which takes a minute or two, or emmy "
                 "verify full.");
        line.task = names.size() == 2 ? CommandLine::Task::verify_full
                                      : CommandLine::Task::verify;
        if (!line.assignments.empty() || !line.restart.empty())
          refuse("verify with --set or --restart",
                 "the scenes that it runs are part of the program; write emmy "
                 "verify alone.");
        names.clear();
      }
    if (line.task == CommandLine::Task::help)
      {
        const auto is_file = [](const std::string &name) {
          return name.size() > 4 && name.substr(name.size() - 4) == ".prm";
        };
        for (const std::string &name : names)
          if (!is_file(name))
            line.topic += (line.topic.empty() ? "" : " ") + name;
        return line;
      }
    if (names.size() > 1)
      refuse("two parameter files, <" + names[0] + "> and <" + names[1] + ">",
             "give one; start emmy once per file.");
    if (!names.empty())
      line.file = names[0];
    check(line);
    return line;
  }

  void
  print_help(std::ostream &out)
  {
    const Options options;
    out
      << R"(emmy: implicit, energy- and momentum-conserving material point method

  emmy FILE.prm [options]          run the scene of a parameter file
  emmy study FILE.prm [options]    run the study of a parameter file: a scene
                                   with many settings, compared in study.csv
                                   and on a page with pictures
  emmy --restart DIRECTORY [options]
                                   go on with a run from its last checkpoint
  emmy verify [full]               check this emmy against the paper, exact
                                   solutions and others' results: a minute or
                                   two, in full a quarter of an hour
  emmy completion bash             a script by which bash completes options

)" << options.tasks
      << '\n'
      << options.of_runs << R"(
In parallel: mpirun -np 2 emmy FILE.prm
)";
  }

  void
  print_completion(std::ostream &out)
  {
    out << R"(_emmy()
{
  local word=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD-1]} IFS=$'\n'
  COMPREPLY=()
  case $previous in
    --set | --tolerance) return ;;
    --restart) COMPREPLY=($(compgen -d -- "$word")); return ;;
  esac
  case $word in
    -*) COMPREPLY=($(compgen -W ')"
        << join(Options().names(), "\n") << R"(' -- "$word")) ;;
    *)
      COMPREPLY=($(compgen -d -- "$word") $(compgen -f -X '!*.prm' -- "$word"))
      [ "$COMP_CWORD" -ne 1 ] || COMPREPLY+=($(compgen -W $'study\nverify\ncompletion' -- "$word"))
      [ "$previous" != completion ] || COMPREPLY=(bash)
      ;;
  esac
}
complete -o filenames -F _emmy emmy
)";
  }
} // namespace emmy
