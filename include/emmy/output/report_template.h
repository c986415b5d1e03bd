#ifndef emmy_output_report_template_h
#define emmy_output_report_template_h

namespace emmy
{
  /**
   * report.html without its contents: LIBRARY, STYLE and DATA, each between
   * two @ signs, stand where the page gets the library that draws, its style
   * sheet, and a JSON object.
   */
  extern const char *const report_template;
} // namespace emmy

#endif
