#include <emmy/output/gnuplot.h>
#include <emmy/output/panel_layout.h>
#include <emmy/output/particle_picture.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <limits>
#include <ostream>
#include <sstream>
#include <utility>

namespace emmy
{
  namespace
  {
    using dealii::Point;

    // Grid lines closer than this (in pixels) would be a grey area.
    constexpr double least_line_distance = 6.;

    using Line = std::pair<Point<3>, Point<3>>;


    /** The time of a panel in the unit that suits the last one. */
    std::string
    time_text(const ParticlePicture &picture, const double time)
    {
      const double last = picture.panels.back().time;
      if (last >= 0.1 || last == 0.)
        return gnuplot::number(time) + " s";
      if (last >= 1e-4)
        return gnuplot::number(1e3 * time) + " ms";
      return gnuplot::number(1e6 * time) + " µs";
    }


    /** The lines of the grid: all in 2D, those on the three far sides in 3D. */
    std::vector<Line>
    grid_lines(const ParticlePicture &picture, const double pixels_per_metre)
    {
      // The far sides are those at the lower x, upper y and lower z.
      const Point<3>   &a = picture.lower, &b = picture.upper;
      const Point<3>    far(a[0], b[1], a[2]);
      std::vector<Line> lines;
      for (unsigned int across = 0; across < picture.dim; ++across)
        {
          const double h = picture.line_distance[across];
          const auto   n =
            static_cast<unsigned int>(std::lround((b[across] - a[across]) / h));
          const unsigned int stride =
            h * pixels_per_metre >= least_line_distance ? 1 : std::max(n, 1u);
          for (unsigned int along = 0; along < picture.dim; ++along)
            for (unsigned int i = 0; i <= n && along != across; i += stride)
              {
                Point<3> from = far;
                from[across]  = a[across] + i * h;
                from[along]   = a[along];
                Point<3> to   = from;
                to[along]     = b[along];
                lines.emplace_back(from, to);
              }
        }
      return lines;
    }


    /** Numbers and names along three front edges of the box in 3D. */
    void
    write_axes_of_box(std::ostream          &script,
                      const ParticlePicture &picture,
                      const PanelLayout     &layout)
    {
      const Point<3> &a = picture.lower, &b = picture.upper;
      const Point<3>  starts[3]  = {a, Point<3>(b[0], a[1], a[2]), a};
      const char     *numbers[3] = {"right offset character 0,-0.6",
                                    "left offset character 0.3,-0.5",
                                    "right offset character -0.6,0"};
      const char     *names[3]   = {"'x (m)' right offset character -1,-1.4",
                                    "'y (m)' left offset character 1,-1.4",
                                    "'z (m)' right offset character -0.6,0"};

      const auto write_label = [&](const unsigned int axis,
                                   const double       at,
                                   const std::string &text,
                                   const char        *offset) {
        Point<3> place          = starts[axis];
        place[axis]             = at;
        const Point<2> on_paper = project(picture, place);
        script << "set label " << text << " at " << on_paper[0] << ","
               << on_paper[1] << " " << offset << "\n";
      };

      for (unsigned int d = 0; d < 3; ++d)
        {
          Point<3> end     = starts[d];
          end[d]           = b[d];
          const Point<2> p = project(picture, starts[d]);
          const Point<2> q = project(picture, end);
          script << "set arrow from " << p[0] << "," << p[1] << " to " << q[0]
                 << "," << q[1] << " nohead lc rgb '#404040' lw 0.6\n";

          const double font   = layout.canvas.font;
          const double length = layout.pixels_per_metre * p.distance(q);
          const double step =
            gnuplot::nice_step(b[d] - a[d],
                               std::clamp(length / (4. * font), 3., 5.));
          const double first = std::ceil(a[d] / step - 1e-9);
          const double last  = std::floor(b[d] / step + 1e-9);
          // On a short axis there is room for one number. Where axes meet the
          // number of the vertical one is enough.
          const bool is_short =
            length * step / (b[d] - a[d]) < (d == 2 ? 1.5 : 2.5) * font;
          for (double i = is_short ? last : first; i <= last; ++i)
            if (d == 2 || (i * step - a[d]) * layout.pixels_per_metre > font)
              write_label(d,
                          i * step,
                          "'" + gnuplot::number(i * step) + "'",
                          numbers[d]);
          // The name stands between the last two numbers, or before the only
          // one.
          write_label(d, is_short ? a[d] : (last - 0.5) * step, "", names[d]);
        }
    }


