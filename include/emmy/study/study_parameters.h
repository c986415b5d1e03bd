#ifndef emmy_study_study_parameters_h
#define emmy_study_study_parameters_h

#include <emmy/study/study_plan.h>

#include <iosfwd>

namespace emmy
{
  /**
   * The study of a file. Throws ExcParameter or ExcRun for anything missing,
   * unknown or contradictory in its section; what the members' scenes make of
   * their values is not looked at.
   *
   * @param filename of @p file: the base scene is relative to it
   */
  StudyPlan
  read_study(const ParameterFile &file, const std::string &filename);

  /** All parameters of section `Study`, as @p file sets them. */
  void
  print_study_parameters(const ParameterFile &file, std::ostream &out);

  /** A file with one list, for the reference of all parameters. */
  ParameterFile
  reference_study();
} // namespace emmy

#endif
