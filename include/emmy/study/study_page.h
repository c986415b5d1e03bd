#ifndef emmy_study_study_page_h
#define emmy_study_study_page_h

#include <emmy/study/study_table.h>

#include <iosfwd>

namespace emmy
{
  /**
   * The page of a study in Markdown, to be read in a minute: the cheapest
   * settings for tolerances, what each choice costs and brings, fitted orders,
   * the members. Pictures are named, not drawn. For rank 0.
   */
  void
  write_study_page(std::ostream     &out,
                   const StudyPlan  &plan,
                   const StudyTable &table);

  /**
   * The cheapest setting for each quantity with at most this @p tolerance,
   * one line each. For rank 0.
   *
   * @return whether there is one for each quantity
   */
  bool
  print_cheapest(std::ostream     &out,
                 const StudyPlan  &plan,
                 const StudyTable &table,
                 const double      tolerance);
} // namespace emmy

#endif
