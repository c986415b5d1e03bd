// The scenes of prm/ground against their right values: columns at rest, found
// by static steps, and what they do in time; a triaxial test; a heavy block
// whose waves leave; a footing that vibrates; a slope and its factor of safety;
// columns of sand that collapse.
//
//   test_ground              a short form of some, within seconds
//   test_ground NAME         all of columns, vibration, slope or collapse
//   test_ground all          everything: some minutes
//   test_ground collapse Section/Entry=value ...
//                            with other settings: printed, not judged

#include <deal.II/base/mpi.h>

#include <emmy/base/text.h>
#include <emmy/output/particle_fields.h>
#include <emmy/run/run.h>
#include <emmy/run/scene_parameters.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <sstream>

#include <unistd.h>

#include "../scene.h"
#include "turned_lattice.h"

using namespace emmy;
using dealii::Point;
using test::check;
using test::check_close;
using Settings = std::vector<std::string>;

namespace
{
  constexpr double pi = dealii::numbers::PI;

  ParameterFile
  with(ParameterFile result, const Settings &settings)
  {
    for (const std::string &setting : settings)
      result.set(setting);
    return result;
  }

  std::string
  path_of(const std::string &name)
  {
    return EMMY_SOURCE_DIR "/prm/ground/" + name + ".prm";
  }

  ParameterFile
  scene_file(const std::string &name, const Settings &settings)
  {
    return with(ParameterFile(path_of(name)), settings);
  }

  /** A folder for what this run of the test writes. */
  std::string
  folder()
  {
    const auto path = std::filesystem::temp_directory_path() /
                      ("emmy-test-ground-" + std::to_string(getpid()));
    std::filesystem::create_directories(path);
    return path.string();
  }

  // --------------------------------------------------------- columns at rest

  constexpr double height = 10., gravity = 2.5, density = 1000.;

  /**
   * A column of prm/ground/column.prm, of one cell across; or of four, with
   * points on a lattice that is turned by 30 degrees, and as many.
   */
  struct Column
  {
    unsigned int n_cells; ///< over 12 m
    bool         is_turned;

    double
    width() const
    {
      return (is_turned ? 4 : 1) * 12. / n_cells;
    }

    std::string
    name() const
    {
      return std::to_string(n_cells) + " cells" +
             (is_turned ? ", points turned by 30 degrees" : "");
    }

    /** The scene of prm/ground with this column. */
    ParameterFile
    file() const;
  };

  ParameterFile
  Column::file() const
  {
    std::ostringstream text;
    text << std::ifstream(path_of("column")).rdbuf();
    std::string       scene = text.str();
    const std::string wide  = shortest(width());
    const Settings    settings{"Grid/Cells=" +
                              std::string(is_turned ? "4, " : "1, ") +
                              std::to_string(n_cells),
                            "Grid/Upper corner=" + wide + ", 12",
                            "Checkpoint/Every steps=1",
                            "Output/Report=false",
                            "Output/Pictures=false",
                            "Output/Frames=0"};
    if (!is_turned)
      return with(with(ParameterFile::from_text(scene, name()), settings),
                  {"Bodies/b/box/Upper corner=" + wide + ", 10"});

    const std::string table = folder() + "/points.csv";
    std::ofstream     out(table);
    out << "x, y, volume\n" << std::setprecision(17);
    for (const auto &p : test::turned_lattice(
           Point<2>(0., 0.), Point<2>(width(), height), 6. / n_cells, pi / 6.))
      out << p[0] << ", " << p[1] << ", " << 36. / n_cells / n_cells << '\n';
    scene.replace(scene.find("Shape = box"), 11, "Shape = particles");
    const auto box = scene.find("    subsection box");
    scene.replace(box,
                  scene.find("    end", box) - box,
                  "    subsection particles\n      set File = " + table + "\n");
    return with(with(ParameterFile::from_text(scene, name()), settings),
                {"Bodies/b/Cut by=x-min, x-max, y-min"});
  }

  /** The larger of two; NaN if one is. */
  double
  larger(const double a, const double b)
  {
    return b <= a || std::isnan(a) ? a : b;
  }

  /** The largest value of a column of a ledger's file, and its length. */
  std::pair<double, unsigned int>
  largest_in(const std::string &path, const std::string &column)
  {
    std::ifstream file(path);
    std::string   line, cell;
    std::getline(file, line);
    std::istringstream head(line);
    unsigned int       position = 0, rows = 0;
    while (std::getline(head, cell, ',') && cell != column)
      ++position;
    check(cell == column, path + ": no column " + column);
    double result = 0.;
    for (; std::getline(file, line); ++rows)
      {
        std::istringstream row(line);
        for (unsigned int i = 0; i <= position; ++i)
          std::getline(row, cell, ',');
        result = larger(result, std::stod(cell));
      }
    return {result, rows};
  }

  /** Of stress off -rho g times the height of undeformed material above, over
   * rho g times the height of the column. */
  struct StressError
  {
    double worst = 0., mean = 0.; ///< of particles, without signs
    double inside   = 0.;         ///< worst beyond a cell of all sides
    double of_metre = 0.;         ///< worst of the means of each metre
  };

