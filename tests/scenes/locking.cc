// What the treatment of locking must give, and what it must not spoil: a
// cantilever that can hardly change its volume, a footing on clay, a column
// that flows under its weight, each against the same without the treatment;
// cells of one particle; a slow elastic column; a squeezed lattice, in which
// noise must not grow; a disc that crosses cells.
//
//   test_locking         within a minute
//   test_locking all     the finer grids too: some minutes

#include <deal.II/base/mpi.h>

#include <emmy/base/text.h>
#include <emmy/output/particle_fields.h>
#include <emmy/run/scene_parameters.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>

#include "../scene.h"
#include "pressure_jumps.h"

using namespace emmy;
using dealii::Point;
using test::at_most;
using Settings = std::vector<std::string>;

namespace
{
  ParameterFile
  scene_file(const std::string &name, const Settings &settings)
  {
    ParameterFile result(EMMY_SOURCE_DIR "/prm/" + name);
    for (const std::string &setting : settings)
      result.set(setting);
    return result;
  }

  std::string
  treatment(const std::string &name)
  {
    return "Method/Locking treatment=" + name;
  }

  double
  iterations(const test::RunningScene<2> &run)
  {
    double n = 0.;
    for (const double of_step : run.column("newton_iterations"))
      n += of_step;
    return n / (run.ledger.rows().size() - 1);
  }

  /** Of a value of a column's end and start, and the error of the balance. */
  double
  fallen(const test::RunningScene<2> &run, const std::string &column)
  {
    const auto y = run.column(column);
    return y.front() - y.back();
  }

  void
  check_balance(const test::RunningScene<2> &run, const std::string &work)
  {
    at_most("  balance error / work",
            test::largest(run.column("balance_error")) /
              test::largest(run.column(work)),
            1e-12);
  }

  // ------------------------------------------------------------------------

  /** What the tip of the cantilever has of Timoshenko's deflection. */
  double
  beam(const std::string &method,
       const unsigned int refinement) // of cells of 0.5 m
  {
    const double h = 0.5 / refinement, box = h / 2., E = 1e6, nu = 0.499,
                 P = 400., L = 4., I = 1. / 12., x = L - box / 2.,
                 E_plane = E / (1. - nu * nu), G = 0.5 * E / (1. + nu);
    const SceneParameters<2> parameters(
      scene_file("stability/locking-beam.prm",
                 {treatment(method),
                  "Grid/Cells=" + std::to_string(10 * refinement) + ", " +
                    std::to_string(6 * refinement),
                  "Effects/Point load/Region=x - " + shortest(L - box),
                  "Measurements/tip/Nearest to=" + shortest(x) + ", 1.5"}));
    test::RunningScene<2> run(parameters);
    run.advance_to(6. - 1e-9);
    const double right = P * L * L * L / (3. * E_plane * I) -
                         P * L * L / (2. * E_plane * I) * (L - x) +
                         1.2 * P * L / G;
    const double result = fallen(run, "tip_y") / right;
    std::cout << "cantilever, h " << h << " m, " << method << ": " << result
              << " of the beam's deflection, " << iterations(run)
              << " iterations a step\n";
    check_balance(run, "load_work");
    return result;
  }

  /** Cells of one particle have nothing to average. */
  void
  check_lone_particles()
  {
    std::array<double, 2> tip{};
    for (const unsigned int is_treated : {0, 1})
      {
        // soft, as one point in a cell is: little load
        const SceneParameters<2> parameters(
          scene_file("stability/locking-beam.prm",
                     {treatment(is_treated ? "cell" : "none"),
                      "Bodies/beam/Points per direction=1",
                      "Effects/Point load/Region=x - 3.5",
                      "Effects/Point load/Force=0, -40"}));
        test::RunningScene<2> run(parameters);
        run.advance_to(3. - 1e-9);
        tip[is_treated] = fallen(run, "tip_y");
      }
    std::cout << "cells with one particle: " << tip[0] << " m without, "
              << tip[1] << " m with treatment\n";
    at_most("  difference", std::abs(tip[1] / tip[0] - 1.), 1e-4);
  }

