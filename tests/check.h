#ifndef emmy_tests_check_h
#define emmy_tests_check_h

#include <cmath>
#include <cstdlib>
#include <exception>
#include <iomanip>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

/**
 * What a test that checks itself needs. Failures are printed and counted;
 * main() ends with <code>return emmy::test::report();</code>.
 */
namespace emmy
{
  namespace test
  {
    inline unsigned int n_checks = 0;
    inline unsigned int n_failed = 0;
    inline bool         is_over  = false; ///< the counts were printed

    /** @p fact must be true; @p what says what it is. */
    inline void
    check(const bool fact, const std::string &what)
    {
      ++n_checks;
      if (!fact)
        {
          ++n_failed;
          std::cout << "FAILED: " << what << std::endl;
          if (is_over) // the exit code is on its way
            std::abort();
        }
    }

    /** |a-b| must not exceed @p tolerance, an absolute one. NaN fails. */
    inline void
    check_close(const double       a,
                const double       b,
                const double       tolerance,
                const std::string &what)
    {
      std::ostringstream numbers;
      numbers << std::setprecision(17) << what << ": " << a << " and " << b
              << " differ by " << std::abs(a - b) << ", allowed is "
              << tolerance;
      check(std::abs(a - b) <= tolerance, numbers.str());
    }

    /**
     * Calling @p function must throw, and the message must contain every one
     * of @p texts. Line breaks and repeated blanks do not count, since
     * deal.II wraps its messages.
     */
    template <typename Function>
    void
    check_throws_with(const Function                 &function,
                      const std::vector<std::string> &texts)
    {
      const auto in_one_line = [](const std::string &text) {
        std::istringstream words(text);
        std::string        line;
        for (std::string word; words >> word;)
          line += (line.empty() ? "" : " ") + word;
        return line;
      };

      std::string message;
      try
        {
          function();
        }
      catch (const std::exception &error)
        {
          message = error.what();
        }
      check(!message.empty(),
            "no exception, expected <" + (texts.empty() ? "" : texts[0]) + ">");
      if (message.empty())
        return;
      for (const std::string &text : texts)
        check(in_one_line(message).find(in_one_line(text)) != std::string::npos,
              "the message lacks <" + text + ">:\n" + message);
    }

    /** Print the counts. @return the exit code: 0 if all checks passed. */
    inline int
    report()
    {
      std::cout << n_checks << " checks, " << n_failed << " failed"
                << std::endl;
      is_over = true;
      return n_failed == 0 && n_checks > 0 ? 0 : 1;
    }
  } // namespace test
} // namespace emmy

#endif
