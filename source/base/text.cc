#include <emmy/base/text.h>

#include <sstream>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <numeric>

namespace emmy
{
  namespace
  {
    /** Letters to insert, remove or replace to turn @p a into @p b. */
    std::size_t
    edit_distance(const std::string &a, const std::string &b)
    {
      const auto same = [](const unsigned char x, const unsigned char y) {
        return std::tolower(x) == std::tolower(y);
      };

      // row[j]: distance of the first i letters of a to the first j of b
      std::vector<std::size_t> row(b.size() + 1);
      std::iota(row.begin(), row.end(), 0);
      for (std::size_t i = 1; i <= a.size(); ++i)
        {
          std::size_t diagonal = row[0];
          row[0]               = i;
          for (std::size_t j = 1; j <= b.size(); ++j)
            {
              const std::size_t replaced =
                diagonal + (same(a[i - 1], b[j - 1]) ? 0 : 1);
              diagonal = row[j];
              row[j]   = std::min({row[j] + 1, row[j - 1] + 1, replaced});
            }
        }
      return row.back();
    }
  } // namespace


  std::string
  nearest_name(const std::string              &wanted,
               const std::vector<std::string> &candidates)
  {
    std::string nearest;
    std::size_t limit = // first distance that is too far
      std::min(wanted.size(), std::max<std::size_t>(2, wanted.size() / 3) + 1);
    for (const std::string &candidate : candidates)
      {
        const std::size_t distance = edit_distance(wanted, candidate);
        if (distance < limit)
          {
            nearest = candidate;
            limit   = distance;
          }
      }
    return nearest;
  }


  std::string
  join(const std::vector<std::string> &items, const std::string &separator)
  {
    std::string result;
    for (const std::string &item : items)
      result += (&item == &items.front() ? "" : separator) + item;
    return result;
  }


  std::string
  shortest(const double number)
  {
    std::array<char, 32> text; // the longest is 24: -2.2250738585072014e-308
    const auto end = std::to_chars(text.begin(), text.end(), number).ptr;
    return std::string(text.begin(), end);
  }

  std::string
  brief(const double number)
  {
    std::ostringstream text;
    text << number;
    return text.str();
  }
} // namespace emmy