  StressError
  error_of_stress(const Scene<2> &scene, const Column &column)
  {
    const double             cell = 12. / column.n_cells;
    StressError              result;
    std::array<double, 10>   sum{};
    std::array<unsigned, 10> n{};
    for (const auto &particle : scene.particles)
      {
        std::vector<double> stress, u;
        scene.written_fields[0].append(particle, stress);
        scene.written_fields[2].append(particle, u);
        const double place = particle.get_location()[1] - u[1];
        const double error =
          (stress[4] / (density * gravity) + height - place) / height;
        result.worst = larger(result.worst, std::abs(error));
        result.mean += std::abs(error) / scene.particles.n_global_particles();
        const double x = particle.get_location()[0] - u[0];
        if (std::min({x, column.width() - x, place, height - place}) > cell)
          result.inside = larger(result.inside, std::abs(error));
        const unsigned int metre = std::min(9., std::max(0., place));
        sum[metre] += error;
        ++n[metre];
      }
    for (unsigned int i = 0; i < sum.size(); ++i)
      result.of_metre = larger(result.of_metre, std::abs(sum[i] / n[i]));
    return result;
  }

  /**
   * At rest by static steps, then in time.
   * The stress of each particle is right to 1 %; where particles are turned
   * they overlap and leave gaps, and that of each metre is.
   */
  void
  check_column(const Column &column, const unsigned int n_steps)
  {
    const std::string at_rest = folder() + "/rest",
                      in_time = folder() + "/time";
    const ParameterFile file  = column.file();
    RunOptions          options;
    options.overwrite = options.is_quiet = true;
    run<2>(with(file, {"Output/Directory=" + at_rest}),
           options,
           MPI_COMM_WORLD);
    const auto [most, rows] =
      largest_in(at_rest + "/ledger.csv", "newton_iterations");

    const SceneParameters<2> parameters(
      with(file,
           {"Start/From=" + at_rest,
            "Output/Directory=" + in_time,
            "Time/Integrator=implicit",
            "Time/Step rule=fixed",
            "Time/Step size=" + shortest(1.2 / column.n_cells),
            "Time/End time=1e9"}));
    test::RunningScene<2> run(parameters);
    run.most_residual_work   = 1.; // there is nothing but round-off
    const StressError error  = error_of_stress(run.scene, column);
    const double      stored = run.ledger["strain_energy"];
    run.advance(n_steps);
    const double moves = test::largest(run.column("kinetic_energy")) / stored;
    std::cout << column.name() << ": " << rows - 1 << " increments, at most "
              << most << " iterations; stress off by "
              << brief(100. * error.worst) << " % of that at the foot, "
              << brief(100. * error.inside) << " % beyond a cell of all sides, "
              << brief(100. * error.mean) << " % in the mean, "
              << brief(100. * error.of_metre)
              << " % in the mean of a metre; in " << n_steps
              << " steps kinetic energy / stored " << brief(moves) << std::endl;
    check(rows == 11 && most <= 4.,
          column.name() + ": 10 increments, 4 iterations in each");
    check((column.is_turned ? error.of_metre : error.worst) <= 0.01,
          column.name() + ": stress");
    check(moves <= 1e-10, column.name() + ": at rest");
    std::filesystem::remove_all(folder());
  }

  // ---------------------------------------------------------------- elements

  void
  check_triaxial()
  {
    const SceneParameters<3> parameters(scene_file("triaxial", {}));
    test::RunningScene<3>    run(parameters);
    run.most_residual_work = 1e-6;
    run.advance_to(1.);
    const double beside = run.ledger["cube_cauchy_stress_xx"],
                 above  = run.ledger["cube_cauchy_stress_zz"];
    std::cout << "triaxial: " << beside << " Pa beside, " << above
              << " Pa above, ratio - 3 = " << above / beside - 3. << std::endl;
    check_close(above / beside, 3., 1e-10, "triaxial: strength");
    check_close(beside, -1e5, 0.01 * 1e5, "triaxial: pressure at the sides");
    check(std::abs(run.ledger["balance_error"]) <
            1e-12 * run.ledger["reaction_work"],
          "triaxial: balance");
  }

  void
  check_block()
  {
    const SceneParameters<2> parameters(scene_file("block", {}));
    test::RunningScene<2>    run(parameters);
    run.advance_to(0.1 - 1e-9);
    const double sunk = 0.5 - run.ledger["block_y"],
                 out  = run.ledger["radiated_energy"];
    std::cout << "block: sinks by " << 1e3 * sunk << " mm (right 1.283), "
              << out << " of 40 J leave" << std::endl;
    check_close(sunk, 1.283e-3, 0.01 * 1.283e-3, "block: it sinks");
    check_close(out, 40., 0.02 * 40., "block: waves leave");
    check(std::abs(run.ledger["balance_error"]) < 1e-12 * 40.,
          "block: balance");
  }

