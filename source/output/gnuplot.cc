#include <emmy/output/gnuplot.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <ostream>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace emmy::gnuplot
{
  std::string
  quoted(const std::string &text)
  {
    std::string out = "'";
    for (const char c : text)
      if (c == '\'')
        out += "''";
      else
        out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    return out + "'";
  }


  std::string
  number(const double value)
  {
    char text[32];
    std::snprintf(text, sizeof(text), "%.4g", value == 0. ? 0. : value);
    return text;
  }


  double
  nice_step(const double range, const double max_intervals)
  {
    const double least = range / max_intervals;
    const double power = std::pow(10., std::floor(std::log10(least)));
    for (const double factor : {1., 2., 5.})
      if (factor * power >= least * (1. - 1e-9))
        return factor * power;
    return 10. * power;
  }


  std::size_t
  longest_number(const double lower, const double upper)
  {
    const double step    = nice_step(upper - lower, 5.);
    std::size_t  letters = 0;
    for (double i = std::ceil(lower / step); i <= upper / step; ++i)
      letters = std::max(letters, number(i * step).size());
    return letters;
  }


  void
  write_preamble(std::ostream      &script,
                 const std::string &name,
                 const Canvas      &canvas)
  {
    // A picture of 2000 pixels is meant to be 17 cm wide, the text width of
    // a page; then letters of 32 pixels are those of a caption (8 pt).
    const double pixels_per_cm = 2000. / 17.;
    const double points_per_cm = 72. / 2.54;
    const auto   size          = [&](const double scale, const char *unit) {
      return " size " + std::to_string(canvas.width / scale) + unit + "," +
             std::to_string(canvas.height / scale) + unit;
    };
    const std::string pixels =
      " size " + std::to_string(static_cast<int>(canvas.width + 0.5)) + "," +
      std::to_string(static_cast<int>(canvas.height + 0.5));

    script << "# Written by emmy. To draw it again, in this folder:\n"
           << "#   gnuplot " << name << ".gp\n"
           << "#   gnuplot -e \"format='pdf'\" " << name
           << ".gp      (or svg)\n"
           << "if (!exists('format')) format = 'png'\n"
           << "if (format eq 'pdf') {\n"
           << "  set terminal pdfcairo enhanced color"
           << size(pixels_per_cm, "cm") << " font 'Sans,"
           << canvas.font * points_per_cm / pixels_per_cm
           << "' linewidth 0.7 pointscale 0.35\n"
           << "} else { if (format eq 'svg') {\n"
           << "  set terminal svg enhanced background 'white'" << pixels
           << " font 'Sans," << canvas.font << "' linewidth 2.6\n"
           << "} else { if (strstrt(GPVAL_TERMINALS, 'pngcairo') > 0) {\n"
           << "  set terminal pngcairo enhanced color background 'white'"
           << pixels << " font 'Sans," << canvas.font * 0.75
           << "' linewidth 2.6 pointscale 2.2\n"
           << "} else {\n"
           << "  set terminal png enhanced truecolor" << pixels
           << " font 'Sans," << canvas.font * 0.75 << "' linewidth 2.6\n"
           << "} } }\n"
           << "set output '" << name << ".'.format\n"
           << "set encoding utf8\n\n";
  }


  Outcome
  run(const std::string &folder, const std::string &name)
  {
    namespace fs            = std::filesystem;
    const fs::path  picture = fs::path(folder) / (name + ".png");
    std::error_code error;
    fs::remove(picture, error);

    // The names reach the shell as arguments $1 and $2, never as text that
    // it would read. It changes to the folder, since the scripts name their
    // data relative to it. Without -d the user's own settings would interfere.
    // In another locale gnuplot cannot read that its script is UTF-8.
    std::string shell  = "/bin/sh";
    std::string option = "-c";
    std::string command =
      "cd -- \"$1\" 2>/dev/null && exec env LC_ALL=C.UTF-8 gnuplot -d "
      "\"$2\" </dev/null >>gnuplot.log 2>&1";
    std::string absolute    = fs::absolute(folder, error).string();
    std::string script      = name + ".gp";
    char *const arguments[] = {shell.data(),
                               option.data(),
                               command.data(),
                               shell.data(),
                               absolute.data(),
                               script.data(),
                               nullptr};

    pid_t process = 0;
    int   status  = 0;
    if (error ||
        posix_spawn(
          &process, shell.c_str(), nullptr, nullptr, arguments, environ) != 0)
      return Outcome::failed;
    while (waitpid(process, &status, 0) == -1)
      if (errno != EINTR)
        return Outcome::failed;

    if (WIFEXITED(status) && WEXITSTATUS(status) == 127)
      return Outcome::not_installed;
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0 &&
        fs::exists(picture, error) && fs::file_size(picture, error) > 0)
      return Outcome::drawn;
    return Outcome::failed;
  }
} // namespace emmy::gnuplot
