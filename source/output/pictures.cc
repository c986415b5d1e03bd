#include <emmy/base/whole_file.h>
#include <emmy/output/energy_pictures.h>
#include <emmy/output/force_picture.h>
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

    /** The file of a snapshot's particles or surfaces. */
    std::string
    snapshot_name(const std::string &of, const std::size_t number)
    {
      return of + "_" + dealii::Utilities::to_string(number, 2) + ".dat";
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

    const std::string file =
      snapshot_name("particles", particles.panels.size());
    std::ofstream out(fs::path(folder) / file);
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
    particles.panels.push_back({time, positions.empty() ? "" : file, ""});
    if (!out.flush())
      cannot_write(file);
  }


  template <int dim>
  void
  Pictures::add_surfaces(const std::vector<Surface<dim>> &surfaces)
  {
    if (surfaces.empty())
      return;
    const std::string file =
      snapshot_name("surfaces", particles.panels.size() - 1);
    std::ofstream out(fs::path(folder) / file);
    for (const Surface<dim> &surface : surfaces)
      for (const auto &facet : surface.facets)
        {
          for (const Point<dim> &vertex : facet)
            out << vertex << "\n";
          out << "\n";
        }
    if (!out.flush())
      cannot_write(file);
    particles.panels.back().surfaces = file;
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
      result.insert(result.end(),
                    {panel.time,
                     panel.file.empty() ? 0. : 1.,
                     panel.surfaces.empty() ? 0. : 1.});
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
        const double time      = next();
        const auto   number_of = particles.panels.size();
        const auto   name      = [&](const char *of) {
          return next() != 0. ? snapshot_name(of, number_of) : "";
        };
        const std::string of_particles = name("particles");
        particles.panels.push_back({time, of_particles, name("surfaces")});
      }
  }


  std::vector<std::string>
  Pictures::draw(const std::string &value_label)
  {
    std::vector<std::string> scripts;
    const auto write = [&](const std::string &name, const auto &write_script) {
      std::ofstream script(fs::path(folder) / (name + ".gp"));
      write_script(script);
      if (!script.flush())
        cannot_write(name + ".gp");
      scripts.push_back(name);
    };
    const auto columns = ledger_columns();
    const auto has     = [&](const char *name) {
      return std::find(columns.begin(), columns.end(), name) != columns.end();
    };
    if (has("time") && has("kinetic_energy") && has("strain_energy"))
      {
        write("energies", [&](std::ostream &script) {
          write_energies_script(script, title, columns);
        });
        if (has("balance_error"))
          write("balance_error", [&](std::ostream &script) {
            write_balance_error_script(script, title, columns);
          });
      }
    else
      warnings.push_back("there is no ledger.csv with the columns time, "
                         "kinetic_energy and strain_energy in " +
                         directory + ": energies were not drawn");
    for (const ForcePicture &force : force_pictures(columns))
      write(force.name,
            [&](std::ostream &script) { force.write_script(script, title); });
    if (!particles.panels.empty())
      {
        arrange_particles(value_label);
        write("particles",
              [&](std::ostream &script) { particles.write_script(script); });
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
  Pictures::arrange_particles(const std::string &value_label)
  {
    particles.title       = title;
    particles.value_label = value_label;

    particles.choose_colours(folder);
    // The cells that any snapshot touches, and some air around it.
    for (unsigned int d = 0; d < particles.dim; ++d)
      {
        const double h      = particles.line_distance[d];
        const bool   is_any = lowest[d] <= highest[d];
        const double from   = is_any ? lowest[d] : grid_lower[d];
        const double to     = is_any ? highest[d] : grid_upper[d];
        // discs reach beyond their middles
        const double margin =
          std::max({0.04 * (to - from), 0.1 * h, 0.55 * particles.spacing});
        const auto on_line = [&](const double x) {
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
  }


  void
  Pictures::cannot_write(const std::string &file)
  {
    warnings.push_back(emmy::cannot_write((fs::path(folder) / file).string()) +
                       ": check that the disk is not full");
  }


  template void
  Pictures::add_surfaces(const std::vector<Surface<2>> &);
  template void
  Pictures::add_surfaces(const std::vector<Surface<3>> &);
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
