#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/base/whole_file.h>
#include <emmy/output/gnuplot.h>
#include <emmy/study/study_pictures.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace emmy
{
  namespace
  {
    // Colours of Okabe and Ito, which the colour-blind can tell apart.
    const std::vector<std::string> colours = {"#0072b2",
                                              "#d55e00",
                                              "#009e73",
                                              "#cc79a7",
                                              "#e69f00",
                                              "#56b4e9",
                                              "#000000"};
    const std::vector<int>         points  = {7, 5, 9, 13, 6, 4, 8, 12};
    const std::vector<std::string> dashes  = {"1",
                                              "(10,4)",
                                              "(3,3)",
                                              "(10,3,2,3)"};

    /** Position of a member's value in its list. */
    unsigned int
    position(const StudyPlan   &plan,
             const unsigned int list,
             const unsigned int member)
    {
      return plan.lists[list].position(plan.members[member].values[list]);
    }

    /** What the members of a curve look like. */
    std::string
    style(const StudyPlan &plan, const StudyCurve &curve)
    {
      std::vector<unsigned int> choice, n_values;
      for (unsigned int i = 0; i < plan.lists.size(); ++i)
        if (i != plan.refined_list && plan.lists[i].varies() &&
            !(plan.is_paired && plan.has_sizes()))
          {
            choice.push_back(position(plan, i, curve.members[0]));
            n_values.push_back(plan.lists[i].values.size());
          }
      choice.resize(std::max<std::size_t>(choice.size(), 1), 0);
      if (!plan.has_sizes() && choice.size() > 2)
        {
          // single points have no dashes: a colour for each setting of all
          // lists but the last
          unsigned int setting = 0;
          for (std::size_t i = 0; i + 1 < choice.size(); ++i)
            setting = setting * n_values[i] + choice[i];
          choice = {setting, choice.back()};
        }
      const unsigned int colour = choice[0] % colours.size();
      const unsigned int point =
        (choice.size() > 1 ? choice[1] : choice[0]) % points.size();
      const unsigned int dash =
        (choice.size() > 2 ? choice[2] : 0) % dashes.size();
      return "lc rgb '" + colours[colour] + "' pt " +
             std::to_string(points[point]) + " dt " + dashes[dash];
    }

    bool
    can_draw(const double value)
    {
      return value > 0. && std::isfinite(value);
    }

    /** From @p low to @p high on a logarithmic axis, with room about it. */
    void
    set_axis(std::ostream &script,
             const char   *axis,
             const double  low,
             const double  high,
             const double  room)
    {
      const double        first = low / room, last = high * room;
      std::vector<double> tics;
      const int           every = 1 + std::log10(last / first) / 8.;
      for (int power = std::floor(std::log10(first));
           power <= std::ceil(std::log10(last));
           ++power)
        for (const double digit : {1., 2., 5.})
          {
            const double tic = digit * std::pow(10., power);
            if ((digit == 1. || last / first < 50.) && power % every == 0 &&
                tic >= first && tic <= last)
              tics.push_back(tic);
          }
      script << "set " << axis << "range [" << first << ':' << last << "]\nset "
             << axis << "tics (";
      for (std::size_t i = 0; i < tics.size(); ++i)
        script << (i > 0 ? ", '" : "'") << gnuplot::number(tics[i]) << "' "
               << tics[i];
      script << ")\n";
    }

    /** One of the two pictures: a panel for each quantity, and a key. */
    class Picture
    {
    public:
      Picture(const StudyPlan  &plan,
              const StudyTable &table,
              const bool        is_over_size);

      const std::string name;

      void
      write(std::ostream &script) const;

    private:
      double
      abscissa(const unsigned int m) const
      {
        return is_over_size ? size_of(plan, m) : table.seconds(m);
      }

      /** Of seconds and error: what no member does better. */
      std::vector<std::pair<double, double>>
      front(const unsigned int q) const;
      void
      write_data(std::ostream &script, const unsigned int q) const;
      void
      write_panel(std::ostream &script, const unsigned int q) const;
      void
      write_key(std::ostream &script) const;
      std::string
      key_of(const StudyCurve &curve) const;
      /** Lines of order 1 and 2 below the curves, as gnuplot plots them. */
      static std::string
      guides(const double least_size,
             const double most_size,
             const double least_error);

      const StudyPlan              &plan;
      const StudyTable             &table;
      const bool                    is_over_size;
      const std::vector<StudyCurve> curves;
      const unsigned int            n_columns, n_rows, n_key_columns;
      gnuplot::Canvas               canvas;
      double                        title_height, key_height; ///< pixels
    };

    Picture::Picture(const StudyPlan  &plan,
                     const StudyTable &table,
                     const bool        is_over_size)
      : name(is_over_size ? "error-size" : "error-seconds")
      , plan(plan)
      , table(table)
      , is_over_size(is_over_size)
      , curves(study_curves(plan))
      , n_columns(plan.quantities.size() > 1 ? 2 : 1)
      , n_rows((plan.quantities.size() + n_columns - 1) / n_columns)
      , n_key_columns(curves.size() > 3 ? 2 : 1)
      , title_height(2.2 * canvas.font)
      , key_height(1.4 * canvas.font *
                   ((curves.size() + n_key_columns) / n_key_columns + 1))
    {
      canvas.height =
        title_height + n_rows * (n_columns == 1 ? 1000. : 800.) + key_height;
    }

    void
    Picture::write(std::ostream &script) const
    {
      gnuplot::write_preamble(script, name, canvas);
      for (unsigned int q = 0; q < plan.quantities.size(); ++q)
        write_data(script, q);
      script << "set multiplot title " << gnuplot::quoted(plan.title)
             << " noenhanced\n"
             << "set logscale xy\nset grid lc rgb '#b8b8b8' lw 0.5 dt 1\n"
             << "set border lw 0.6\n"
             << "set xlabel "
             << gnuplot::quoted(is_over_size
                                  ? plan.lists[plan.refined_list].label
                                  : "seconds of a run")
             << " noenhanced\n";
      script << "unset key\n";
      for (unsigned int q = 0; q < plan.quantities.size(); ++q)
        write_panel(script, q);
      write_key(script);
      script << "unset multiplot\n";
    }

    /** None, where the best have an error of 0. */
    std::vector<std::pair<double, double>>
    Picture::front(const unsigned int q) const
    {
      const std::vector<double> seconds = table.all_seconds();
      const std::vector<double> errors  = table.errors(q);
      const std::vector<bool>   is_best = pareto_front(seconds, errors);
      std::vector<std::pair<double, double>> result;
      for (unsigned int m = 0; m < seconds.size(); ++m)
        if (is_best[m] && can_draw(seconds[m]) && can_draw(errors[m]))
          result.emplace_back(seconds[m], errors[m]);
      std::sort(result.begin(), result.end());
      return result;
    }

    /** Per quantity a block for each curve, and one of the front. */
    void
    Picture::write_data(std::ostream &script, const unsigned int q) const
    {
      for (unsigned int c = 0; c < curves.size(); ++c)
        {
          script << "$q" << q << "c" << c << " << EOD\n";
          for (const unsigned int m : curves[c].members)
            if (can_draw(abscissa(m)) && can_draw(table.error(m, q)))
              script << abscissa(m) << ' ' << table.error(m, q) << '\n';
          script << "EOD\n";
        }
      script << "$front" << q << " << EOD\n";
      for (const auto &[x, y] : front(q))
        script << x << ' ' << y << '\n';
      script << "EOD\n";
    }

    void
    Picture::write_panel(std::ostream &script, const unsigned int q) const
    {
      const double width = canvas.width / n_columns;
      const double height =
        (canvas.height - title_height - key_height) / n_rows;
      const double left   = q % n_columns * width;
      const double top    = title_height + q / n_columns * height;
      const auto   margin = [&script](const char *side, const double share) {
        script << "set " << side << "margin at screen " << share << '\n';
      };
      margin("l", (left + 5.2 * canvas.font) / canvas.width);
      margin("r", (left + width - 1.2 * canvas.font) / canvas.width);
      margin("t", 1. - (top + 2.2 * canvas.font) / canvas.height);
      margin("b", 1. - (top + height - 3.6 * canvas.font) / canvas.height);
      script << "set title "
             << gnuplot::quoted("error of " + plan.quantities[q].words)
             << " noenhanced\n";
      std::vector<double> x, y;
      for (unsigned int m = 0; m < plan.members.size(); ++m)
        if (can_draw(abscissa(m)) && can_draw(table.error(m, q)))
          {
            x.push_back(abscissa(m));
            y.push_back(table.error(m, q));
          }
      if (x.empty())
        {
          script << "set label 1 'no member has a known, positive error' at "
                    "graph 0.5, graph 0.5 center\n"
                 << "plot [0.1:1] [0.1:1] NaN\nunset label 1\n";
          return;
        }
      const auto [least_x, most_x] = std::minmax_element(x.begin(), x.end());
      const auto [least_y, most_y] = std::minmax_element(y.begin(), y.end());
      set_axis(script, "x", *least_x, *most_x, plan.has_sizes() ? 1.2 : 2.);
      set_axis(script, "y", *least_y, *most_y, 1.5);
      std::string       plots;
      const std::string block = "$q" + std::to_string(q) + "c";
      if (!is_over_size && !front(q).empty())
        plots = ", $front" + std::to_string(q) +
                " using 1:2 with lines lc rgb '#c8c8c8' lw 5";
      for (unsigned int c = 0; c < curves.size(); ++c)
        {
          const std::string data = block + std::to_string(c);
          plots += ", " + data + " using 1:2 with linespoints " +
                   style(plan, curves[c]);
        }
      if (is_over_size) // behind curves: in front their range is the axis'
        plots += guides(*least_x, *most_x, *least_y);
      script << "plot " << plots.substr(2) << '\n';
    }

    std::string
    Picture::guides(const double least_size,
                    const double most_size,
                    const double least_error)
    {
      if (least_size == most_size)
        return {};
      std::string result;
      for (const int order : {1, 2})
        {
          std::ostringstream plot;
          plot << ", [" << least_size << ':' << most_size << "] " << least_error
               << "*(x/" << least_size << ")**" << order
               << " with lines lc rgb '#909090' lw 0.8 dt "
               << (order == 1 ? "(2,4)" : "(8,4)");
          result += plot.str();
        }
      return result;
    }

    /** Single points are many: their values without the names of lists. */
    std::string
    Picture::key_of(const StudyCurve &curve) const
    {
      if (plan.has_sizes())
        return curve.name.empty() ? "members" : curve.name;
      std::vector<std::string> values;
      for (unsigned int i = 0; i < plan.lists.size(); ++i)
        if (plan.lists[i].varies())
          values.push_back(plan.members[curve.members[0]].values[i]);
      return join(values);
    }

    void
    Picture::write_key(std::ostream &script) const
    {
      script << "unset title\nunset xlabel\nunset xtics\nunset ytics\n"
             << "unset border\nunset grid\nunset logscale\n"
             << "set lmargin at screen 0.02\nset rmargin at screen 0.98\n"
             << "set bmargin at screen 0.005\nset tmargin at screen "
             << key_height / canvas.height << "\nset key center center maxcols "
             << n_key_columns
             << " noenhanced spacing 1.2 samplen 3\nplot [0:1] [0:1] ";
      for (const StudyCurve &curve : curves)
        script << "NaN with linespoints " << style(plan, curve) << " title "
               << gnuplot::quoted(key_of(curve)) << ", ";
      if (is_over_size)
        script << "NaN with lines lc rgb '#909090' lw 0.8 dt (2,4) title "
                  "'order 1', NaN with lines lc rgb '#909090' lw 0.8 dt (8,4) "
                  "title 'order 2'\n";
      else
        script << "NaN with lines lc rgb '#c8c8c8' lw 5 title 'the best: no "
                  "other has less of both'\n";
    }
  } // namespace


  std::vector<std::string>
  draw_study(const StudyPlan &plan, const StudyTable &table)
  {
    std::vector<std::string> warnings;
    for (const bool is_over_size : {false, true})
      {
        if (plan.quantities.empty() || (is_over_size && !plan.has_sizes()))
          continue;
        const Picture     picture(plan, table, is_over_size);
        const std::string filename =
          plan.directory + "/" + picture.name + ".gp";
        std::ostringstream script;
        script.precision(12);
        picture.write(script);
        const std::string problem = write_whole_file(filename, script.str());
        AssertThrow(problem.empty(), ExcRun("Study", problem, file_remedy));
        switch (gnuplot::run(plan.directory, picture.name))
          {
            case gnuplot::Outcome::drawn:
              break;
            case gnuplot::Outcome::not_installed:
              warnings.push_back(picture.name +
                                 ".png is not drawn: gnuplot is not "
                                 "installed; the script is there.");
              break;
            case gnuplot::Outcome::failed:
              warnings.push_back(picture.name + ".png is not drawn: see " +
                                 plan.directory + "/gnuplot.log.");
          }
      }
    return warnings;
  }
} // namespace emmy