  /** The same at rest, in static steps. */
  void
  check_static()
  {
    ParameterFile beam(EMMY_SOURCE_DIR "/prm/stability/locking-beam.prm");
    for (const char *setting : {"Grid/Cells=20, 12",
                                "Effects/Point load/Region=x - 3.875",
                                "Effects/Point load/Amplitude=1",
                                "Measurements/tip/Nearest to=3.9375, 1.5",
                                "Method/Geometry=start",
                                "Method/Stress rule=end-point",
                                "Time/Integrator=static",
                                "Time/End time=1",
                                "Time/Increments=5"})
      beam.set(setting);
    const SceneParameters<2> parameters(beam);
    test::RunningScene<2>    run(parameters);
    run.advance_to(1. - 1e-9);
    std::cout << "cantilever at rest: falls by " << fallen(run, "tip_y")
              << " m, " << iterations(run) << " iterations an increment\n";
    check_balance(run, "load_work");
    at_most("  iterations an increment", iterations(run), 4.);
    // 0.955 of the beam: its end is held in all directions
    at_most("  off the beam",
            std::abs(fallen(run, "tip_y") / 0.0782 - 1.),
            0.02);
  }

  void
  check_beams(const bool all)
  {
    at_most("  off 1.07", std::abs(beam("cell", 1) - 1.07), 0.02);
    at_most("  off 1.00", std::abs(beam("cell", 2) - 1.), 0.02);
    at_most("  without treatment", beam("none", 2), 0.2);
    if (all)
      at_most("  off 1.00", std::abs(beam("cell", 4) - 1.), 0.02);
    check_lone_particles();
    check_static();
  }

  // ------------------------------------------------------------------------

  // what footing.prm bears, 1000 Pa its undrained strength
  constexpr double failure_load = 1e3 * (2. + dealii::numbers::PI);

  /** Cells farther than 0.4 m from the edge of the footing, where the pressure
   * jumps: a cell of 0.25 m cannot tell a jump from an oscillation. */
  bool
  counts(const test::Cell &cell, const double h)
  {
    return test::centre_of(cell, h).distance(Point<2>(1., 3.)) > 0.4;
  }

  /** Jumps of the mean pressures, over q, of cells with three particles. */
  test::Jumps
  jumps_of_pressure(const test::RunningScene<2> &run, const double h)
  {
    std::map<test::Cell, std::vector<double>> values;
    const ParticleFields<2>                   fields(run.scene.layout);
    const auto                                pressure =
      fields.find({"pressure"}, "Output", "Particle fields").front();
    for (const auto &particle : run.scene.particles)
      {
        const auto &x = particle.get_location();
        pressure.append(particle, values[{int(x[0] / h), int(x[1] / h)}]);
      }
    std::map<test::Cell, double> means;
    for (const auto &[cell, all] : values)
      if (all.size() >= 3 && counts(cell, h))
        means[cell] = std::accumulate(all.begin(), all.end(), 0.) /
                      (all.size() * failure_load);
    return test::jumps_of(means, h);
  }

  /** The same of Prandtl's pressures, where they are known. */
  test::Jumps
  jumps_of_prandtl(const double h)
  {
    std::map<test::Cell, double> pressures;
    for (int i = 0; i * h < 5.; ++i)
      for (int j = 0; j * h < 3.; ++j)
        {
          const Point<2> x = test::centre_of({i, j}, h);
          const double   p = test::prandtl_pressure(x[0], 3. - x[1]);
          if (!std::isnan(p) && counts({i, j}, h))
            pressures[{i, j}] = 1e3 * p / failure_load;
        }
    return test::jumps_of(pressures, h);
  }

  void
  print(const std::string &what, const test::Jumps &jumps)
  {
    std::cout << "  " << what << ": " << 100. * jumps.share
              << " % of neighbouring cells differ by less than a fifth, all by "
                 "less than "
              << jumps.largest << " of q, at " << jumps.place << "\n";
  }

  /** q/s_u from 4 % of b on: first and last; and jumps of pressure. */
  std::pair<std::array<double, 2>, test::Jumps>
  footing(const std::string &method, const unsigned int refinement)
  {
    const SceneParameters<2> parameters(
      scene_file("ground/footing.prm",
                 {treatment(method),
                  "Grid/Cells=" + std::to_string(20 * refinement) + ", " +
                    std::to_string(14 * refinement)}));
    test::RunningScene<2> run(parameters);
    run.advance_to(6. - 1e-9);
    const auto force = run.column("held_footing_force_y");
    // means of 5 steps: what is free to swing does
    std::array<double, 2> result{};
    for (unsigned int i = 0; i < 5; ++i)
      {
        result[0] += force[43 + i] / 5e3;
        result[1] += force[force.size() - 1 - i] / 5e3;
      }
    std::cout << "footing, h " << 0.25 / refinement << " m, " << method
              << ": q/s_u " << result[0] << " and " << result[1] << ", "
              << iterations(run) << " iterations a step\n";
    check_balance(run, "reaction_work");
    const double      h     = 0.25 / refinement;
    const test::Jumps jumps = jumps_of_pressure(run, h);
    const test::Jumps right = jumps_of_prandtl(h);
    print("pressures", jumps);
    print("Prandtl's own", right);
    if (method == "cell")
      at_most("  pairs that differ more, beyond Prandtl's",
              right.share - jumps.share,
              0.01);
    return {result, jumps};
  }

