#ifndef emmy_study_study_plan_h
#define emmy_study_study_plan_h

#include <emmy/base/parameter_file.h>

#include <iosfwd>
#include <limits>
#include <string>
#include <vector>

namespace emmy
{
  /** One thing that the members of a study differ in. */
  struct StudyList
  {
    std::string              name;    ///< its section, its column in study.csv
    std::vector<std::string> entries; ///< of the scene; all take the value
    std::vector<std::string> values;
  };

  /** What a study compares: a column of the ledger. */
  struct StudyQuantity
  {
    std::string column;
    bool        is_largest; ///< largest in size over the run, or at its end

    /** Its column in study.csv. */
    std::string
    name() const;
  };

  /** One setting of the base scene. */
  struct StudyMember
  {
    std::string              name;   ///< member-001, ...; also its folder
    std::vector<std::string> values; ///< one per list
  };

  /**
   * A study, as section `Study` of a parameter file describes it: a base
   * scene, the members made of it, and what is compared with which reference.
   * Made once by read_study(), then passed as const.
   */
  struct StudyPlan
  {
    /** Of `reference`: nothing is subtracted. */
    static constexpr unsigned int no_reference =
      std::numeric_limits<unsigned int>::max();

    std::string                directory;
    std::vector<StudyList>     lists;
    std::vector<StudyMember>   members;
    std::vector<StudyQuantity> quantities;
    unsigned int               reference = no_reference; ///< a member's number
    unsigned int               repetitions = 1;
    bool                       with_frames = false;
    ParameterFile              base_scene;

    /** Where a repetition, counted from 0, of a member goes. */
    std::string
    folder(const StudyMember &member, const unsigned int repetition) const;

    /** The scene of a member, with its values and that folder. */
    ParameterFile
    scene(const StudyMember &member, const unsigned int repetition) const;

    /** "dt = 0.1, functions = GIMP": the values of a member. */
    std::string
    setting(const StudyMember &member) const;
  };

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
