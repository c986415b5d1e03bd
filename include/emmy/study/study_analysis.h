#ifndef emmy_study_study_analysis_h
#define emmy_study_study_analysis_h

#include <array>
#include <string>
#include <vector>

namespace emmy
{
  class StudyTable;
  struct StudyPlan;

  /**
   * Members that differ in the refined list alone, the largest size first; in
   * a paired study all members.
   */
  struct StudyCurve
  {
    /** Their values of the other lists: "functions = GIMP, points = 2". */
    std::string name;
    /** Numbers of members, from coarse to fine. */
    std::vector<unsigned int> members;
  };

  /** All members in curves; without a refined list each is one. */
  std::vector<StudyCurve>
  study_curves(const StudyPlan &plan);

  /** The size of a member; NaN without a refined list. */
  double
  size_of(const StudyPlan &plan, const unsigned int member);

  /** Order p of errors that fall like size^p. NaN: not known. */
  struct StudyOrder
  {
    double fitted; ///< least squares of the logarithms
    std::vector<double>
      steps; ///< from each size to the next smaller one that has an error
  };

  /**
   * Errors that are zero or NaN are left out.
   * @param errors one per size
   */
  StudyOrder
  fit_order(const std::vector<double> &sizes,
            const std::vector<double> &errors);

  /** What values tend to with decreasing size; NaN: they do not. */
  struct StudyLimit
  {
    /** Error, and order to the one before. */
    double value, order;
  };

  /**
   * Richardson's extrapolation: value + C size^order through three points of
   * sizes that fall, in any ratio. Without a limit if the differences do not
   * fall, or only with an order below 0.05 or above 20.
   */
  StudyLimit
  richardson_limit(const std::array<double, 3> &sizes,
                   const std::array<double, 3> &values);

  /**
   * The Pareto front: no other one has less of both. NaN is never on it.
   */
  std::vector<bool>
  pareto_front(const std::vector<double> &seconds,
               const std::vector<double> &errors);

  /**
   * The one with the fewest seconds and at most this @p tolerance; -1: none.
   */
  int
  cheapest(const std::vector<double> &seconds,
           const std::vector<double> &errors,
           const double               tolerance);

  /**
   * What one value of a list changes against the list's first one: geometric
   * means of ratios over all pairs of members that differ in nothing else.
   */
  struct StudyChoice
  {
    /** Which value of which list. */
    unsigned int        list, value;
    unsigned int        n_pairs = 0; ///< compared
    double              seconds;     ///< times the first one's; NaN: not known
    std::vector<double> errors;      ///< for each quantity
  };

  /** For all values but the first of all lists. */
  std::vector<StudyChoice>
  study_choices(const StudyPlan &plan, const StudyTable &table);
} // namespace emmy

#endif