  void
  check_footing(const bool all)
  {
    const auto with = footing("cell", 1), without = footing("none", 1);
    at_most("  off 5.4", std::abs(with.first[1] - 5.4), 0.15);
    at_most("  rise", with.first[1] - with.first[0], 0.05);
    at_most("  not more than without", 6.3 - without.first[1], 0.);
    if (all)
      {
        const auto fine = footing("cell", 2);
        at_most("  off Prandtl's 2 + pi",
                std::abs(fine.first[1] / (2. + dealii::numbers::PI) - 1.),
                0.03);
        at_most("  jumps of pressure over q", fine.second.largest, 0.2);
        at_most("  pairs that differ more", 1. - fine.second.share, 0.02);
        at_most("  without treatment less",
                0.5 - footing("none", 2).second.largest,
                0.);
      }
  }

  // ------------------------------------------------------------------------

  /** Settlement of the particles at the top, and pressures, kPa. */
  void
  check_free_column()
  {
    const SceneParameters<2> parameters(
      scene_file("ground/free-column.prm", {treatment("cell")}));
    test::RunningScene<2> run(parameters);
    const auto            heights = [&run] {
      std::map<unsigned int, double> result;
      for (const auto &particle : run.scene.particles)
        result[particle.get_id()] = particle.get_location()[1];
      return result;
    };
    const auto start = heights();
    run.advance_to(5. - 1e-9);
    const auto   end = heights();
    double       sum = 0.;
    unsigned int n   = 0;
    for (const auto &[id, y] : start)
      if (y > 1.9)
        {
          sum += y - end.at(id);
          ++n;
        }
    std::vector<double>     pressures;
    const ParticleFields<2> fields(run.scene.layout);
    const auto              pressure =
      fields.find({"pressure"}, "Output", "Particle fields").front();
    for (const auto &particle : run.scene.particles)
      {
        std::vector<double> value;
        pressure.append(particle, value);
        pressures.push_back(value[0] / 1e3);
      }
    std::sort(pressures.begin(), pressures.end());
    const double low  = pressures[pressures.size() / 100],
                 high = pressures[pressures.size() * 99 / 100];
    std::cout << "column that flows: settles by " << sum / n
              << " m, pressure from " << low << " to " << high << " kPa, "
              << iterations(run) << " iterations a step\n";
    at_most("  off 0.95 m", std::abs(sum / n - 0.95), 0.02);
    at_most("  lowest pressure below", -5. - low, 0.);
    at_most("  highest pressure above", high - 14., 0.);
    at_most("  iterations a step", iterations(run), 6.);
    check_balance(run, "load_work");
  }

  void
  check_slow_column()
  {
    std::array<double, 2> settled{}, n{};
    for (const unsigned int is_treated : {0, 1})
      {
        const SceneParameters<2> parameters(
          scene_file("validation/slow-column.prm",
                     {treatment(is_treated ? "cell" : "none"),
                      "Materials/rubber/Poisson's ratio=0.3",
                      "Method/Shape functions=GIMP",
                      "Method/Geometry=middle",
                      "Time/Step size=0.1"}));
        test::RunningScene<2> run(parameters);
        run.advance_to(48. - 1e-9);
        settled[is_treated] = fallen(run, "top_y");
        n[is_treated]       = iterations(run);
        check_balance(run, "load_work");
      }
    std::cout << "slow column: settles by " << settled[0] << " m without, "
              << settled[1] << " m with treatment\n";
    at_most("  difference", std::abs(settled[1] / settled[0] - 1.), 1e-4);
    at_most("  more iterations a step", n[1] - n[0], 0.5);
  }

  // ------------------------------------------------------------------------

  std::string
  plain_scene(const std::string &grid,
              const std::string &constants,
              const std::string &body,
              const std::string &step,
              const std::string &method = "cell")
  {
    return "set Dimension = 2\nsubsection Grid\nset Lower corner = 0, 0\n" +
           grid +
           "end\nsubsection Materials\nset Names = m\nsubsection m\n"
           "set Model = Hencky\n" +
           constants +
           "set Poisson's ratio = 0.3\nend\nend\nsubsection Bodies\n"
           "set Names = b\nsubsection b\nset Material = m\n"
           "set Points per direction = 2\n" +
           body +
           "end\nend\nsubsection Method\nset Locking treatment = " + method +
           "\nset Geometry = middle\nend\nsubsection Time\n"
           "set Step rule = fixed\nset End time = 1e3\n"
           "set Maximum travel = 0\nset Step size = " +
           step + "\nend\n";
  }

