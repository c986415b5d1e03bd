#ifndef emmy_output_gnuplot_h
#define emmy_output_gnuplot_h

#include <cstddef>
#include <iosfwd>
#include <string>

/**
 * What all our gnuplot scripts share.
 */
namespace emmy::gnuplot
{
  /** Width, height and size of the letters of a picture, in pixels. */
  struct Canvas
  {
    double width  = 2000.; ///< pixels
    double height = 1250.; ///< pixels
    double font   = 32.;   ///< points
  };

  /** How a run of gnuplot ended. */
  enum class Outcome
  {
    drawn,
    not_installed,
    failed
  };

  /** Text as a gnuplot string: in single quotes, on one line, no escapes. */
  std::string
  quoted(const std::string &text);

  /** A number as one reads it: four digits, 2.58 or 1.2e-05. */
  std::string
  number(const double value);

  /** The least of 1, 2, 5 times a power of ten with at most this many steps. */
  double
  nice_step(const double range, const double max_intervals);

  /** Letters of the longest number along an axis with about five tics. */
  std::size_t
  longest_number(const double lower, const double upper);

  /**
   * The start of a script: how to run it by hand, the terminal for PNG, PDF
   * or SVG, and the file that is drawn, which is @p name with that extension.
   */
  void
  write_preamble(std::ostream      &script,
                 const std::string &name,
                 const Canvas      &canvas);

  /**
   * Run gnuplot on the file @p name.gp in @p folder, from that folder. What
   * gnuplot says goes to gnuplot.log there. No part of the names is read by
   * a shell.
   */
  Outcome
  run(const std::string &folder, const std::string &name);
} // namespace emmy::gnuplot

#endif
