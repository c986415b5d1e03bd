#include <emmy/output/force_picture.h>
#include <emmy/output/gnuplot.h>

#include <algorithm>
#include <ostream>

namespace emmy
{
  void
  ForcePicture::write_script(std::ostream      &script,
                             const std::string &title) const
  {
    const char *const colours[] = {"#0072b2", "#d55e00", "#009e73"};
    const std::string body      = tool.substr(5, tool.size() - 6);

    gnuplot::write_preamble(script, name, gnuplot::Canvas());
    script << "set datafile separator comma\n"
           << "set datafile columnheaders\n"
           << "ledger = '../ledger.csv'\n";
    std::string square = "0";
    for (unsigned int d = 0; d < dim; ++d)
      {
        const std::string start(1, "xyz"[d]);
        script << "stats ledger using (column('" << tool << start
               << "')) every ::0::0 nooutput name '" << start << "'\n";
        square += " + (column('" + tool + start + "') - " + start + "_max)**2";
      }
    script << "stats ledger using (sqrt(" << square
           << ")) nooutput name 'path'\n"
           << "# A tool that rests has no path.\n"
           << "moves = path_max > 0\n"
           << "along(t, s) = moves ? s : t\n"
           << "set label 1 " << gnuplot::quoted(title)
           << " noenhanced at screen 0.5, screen 0.965 center\n"
           << "set tmargin 5\nset rmargin 5\n"
           << "set border 3 lw 0.6 lc rgb '#404040'\n"
           << "set tics out nomirror scale 0.5\n"
           << "set grid xtics ytics back lt 1 lw 0.4 lc rgb '#e2e2e2'\n"
           << "set xlabel moves ? 'distance of the tool from its start (m)' : "
              "'time (s)'\n"
           << "set ylabel " << gnuplot::quoted("force on " + body + " (N)")
           << " noenhanced\n"
           << "set key at screen 0.5, screen 0.91 center top horizontal Left "
              "reverse samplen 2\n\nplot \\\n";
    for (unsigned int d = 0; d < dim; ++d)
      script << "  ledger using (along(column('time'), sqrt(" << square
             << "))):(column('" << tool << "force_"
             << "xyz"[d] << "')) with lines lw 1.2 lc rgb '" << colours[d]
             << "' title '"
             << "xyz"[d] << (d + 1 < dim ? "', \\\n" : "'\n");
  }


  std::vector<ForcePicture>
  force_pictures(const std::vector<std::string> &columns)
  {
    const std::string         beginning = "tool_", ending = "force_x";
    std::vector<ForcePicture> found;
    for (const std::string &column : columns)
      if (column.compare(0, beginning.size(), beginning) == 0 &&
          column.size() > beginning.size() + ending.size() &&
          column.compare(column.size() - ending.size(),
                         ending.size(),
                         ending) == 0)
        {
          const std::string tool =
            column.substr(0, column.size() - ending.size());
          const bool in_space =
            std::find(columns.begin(), columns.end(), tool + "force_z") !=
            columns.end();
          found.push_back(
            {"forces_" + tool.substr(beginning.size(),
                                     tool.size() - beginning.size() - 1),
             tool,
             in_space ? 3u : 2u});
        }
    return found;
  }
} // namespace emmy
