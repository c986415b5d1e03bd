#ifndef emmy_study_study_html_h
#define emmy_study_study_html_h

#include <string>

namespace emmy
{
  /**
   * The page of a study for a browser: what write_study_page() wrote, with its
   * pictures inside, so that it opens from the disk, needs no network and
   * prints well. Knows the Markdown of that page: headings, tables, lists,
   * indented code, pictures, bold and `code`.
   *
   * @param folder where pictures lie; one that is not there is left out
   */
  std::string
  study_as_html(const std::string &markdown, const std::string &folder);
} // namespace emmy

#endif
