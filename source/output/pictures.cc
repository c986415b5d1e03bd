#include <emmy/base/whole_file.h>
#include <emmy/output/gnuplot.h>
#include <emmy/output/pictures.h>

#include <deal.II/base/utilities.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <limits>
#include <numeric>
#include <tuple>

namespace emmy
{
  namespace
  {
    namespace fs = std::filesystem;
    using dealii::Point;

    /** A column of the ledger and how its curve is drawn. */
    struct Curve
    {
      const char *column, *name, *style;
    };

    // Colours of Okabe and Ito, which the colour-blind can tell apart. The
    // energies of the body, then where energy went; they add up to "total".
    const std::vector<Curve> energies = {
      {"kinetic_energy", "kinetic", "lc rgb '#0072b2'"},
      {"strain_energy", "strain", "lc rgb '#d55e00'"},
      {"hardening_energy", "hardening", "lc rgb '#cc79a7'"},
      {"contact_energy", "contact", "lc rgb '#e69f00'"},
      {"friction_energy", "friction, stored", "lc rgb '#56b4e9'"},
      {"friction_dissipation",
       "friction, dissipated",
       "lc rgb '#56b4e9' dt (4,4)"},
      {"plastic_dissipation", "plastic dissipation", "lc rgb '#009e73'"},
      {"stress_rule_loss", "stress rule loss", "lc rgb '#d55e00' dt (10,4)"},
      {"lumping_loss", "lumping loss", "lc rgb '#e69f00' dt (10,4)"},
      {"mapping_loss", "mapping loss", "lc rgb '#56b4e9' dt (10,4)"},
      {"wall_loss", "wall loss", "lc rgb '#0072b2' dt (10,4)"},
      {"ghost_mass_loss", "ghost mass loss", "lc rgb '#cc79a7' dt (4,4)"},
      {"ghost_stiffness_loss",
       "ghost stiffness loss",
       "lc rgb '#009e73' dt (4,4)"}};

    /** The file of the particles of a snapshot. */
    std::string
    snapshot_name(const std::size_t number)
    {
      return "particles_" + dealii::Utilities::to_string(number, 2) + ".dat";
    }


    std::vector<Curve>
    present(const std::vector<Curve>       &curves,
            const std::vector<std::string> &columns)
    {
      std::vector<Curve> found;
      for (const Curve &curve : curves)
        if (std::find(columns.begin(), columns.end(), curve.column) !=
            columns.end())
          found.push_back(curve);
      return found;
    }


    /**
     * The columns of what was brought in from outside: works of loads, of
     * what holds unknowns, of tools; not what solves left.
     */
    std::vector<std::string>
    works_among(const std::vector<std::string> &columns)
    {
      const std::string        ending = "_work";
      std::vector<std::string> found;
      for (const std::string &column : columns)
        if (column.size() > ending.size() && column != "residual_work" &&
            column.compare(column.size() - ending.size(),
                           ending.size(),
                           ending) == 0)
          found.push_back(column);
      return found;
    }


    /** The sum of the columns as a gnuplot expression; 0 of none. */
    std::string
    sum(const std::vector<std::string> &columns)
    {
      std::string terms = "0";
      for (const std::string &column : columns)
        terms += " + column('" + column + "')";
      return terms;
    }


    std::string
    sum(const std::vector<Curve> &curves)
    {
      std::vector<std::string> columns;
      for (const Curve &curve : curves)
        columns.push_back(curve.column);
      return sum(columns);
    }


    /**
     * How curves over time look below a key with so many rows, and the energy
     * at the start of the run.
     */
    void
    write_frame(std::ostream             &script,
                const std::string        &title,
                const std::vector<Curve> &stored,
                const unsigned int        n_key_rows)
    {
      script << "set datafile separator comma\n"
             << "set datafile columnheaders\n"
             << "ledger = '../ledger.csv'\n"
             << "stats ledger using (" << sum(stored)
             << ") every ::0::0 nooutput name 'first'\n"
             << "stats ledger using (" << sum(stored)
             << ") nooutput name 'all'\n"
             << "initial = first_max\n\n"
             << "set label 1 " << gnuplot::quoted(title)
             << " noenhanced at screen 0.5, screen 0.965 center\n"
             << "set tmargin " << (title.empty() ? 1.2 : 3.) + 1.25 * n_key_rows
             << "\n"
             << "set border 3 lw 0.6 lc rgb '#404040'\n"
             << "set tics out nomirror scale 0.5\n"
             << "set grid xtics ytics back lt 1 lw 0.4 lc rgb '#e2e2e2'\n"
             << "set xlabel 'time (s)'\n"
             << "set autoscale xfix\n"
             << "set rmargin 5\n";
    }


