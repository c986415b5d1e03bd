#ifndef emmy_study_command_line_h
#define emmy_study_command_line_h

#include <iosfwd>
#include <string>
#include <vector>

namespace emmy
{
  /** What the command line asks for. */
  struct CommandLine
  {
    /** What to do. */
    enum class Task
    {
      run,
      check,
      list,
      print_parameters,
      version,
      help,
      completion, ///< of words, in a shell
      verify,
      verify_full
    } task = Task::run;                   ///< what to do
    std::string              file;        ///< the parameter file
    std::vector<std::string> assignments; ///< of --set, in their order
    /** As given. */
    bool        overwrite = false, all = false, step = false;
    double      tolerance = 0.;    ///< 0: not asked for
    bool        is_study  = false; ///< the first word is `study`
    std::string restart;           ///< results of the run to go on with
    bool        new_loads = false; ///< which then may be others
    std::string topic;             ///< of help; empty: everything
  };

  /**
   * Read the command line as GNU programs do: options in any place, --NAME
   * VALUE or --NAME=VALUE, names cut short while they are unique, -- before
   * names of files that start with a dash. Of tasks and values that exclude
   * each other the last counts; help comes before all.
   *
   * Throws ExcRun, with the nearest option, for what it does not understand
   * and for what does not go together.
   *
   * @param words without the program's name
   */
  CommandLine
  parse_command_line(const std::vector<std::string> &words);

  /** What can stand on the command line. */
  void
  print_help(std::ostream &out);

  /** A script by which bash completes the command line of emmy. */
  void
  print_completion(std::ostream &out);

  /**
   * The parts of a listing of parameters that explain a topic: the sections
   * and entries of that name or path ("Gravity", "effects/gravity", "Step
   * size"), in lower or upper case. Throws ExcRun, with the nearest one, if
   * there is none.
   *
   * @param listing as ParameterHandler::print_parameters() writes it
   * @return the lines, each part below its path
   */
  std::string
  parameters_on(const std::string &topic, const std::string &listing);
} // namespace emmy

#endif