  /** Kinetic energy of a lattice squeezed by F = 12/n over that at first. */
  double
  growth(const unsigned int n_points, const std::string &method)
  {
    const double F = 12. / n_points, nu = 0.3;
    const double lambda = nu / ((1. + nu) * (1. - 2. * nu)),
                 mu = 0.5 / (1. + nu), c = std::sqrt(lambda + 2. * mu);
    const SceneParameters<2> parameters(ParameterFile::from_text(
      plain_scene("set Upper corner = 6, 6\nset Cells = 6, 6\n",
                  "set Density = 1\nset Young's modulus = 1\n",
                  "set Shape = box\nsubsection box\nset Lower corner = 0, 0\n"
                  "set Upper corner = 6, 6\nend\n",
                  shortest(1. / c),
                  method) +
        "subsection Boundary conditions\n"
        "set Roller = x-min, x-max, y-min, y-max\nend\n"
        "subsection Solver\nset Newton tolerance = 1e-15\nend\n",
      "lattice"));
    test::RunningScene<2>    run(parameters);

    const auto               &layout     = run.scene.layout;
    auto                     &particles  = run.scene.particles;
    const auto                properties = particles.begin()->get_properties();
    const std::vector<double> undisturbed(properties.begin(), properties.end());
    particles.clear();
    std::mt19937                           generator(1);
    std::uniform_real_distribution<double> noise(-1e-5, 1e-5);
    const double                           e = std::log(F);
    for (unsigned int i = 0; i < n_points; ++i)
      for (unsigned int j = 0; j < n_points; ++j)
        {
          const Point<2> x((i + 0.5) * 0.5 * F, (j + 0.5) * 0.5 * F);
          auto           values = undisturbed;
          const auto set = [&](const char *name, const std::vector<double> &v) {
            std::copy(v.begin(), v.end(), values.begin() + layout[name]);
          };
          const double b = F * F - 1., tau = 2. * (lambda + mu) * e;
          set("left_cauchy_green_less_unit", {b, b, 0., 0.});
          if (method == "cell")
            set("own_volume_ratio_less_one", {b});
          set("kirchhoff_stress", {tau, tau, 0., 2. * lambda * e});
          set("strain_energy_density", {2. * (lambda + mu) * e * e});
          set("half_length", {0.25 * F, 0.25 * F});
          set("deformation_gradient", {F, 0., 0., F});
          set("velocity", {noise(generator), noise(generator)});
          const auto cell = run.scene.grid.cell_at(run.scene.grid.key_of(x));
          particles.insert_particle(
            x,
            Point<2>(),
            i * n_points + j,
            cell,
            dealii::ArrayView<const double>(values.data(), values.size()));
        }
    particles.update_cached_numbers();
    run.advance(200);
    const auto K     = run.column("kinetic_energy");
    double     start = 0., end = 0.;
    for (unsigned int i = 0; i < 20; ++i)
      {
        start += K[1 + i];
        end += K[K.size() - 1 - i];
      }
    std::cout << "lattice squeezed by " << F << ", " << method
              << ": kinetic energy from " << start / 20. << " to " << end / 20.
              << " J\n";
    return end / start;
  }

  void
  check_disc()
  {
    const SceneParameters<2> parameters(ParameterFile::from_text(
      plain_scene("set Upper corner = 14, 10\nset Cells = 28, 20\n",
                  "set Density = 5\nset Young's modulus = 100\n",
                  "set Initial velocity = 0.75 - 0.3*(y - 5) + 0.2*(x - 4); "
                  "0.1 + 0.3*(x - 4) + 0.2*(y - 5)\nset Shape = ball\n"
                  "subsection ball\nset Center = 4, 5\nset Radius = 2\nend\n",
                  "0.05"),
      "disc"));
    test::RunningScene<2>    run(parameters);
    run.advance(160);
    const double K = run.column("kinetic_energy").front();
    const auto   J = run.column("angular_momentum_z");
    std::cout << "disc over 12 cells: " << iterations(run)
              << " iterations a step\n";
    at_most("  balance error / energy",
            test::largest(run.column("balance_error")) / K,
            1e-12);
    at_most("  change of angular momentum, relative",
            std::abs(J.back() / J.front() - 1.),
            1e-9);
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const bool                               all = argc > 1;
  check_beams(all);
  check_free_column();
  check_slow_column();
  for (const unsigned int n_points : {15, 17, 20})
    {
      growth(n_points, "none"); // to compare
      at_most("  growth", growth(n_points, "cell"), 1.2);
    }
  check_disc();
  check_footing(all);
  return test::report();
}