    /**
     * Median distance of a point to its nearest neighbour; from a few hundred
     * points against all, which is enough to size the dots of a picture.
     */
    template <int dim>
    double
    typical_spacing(const std::vector<Point<dim>> &points)
    {
      std::vector<double> nearest;
      const std::size_t   stride = points.size() / 200 + 1;
      for (std::size_t i = 0; i < points.size(); i += stride)
        {
          double least = std::numeric_limits<double>::max();
          for (std::size_t j = 0; j < points.size(); ++j)
            if (j != i)
              least = std::min(least, points[i].distance_square(points[j]));
          nearest.push_back(std::sqrt(least));
        }
      const auto middle = nearest.begin() + nearest.size() / 2;
      std::nth_element(nearest.begin(), middle, nearest.end());
      return *middle;
    }
  } // namespace


  Pictures::Pictures(const std::string &directory, const std::string &title)
    : directory(directory)
    , folder((fs::path(directory) / "pictures").string())
    , title(title)
  {
    std::error_code ignored; // the first file that cannot be written tells
    fs::create_directory(folder, ignored);
    particles.spacing  = 0.; // not known yet
    particles.smallest = std::numeric_limits<double>::max();
    particles.largest  = std::numeric_limits<double>::lowest();
  }


  template <int dim>
  void
  Pictures::add_snapshot(const double                     time,
                         const std::vector<Point<dim>>   &positions,
                         const std::vector<double>       &values,
                         const Point<dim>                &lower,
                         const Point<dim>                &upper,
                         const std::vector<unsigned int> &n_cells)
  {
    AssertDimension(positions.size(), values.size());
    AssertDimension(n_cells.size(), dim);
    if (particles.panels.empty())
      {
        particles.dim = dim;
        for (unsigned int d = 0; d < dim; ++d)
          {
            grid_lower[d]              = lower[d];
            grid_upper[d]              = upper[d];
            particles.line_distance[d] = (upper[d] - lower[d]) / n_cells[d];
            // An empty box, to be widened by the points.
            lowest[d]  = upper[d];
            highest[d] = lower[d];
          }
      }
    if (particles.spacing == 0. && positions.size() > 1)
      particles.spacing = typical_spacing(positions);

    std::vector<std::size_t> order(positions.size());
    std::iota(order.begin(), order.end(), 0);
    if constexpr (dim == 3)
      {
        std::vector<double> depth;
        for (const Point<dim> &position : positions)
          depth.push_back(ParticlePicture::depth(position));
        std::sort(order.begin(), order.end(), [&](auto i, auto j) {
          return depth[i] < depth[j];
        });
      }

    const std::string file = snapshot_name(particles.panels.size());
    std::ofstream     out(fs::path(folder) / file);
    out << "# t = " << time << " s; columns: x y " << (dim == 3 ? "z " : "")
        << "(m) value\n"
        << std::setprecision(8);
    for (const std::size_t i : order)
      {
        out << positions[i] << " " << values[i] << "\n";
        for (unsigned int d = 0; d < dim; ++d)
          {
            lowest[d]  = std::min(lowest[d], positions[i][d]);
            highest[d] = std::max(highest[d], positions[i][d]);
          }
        if (std::isfinite(values[i]))
          {
            particles.smallest = std::min(particles.smallest, values[i]);
            particles.largest  = std::max(particles.largest, values[i]);
          }
      }
    particles.panels.push_back({time, positions.empty() ? "" : file});
    if (!out.flush())
      cannot_write(file);
  }


  std::vector<double>
  Pictures::memory() const
  {
    std::vector<double> result{double(particles.dim),
                               particles.spacing,
                               particles.smallest,
                               particles.largest};
    for (unsigned int d = 0; d < 3; ++d)
      result.insert(result.end(),
                    {grid_lower[d],
                     grid_upper[d],
                     lowest[d],
                     highest[d],
                     particles.line_distance[d]});
    for (const auto &panel : particles.panels)
      result.insert(result.end(), {panel.time, panel.file.empty() ? 0. : 1.});
    return result;
  }


