#ifndef emmy_base_text_h
#define emmy_base_text_h

#include <string>
#include <vector>

/**
 * Small helpers for messages and tables that deal.II's Utilities (trim,
 * split_string_list, replace_in_string, ...) do not offer.
 */
namespace emmy
{
  /**
   * The candidate that a user most likely meant.
   *
   * Nearness is the number of letters to insert, remove or replace
   * (Levenshtein), upper and lower case being the same.
   *
   * @param wanted     what was written, e.g. "Densty"
   * @param candidates the names that would have been valid
   * @return the nearest candidate, the first of equally near ones; empty if
   *   none is within max(2, length/3) changes, or if all letters of @p wanted
   *   would have to change.
   */
  std::string
  nearest_name(const std::string              &wanted,
               const std::vector<std::string> &candidates);

  /**
   * The items in their order, with @p separator between them; empty for none.
   */
  std::string
  join(const std::vector<std::string> &items,
       const std::string              &separator = ", ");

  /**
   * The shortest decimal that reads back as exactly @p number, with a point
   * whatever the locale: 0.1, 5, 1e+22, -inf, nan.
   */
  std::string
  shortest(const double number);

  /** A number with six digits, for messages. */
  std::string
  brief(const double number);
} // namespace emmy

#endif
