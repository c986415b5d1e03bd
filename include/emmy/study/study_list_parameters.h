#ifndef emmy_study_study_list_parameters_h
#define emmy_study_study_list_parameters_h

#include <emmy/base/section.h>
#include <emmy/study/study_plan.h>

namespace emmy
{
  /** Section `Study/NAME`: one list of values. Exists while it is read. */
  class StudyListParameters : public Section
  {
  public:
    /** As written. */
    std::string         entries, values, value_names, label;
    std::vector<double> sizes; ///< for pictures and orders

    /** Declares the entries of a section. */
    explicit StudyListParameters(const std::string &path);

    /** The list of this name. Throws ExcParameter for what is wrong. */
    StudyList
    list(const std::string &name) const;
  };

  /** "1, 2.5", for messages. */
  std::string
  join_numbers(const std::vector<double> &values);
} // namespace emmy

#endif