  void
  Pictures::recall(const std::vector<double> &memory)
  {
    auto       number  = memory.begin();
    const auto next    = [&] { return *number++; };
    particles.dim      = next();
    particles.spacing  = next();
    particles.smallest = next();
    particles.largest  = next();
    for (unsigned int d = 0; d < 3; ++d)
      {
        grid_lower[d]              = next();
        grid_upper[d]              = next();
        lowest[d]                  = next();
        highest[d]                 = next();
        particles.line_distance[d] = next();
      }
    particles.panels.clear();
    while (number != memory.end())
      {
        const double time = next();
        particles.panels.push_back(
          {time, next() != 0. ? snapshot_name(particles.panels.size()) : ""});
      }
  }


  std::vector<std::string>
  Pictures::draw(const std::string &value_label)
  {
    std::vector<std::string> scripts;
    const auto               columns = ledger_columns();
    const auto               has     = [&](const char *name) {
      return std::find(columns.begin(), columns.end(), name) != columns.end();
    };
    if (has("time") && has("kinetic_energy") && has("strain_energy"))
      {
        write_energies(columns);
        scripts.push_back("energies");
        if (has("balance_error"))
          {
            write_balance_error(columns);
            scripts.push_back("balance_error");
          }
      }
    else
      warnings.push_back("there is no ledger.csv with the columns time, "
                         "kinetic_energy and strain_energy in " +
                         directory + ": energies were not drawn");
    if (!particles.panels.empty())
      {
        write_particles(value_label);
        scripts.push_back("particles");
      }

    std::error_code ignored;
    fs::remove(fs::path(folder) / "gnuplot.log", ignored);
    for (const std::string &script : scripts)
      {
        const gnuplot::Outcome outcome = gnuplot::run(folder, script);
        if (outcome == gnuplot::Outcome::not_installed)
          {
            warnings.push_back("gnuplot is not installed: pictures were not "
                               "drawn; scripts are in " +
                               folder);
            break;
          }
        if (outcome == gnuplot::Outcome::failed)
          warnings.push_back("gnuplot did not draw " + script +
                             ".png: see gnuplot.log in " + folder);
      }
    return warnings;
  }


  std::vector<std::string>
  Pictures::ledger_columns() const
  {
    std::ifstream ledger(fs::path(directory) / "ledger.csv");
    std::string   header;
    std::getline(ledger, header);
    return dealii::Utilities::split_string_list(header, ',');
  }


  void
  Pictures::write_energies(const std::vector<std::string> &columns)
  {
    const std::vector<Curve>       stored  = present(energies, columns);
    const std::vector<std::string> outside = works_among(columns);
    const std::size_t n_curves = stored.size() + (outside.empty() ? 1 : 2);

    std::ofstream script(fs::path(folder) / "energies.gp");
    gnuplot::write_preamble(script, "energies", gnuplot::Canvas());
    write_frame(script, title, stored, (n_curves + 2) / 3);
    // Round-off below zero shall not open the axis down to the next tic.
    script << "lowest = 0.0\n";
    for (const Curve &curve : stored)
      script << "stats ledger using (column('" << curve.column
             << "')) nooutput name 'one'\n"
             << "lowest = one_min < lowest ? one_min : lowest\n";
    script << "set yrange [(lowest < -1e-4*all_max ? lowest : 0.0):*]\n"
           << "set offsets graph 0, 0, 0.04, 0\n";
    script << "set ylabel 'energy (J)'\n"
           << "set key at screen 0.5, screen " << (title.empty() ? 0.99 : 0.94)
           << " center top horizontal maxcols 3 Left reverse samplen 2\n\n"
           << "plot \\\n";
    if (!outside.empty())
      script << "  ledger using (column('time')):(initial + " << sum(outside)
             << ") with lines lw 3.5 lc rgb '#c8c8c8' "
                "title 'initial + external work', \\\n";
    script << "  ledger using (column('time')):(" << sum(stored)
           << ") with lines lw 1.2 lc rgb '#000000' title 'total'";
    for (const Curve &curve : stored)
      script << ", \\\n  ledger using (column('time')):(column('"
             << curve.column << "')) with lines lw 1.2 " << curve.style
             << " title '" << curve.name << "'";
    script << "\n";
    if (!script.flush())
      cannot_write("energies.gp");
  }