    /** Everything that the panels share. */
    void
    write_common(std::ostream          &script,
                 const ParticlePicture &picture,
                 const PanelLayout     &layout)
    {
      // Viridis (van der Walt and Smith): perceptually uniform, and safe for
      // the colour-blind.
      std::ostringstream legend;
      legend << std::setprecision(3) << picture.value_label << ", from "
             << picture.smallest << " to " << picture.largest;
      script << "# The range of colours of all panels: 1st to 99th percentile "
                "of all values.\n"
             << "first = " << picture.first_colour << "\n"
             << "last  = " << picture.last_colour << "\n"
             << "# Particles are discs, m: large ones touch at first, small "
                "ones leave no gaps.\n"
             << "radius = "
             << picture.spacing *
                    (picture.spacing * layout.pixels_per_metre > 10. ? 0.5
                                                                     : 0.71) +
                  0.3 / layout.pixels_per_metre
             << "\n\nset cbrange [first:last]\n"
             << "set palette defined (0 '#440154', 1 '#482878', "
                "2 '#3e4989', 3 '#31688e', 4 '#26828e', \\\n"
             << "  5 '#1f9e89', 6 '#35b779', 7 '#6ece58', 8 '#b5de2b', "
                "9 '#fde725')\n"
             << "set cblabel " << gnuplot::quoted(legend.str())
             << " offset 0,0.6\nset cbtics scale 0.4 offset 0,0.4 "
             << gnuplot::nice_step(picture.last_colour - picture.first_colour,
                                   6)
             << "\nunset key\n";

      script << "set xrange [" << layout.paper_lower[0] << ":"
             << layout.paper_upper[0] << "]\n"
             << "set yrange [" << layout.paper_lower[1] << ":"
             << layout.paper_upper[1] << "]\n";
      if (picture.dim == 2)
        {
          const double font         = layout.canvas.font;
          const double most_tics[2] = {
            layout.panel_width / font /
              (1.2 + 0.6 * gnuplot::longest_number(picture.lower[0],
                                                   picture.upper[0])),
            layout.panel_height / font / 1.8};
          script << "set border lw 0.6 lc rgb '#404040'\n"
                 << "set tics out nomirror scale 0.4\n";
          for (unsigned int d = 0; d < 2; ++d)
            script << "set "
                   << "xy"[d] << "tics "
                   << gnuplot::nice_step(picture.upper[d] - picture.lower[d],
                                         std::clamp(most_tics[d], 1.5, 5.))
                   << "\n";
        }
      else
        {
          script << "unset border\nunset xtics\nunset ytics\n";
          write_axes_of_box(script, picture, layout);
        }

      script << "\n# The lines of the background grid.\n$grid << EOD\n";
      for (const Line &line : grid_lines(picture, layout.pixels_per_metre))
        script << project(picture, line.first) << "\n"
               << project(picture, line.second) << "\n\n";
      script << "EOD\n";
    }


