#ifndef emmy_study_study_plan_h
#define emmy_study_study_plan_h

#include <emmy/base/parameter_file.h>
#include <emmy/study/study_quantity.h>

#include <string>
#include <vector>

namespace emmy
{
  /** One thing that the members of a study differ in. */
  struct StudyList
  {
    std::string              name;    ///< its section, its column in study.csv
    std::vector<std::string> entries; ///< of the scene
    std::vector<std::string> values;  ///< their names, all different
    /** For each value what each entry is set to. */
    std::vector<std::vector<std::string>> settings;
    /** A length, a step, ... for each value; empty if they are no numbers. */
    std::vector<double> sizes;
    std::string         label; ///< of an axis for the sizes

    /** Whether members differ in it: a list of one value is not shown. */
    bool
    varies() const
    {
      return values.size() > 1;
    }

    /** Number of a value, of those that there are. */
    unsigned int
    position(const std::string &value) const;

    /** Whether the values are numbers of ranks, not an entry of the scene. */
    bool
    is_ranks() const
    {
      return entries.front() == "Ranks";
    }
  };

  /** What is subtracted from a quantity to have its error. */
  struct StudyReference
  {
    /** What a value is compared with. */
    enum class Kind
    {
      none,   ///< nothing: the quantity is an error already
      number, ///< an exact value
      member, ///< the value of a member
      limit   ///< of three members of decreasing size (Richardson)
    };

    Kind         kind   = Kind::none; ///< of the reference
    double       number = 0.;         ///< if it is a number
    unsigned int member = 0;          ///< if it is a member
  };

  /** One setting of the base scene. */
  struct StudyMember
  {
    std::string              name;   ///< member-001, ...; also its folder
    std::vector<std::string> values; ///< name of one per list
  };

  /**
   * A study, as section `Study` of a parameter file describes it: a base
   * scene, the members made of it, and what is compared with which reference.
   * Made once by read_study() (study_parameters.h), then passed as const.
   */
  struct StudyPlan
  {
    /** For the page. */
    std::string title, purpose;
    std::string file;      ///< that describes the study
    std::string directory; ///< of all results
    /** By their first one, in the names of members. */
    std::vector<StudyList> lists;
    /** Values side by side, not crossed. */
    bool                        is_paired = false;
    std::vector<StudyMember>    members;    ///< runs
    std::vector<StudyQuantity>  quantities; ///< what is compared
    std::vector<StudyReference> references; ///< one per quantity
    /** What errors are divided by; 0: the size of the reference. */
    std::vector<double> scales;
    std::vector<double> tolerances; ///< of the page, descending
    /** List whose sizes are an axis; lists.size() if there is none. */
    unsigned int  refined_list = 0;
    int           baseline     = -1;    ///< a member to compare with; -1: none
    unsigned int  repetitions  = 1;     ///< of each run, for seconds
    bool          with_frames  = false; ///< whether runs write files
    ParameterFile base_scene;           ///< without the lists' values

    /** Where a repetition, counted from 0, of a member goes. */
    std::string
    folder(const StudyMember &member, const unsigned int repetition) const;

    /** The scene of a member, with its values and that folder. */
    ParameterFile
    scene(const StudyMember &member, const unsigned int repetition) const;

    /** "dt = 0.1, functions = GIMP": the values of a member that vary. */
    std::string
    setting(const StudyMember &member) const;

    /** Ranks that run a member; 0: all there are. */
    unsigned int
    ranks(const StudyMember &member) const;

    /** Whether any list has sizes. */
    bool
    has_sizes() const
    {
      return refined_list < lists.size();
    }
  };
} // namespace emmy

#endif
