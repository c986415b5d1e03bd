#ifndef emmy_output_report_page_h
#define emmy_output_report_page_h

#include <emmy/output/animation.h>
#include <emmy/output/ledger.h>

#include <string>
#include <vector>

namespace emmy
{
  /** What a report says beyond the files of its run. */
  struct Report
  {
    /** Words of the head. */
    std::string              title, command;
    std::vector<std::string> measurements; ///< names; their columns are NAME_*
    const Animation         *film = nullptr; ///< null: none
  };

  /**
   * Write report.html beside a run: one file that opens from the disk. It holds
   * the scene card of run.log, curves of the ledger (at most 2000 rows, the
   * last one among them), timing.json, the film, and links to all files.
   * The package libjs-dygraphs draws the curves; where it is not installed, the
   * page has the last row of the ledger instead and says so. For the first
   * rank, at the end. Cost: milliseconds, and the memory of the page.
   * @return a warning; empty: all went well
   */
  std::string
  write_report(const std::string &directory,
               const Ledger      &ledger,
               const Report      &report);
} // namespace emmy

#endif