    void
    write_panel(std::ostream          &script,
                const ParticlePicture &picture,
                const PanelLayout     &layout,
                const std::size_t      index)
    {
      const gnuplot::Canvas &canvas = layout.canvas;
      const std::size_t      column = index % layout.n_columns;
      const bool is_lowest = index + layout.n_columns >= picture.panels.size();
      const double left =
        layout.left + column * (layout.panel_width + layout.column_gap);
      const double top = layout.top + index / layout.n_columns *
                                        (layout.panel_height + layout.row_gap);

      script << "\nset lmargin at screen " << left / canvas.width
             << "\nset rmargin at screen "
             << (left + layout.panel_width) / canvas.width
             << "\nset tmargin at screen " << 1. - top / canvas.height
             << "\nset bmargin at screen "
             << 1. - (top + layout.panel_height) / canvas.height
             << "\nset title 't = "
             << time_text(picture, picture.panels[index].time)
             << "' offset 0,-0.6\n";
      if (picture.dim == 2)
        script << "set format y '" << (column == 0 ? "%g" : "") << "'\n"
               << "set ylabel '" << (column == 0 ? "y (m)" : "") << "'\n"
               << "set format x '" << (is_lowest ? "%g" : "") << "'\n"
               << "set xlabel '" << (is_lowest ? "x (m)" : "")
               << "' offset 0,0.3\n";
      script << "plot $grid with lines lc rgb '#d0d0d0' lw 0.45";
      const std::string &file = picture.panels[index].file;
      if (!file.empty())
        script << ", \\\n  " << gnuplot::quoted(file) << " using "
               << (picture.dim == 2 ? "1:2:(radius):3"
                                    : "(right($1,$2,$3)):(up($1,$2,$3)):"
                                      "(radius):4")
               << " with circles lw 0.2 lc palette fill solid "
               << (picture.dim == 2 ? "noborder" : "border lc rgb '#303030'");
      const std::string &surfaces = picture.panels[index].surfaces;
      if (!surfaces.empty())
        script << ", \\\n  " << gnuplot::quoted(surfaces) << " using "
               << (picture.dim == 2
                     ? "1:2 with lines lw 1.2 lc rgb '#c00000'"
                     : "(right($1,$2,$3)):(up($1,$2,$3)) with filledcurves "
                       "closed fs transparent solid 0.12 noborder "
                       "lc rgb '#c00000'");
      script << "\n";
    }
  } // namespace


  void
  ParticlePicture::choose_colours(const std::string &folder)
  {
    std::vector<double> values;
    for (const Panel &panel : panels)
      {
        std::ifstream in(std::filesystem::path(folder) / panel.file);
        std::string   line;
        for (std::getline(in, line); std::getline(in, line);)
          {
            const double value =
              std::strtod(line.c_str() + line.find_last_of(' '), nullptr);
            if (std::isfinite(value))
              values.push_back(value);
          }
      }
    const auto percentile = [&values](const double percent) {
      const auto place =
        values.begin() + std::lround(0.01 * percent * (values.size() - 1));
      std::nth_element(values.begin(), place, values.end());
      return *place;
    };
    if (smallest > largest) // there is no value
      smallest = largest = 0.;
    first_colour = smallest;
    last_colour  = largest;
    if (!values.empty() && percentile(1.) < percentile(99.))
      {
        first_colour = percentile(1.);
        last_colour  = percentile(99.);
      }
    if (last_colour <= first_colour)
      last_colour = first_colour + 1.;
  }


  void
  ParticlePicture::write_script(std::ostream &script) const
  {
    const PanelLayout      layout = PanelLayout::best(*this);
    const gnuplot::Canvas &canvas = layout.canvas;

    script << std::setprecision(8);
    gnuplot::write_preamble(script, "particles", canvas);
    script << "# As PDF or SVG, many particles make a large file.\n";
    if (dim == 3)
      script << "# Parallel projection. The points in the files are sorted "
                "for it, far ones first.\n"
             << "right(x,y,z) = x*(" << Projection::to_the_right[0] << ") + y*("
             << Projection::to_the_right[1] << ")\n"
             << "up(x,y,z) = x*(" << Projection::upwards[0] << ") + y*("
             << Projection::upwards[1] << ") + z*(" << Projection::upwards[2]
             << ")\n\n";
    write_common(script, *this, layout);

    script << "\nset multiplot\n"
           << "set label 999 " << gnuplot::quoted(title)
           << " noenhanced at screen 0.5, screen "
           << 1. - 1.3 * canvas.font / canvas.height << " center\n"
           << "unset colorbox\n";
    for (std::size_t i = 0; i < panels.size(); ++i)
      {
        if (i + 1 == panels.size())
          script << "\nset colorbox horizontal user origin screen "
                 << 0.5 - 0.5 * layout.bar_width / canvas.width << ", screen "
                 << 4. * canvas.font / canvas.height << " size screen "
                 << layout.bar_width / canvas.width << ", screen "
                 << 0.75 * canvas.font / canvas.height << "\n";
        write_panel(script, *this, layout, i);
        if (i == 0)
          script << "unset label 999\n";
      }
    script << "\nunset multiplot\nset output\n";
  }


  double
  ParticlePicture::depth(const Point<3> &point)
  {
    return point * Projection::to_the_eye;
  }
} // namespace emmy