  void
  Pictures::write_balance_error(const std::vector<std::string> &columns)
  {
    const std::vector<Curve> stored = present(energies, columns);

    gnuplot::Canvas canvas;
    canvas.height = 1000.;
    std::ofstream script(fs::path(folder) / "balance_error.gp");
    gnuplot::write_preamble(script, "balance_error", canvas);
    write_frame(script, title, stored, 0);
    script
      << "# A body that starts from rest has no energy to compare with.\n"
      << "at_rest = initial <= 1e-6*all_max\n"
      << "scale = !at_rest ? initial : all_max > 0 ? all_max : 1.0\n"
      << "set ylabel '|balance error| / '.(at_rest ? 'largest' : "
         "'initial').' energy'\n\n"
      << "# Zeros are drawn at the floor.\n"
      << "floored(x) = abs(x)/scale > 1e-18 ? abs(x)/scale : 1e-18\n"
      << "stats ledger using (floored(column('balance_error'))) nooutput "
         "name 'error'\n"
      << "set logscale y\n"
      << "set yrange [7e-19:(error_max > 1e-12 ? 3*error_max : 1e-11)]\n"
      << "set format y '10^{%T}'\nset ytics 1e-18,100\nset mytics 1\n"
      << "unset key\n\n"
      << "plot 1e-12 with lines lw 1 lc rgb '#a8a8a8', \\\n"
      << "  ledger using (column('time')):(floored(column('balance_error'))) "
         "with lines lw 0.5 lc rgb '#99c7e0', \\\n"
      << "  ledger using (column('time')):(floored(column('balance_error'))) "
         "with points pt 7 ps 0.35 lc rgb '#0072b2'\n";
    if (!script.flush())
      cannot_write("balance_error.gp");
  }


  void
  Pictures::write_particles(const std::string &value_label)
  {
    particles.title       = title;
    particles.value_label = value_label;

    particles.choose_colours(folder);
    // The cells that any snapshot touches, and some air around it.
    for (unsigned int d = 0; d < particles.dim; ++d)
      {
        const double h       = particles.line_distance[d];
        const bool   is_any  = lowest[d] <= highest[d];
        const double from    = is_any ? lowest[d] : grid_lower[d];
        const double to      = is_any ? highest[d] : grid_upper[d];
        const double margin  = std::max(0.04 * (to - from), 0.1 * h);
        const auto   on_line = [&](const double x) {
          return std::clamp(grid_lower[d] + h * x,
                            grid_lower[d],
                            grid_upper[d]);
        };
        particles.lower[d] =
          on_line(std::floor((from - margin - grid_lower[d]) / h + 1e-9));
        particles.upper[d] =
          on_line(std::ceil((to + margin - grid_lower[d]) / h - 1e-9));
        if (particles.upper[d] <= particles.lower[d]) // all are outside
          std::tie(particles.lower[d], particles.upper[d]) =
            std::make_pair(grid_lower[d], grid_upper[d]);
      }
    if (particles.spacing == 0.)
      particles.spacing = 0.1 * particles.line_distance[0];

    std::ofstream script(fs::path(folder) / "particles.gp");
    particles.write_script(script);
    if (!script.flush())
      cannot_write("particles.gp");
  }


  void
  Pictures::cannot_write(const std::string &file)
  {
    warnings.push_back(emmy::cannot_write((fs::path(folder) / file).string()) +
                       ": check that the disk is not full");
  }


  template void
  Pictures::add_snapshot<2>(const double,
                            const std::vector<Point<2>> &,
                            const std::vector<double> &,
                            const Point<2> &,
                            const Point<2> &,
                            const std::vector<unsigned int> &);
  template void
  Pictures::add_snapshot<3>(const double,
                            const std::vector<Point<3>> &,
                            const std::vector<double> &,
                            const Point<3> &,
                            const Point<3> &,
                            const std::vector<unsigned int> &);
} // namespace emmy