  /**
   * Lamb's half-plane below a strip of half the width 1 and 1.125 m, N s/m: the
   * test vibrating_strip finds the same.
   */
  constexpr double narrow_strip = 608e3, wide_strip = 692e3;

  /** The power that it radiates, as that of a dashpot. */
  void
  check_vibration()
  {
    const SceneParameters<2> parameters(scene_file("vibrating-footing", {}));
    test::RunningScene<2>    run(parameters);
    run.most_residual_work = 1e-6;
    run.advance_to(5. / 48. - 1e-9);
    const auto         work  = run.column("reaction_work");
    const unsigned int cycle = (work.size() - 1) / 5;
    const double       C =
      (work.back() - work[work.size() - 1 - cycle]) * 48. / (0.5 * 0.01 * 0.01);
    std::cout << "vibrating footing: " << 1e-3 * C << " kN s/m (right "
              << 1e-3 * narrow_strip << " to " << 1e-3 * wide_strip << ')'
              << std::endl;
    check(C > narrow_strip && C < wide_strip, "vibrating footing: radiation");
    check(std::abs(run.ledger["balance_error"]) < 1e-12 * work.back(),
          "vibrating footing: balance");
  }

  // ------------------------------------------------------------------- slope

  /** How far the crest comes down with its strength over @p factor, m. */
  double
  settlement_of_slope(const double factor)
  {
    const double             tangent = std::tan(20. * pi / 180.) / factor;
    const SceneParameters<2> parameters(
      scene_file("slope",
                 {"Materials/soil/Cohesion=" + shortest(1e4 / factor),
                  "Materials/soil/Friction angle=" +
                    shortest(std::atan(tangent) * 180. / pi)}));
    test::RunningScene<2> run(parameters);
    run.most_residual_work = 1e-3;
    run.advance_to(1. - 1e-9);
    const double result = -run.ledger["crest_displacement_y"];
    std::cout << "slope, strength over " << factor << ": the crest settles by "
              << 1e3 * result << " mm" << std::endl;
    return result;
  }

  void
  check_slope()
  {
    const double stable = settlement_of_slope(1.);
    check(settlement_of_slope(1.3) < 2. * stable, "slope: it stands at 1.3");
    check(settlement_of_slope(1.4) < 10. * stable, "slope: it stands at 1.4");
    check(settlement_of_slope(1.45) > 10. * stable, "slope: it fails at 1.45");
  }

  // ---------------------------------------------------------------- collapse

  /**
   * @param a height of the column over its width, 1 m
   * @param more with which it is another scene, which is not judged
   */
  void
  check_collapse(const double a, const Settings &more)
  {
    Settings settings = {"Bodies/column/box/Upper corner=1, " + shortest(a)};
    settings.insert(settings.end(), more.begin(), more.end());
    const SceneParameters<2> parameters(scene_file("collapse", settings));
    test::RunningScene<2>    run(parameters);
    run.advance_to(1.6 - 1e-9);
    std::vector<double> places;
    for (const auto &particle : run.scene.particles)
      places.push_back(particle.get_location()[0]);
    std::sort(places.begin(), places.end());
    const double spacing = std::sqrt(a / places.size());
    const double front   = places.back() + 0.5 * spacing - 1.,
                 most    = places[std::size_t(0.99 * places.size())] - 1.,
                 work    = run.ledger["load_work"];
    std::cout << "collapse, a = " << a << ": the front is " << front
              << " m away (right " << 1.2 * a << "), 99 % of the mass within "
              << most << " m; of the work of gravity flow dissipates "
              << run.ledger["plastic_dissipation"] / work << ", PIC "
              << run.ledger["mapping_loss"] / work << ", the update of stress "
              << run.ledger["stress_update_loss"] / work << ", what moves has "
              << run.ledger["kinetic_energy"] / work << std::endl;
    if (more.empty())
      check_close(front, 1.2 * a, 0.15 * 1.2 * a, "collapse: run-out");
    check(run.ledger["kinetic_energy"] < 1e-3 * work, "collapse: at rest");
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::string                        what     = argc > 1 ? argv[1] : "";
  bool                                     is_known = what.empty();
  const auto                               asked    = [&](const char *name) {
    is_known = is_known || what == name || what == "all";
    return what == name || what == "all";
  };
  if (what.empty())
    {
      check_column({96, false}, 50);
      check_column({96, true}, 10);
    }
  if (what.empty() || what == "all")
    {
      check_triaxial();
      check_block();
    }
  if (asked("columns"))
    for (const bool is_turned : {false, true})
      for (const unsigned int n_cells : {96, 192, 384})
        check_column({n_cells, is_turned}, 1000);
  if (asked("vibration"))
    check_vibration();
  if (asked("slope"))
    check_slope();
  if (asked("collapse"))
    for (const double a : {0.5, 1., 2.})
      check_collapse(a, Settings(argv + std::min(argc, 2), argv + argc));
  check(is_known, "a known name: columns, vibration, slope, collapse or all");
  return test::report();
}
