#ifndef emmy_run_card_line_h
#define emmy_run_card_line_h

#include <iomanip>
#include <ostream>
#include <string>

namespace emmy
{
  /** Begins a line of the head of a run, and of `emmy --check`. */
  inline std::ostream &
  card_line(std::ostream &out, const std::string &what)
  {
    return out << "  " << std::left << std::setw(22) << what;
  }
} // namespace emmy

#endif
