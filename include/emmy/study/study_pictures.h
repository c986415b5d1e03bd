#ifndef emmy_study_study_pictures_h
#define emmy_study_study_pictures_h

#include <emmy/study/study_table.h>

#include <string>
#include <vector>

namespace emmy
{
  /**
   * Draw error against seconds, and against size if the study has sizes: the
   * scripts error-seconds.gp and error-size.gp with their data, and the .png
   * of each, in the folder of the study. For rank 0.
   *
   * Colours tell the values of the first list that is no axis apart, points
   * those of the second, dashes those of the third.
   *
   * @return warnings, one line each. Throws ExcRun if a script cannot be
   *   written.
   */
  std::vector<std::string>
  draw_study(const StudyPlan &plan, const StudyTable &table);
} // namespace emmy

#endif
