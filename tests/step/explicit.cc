// Facts about explicit steps: their energy balance closes whatever the scene,
// momentum is constant, free flight is exact, they converge to the motion of
// implicit steps with the order of symplectic Euler, do not depend on the
// ranks, and refuse in words what they cannot do.

#include <map>

#include "../check.h"
#include "../scene.h"

using namespace emmy;
using test::check;
using test::check_close;

namespace
{
  /** "Section/Entry" and value. */
  using Settings = std::vector<std::pair<std::string, std::string>>;

  /** A block that spins, stretches and flies through its grid. */
  template <int dim>
  ParameterFile
  block(const Settings &settings = {})
  {
    const std::string more = dim == 2 ? "" : ", 3";
    ParameterFile     file = ParameterFile::from_text(
      "set Dimension = " + std::to_string(dim) +
        "\nsubsection Method\nset Shape functions = linear\n"
            "set Starved nodes = free\nend\n"
            "subsection Grid\nset Lower corner = 0, 0" +
        (dim == 2 ? "" : ", 0") + "\nset Upper corner = 4, 3" + more +
        "\nset Cells = 8, 6" + (dim == 2 ? "" : ", 6") +
        "\nend\nsubsection Materials\nset Names = m\nsubsection m\n"
            "set Model = Hencky\nset Density = 5\nset Young's modulus = 100\n"
            "set Poisson's ratio = 0.3\nend\nend\n"
            "subsection Bodies\nset Names = block\nsubsection block\n"
            "set Shape = box\nset Material = m\nset Points per direction = 2\n"
            "set Initial velocity = 0.6 - 0.5*(y-1) + 0.4*(x-1.6); 0.5*(x-1.6)" +
        (dim == 2 ? "" : "; 0.3*(y-1)") +
        "\nsubsection box\nset Lower corner = 1, 0.5" +
        (dim == 2 ? "" : ", 0.5") + "\nset Upper corner = 2.5, 2" +
        (dim == 2 ? "" : ", 2") +
        "\nend\nend\nend\n"
            "subsection Time\nset Integrator = explicit\nset End time = 1\n"
            "set Step rule = normalised\nset Factor = 0.2\nend\n",
      "test");
    for (const auto &[name, value] : settings)
      file.set(name + "=" + value);
    return file;
  }

  /** Settings of two kinds together. */
  Settings
  operator+(Settings a, const Settings &b)
  {
    a.insert(a.end(), b.begin(), b.end());
    return a;
  }

  template <int dim>
  void
  check_balance(const std::string &name, const Settings &settings)
  {
    const SceneParameters<dim> parameters(block<dim>(settings));
    test::RunningScene<dim>    run(parameters);
    run.advance(dim == 2 ? 60 : 25);
    double energy = test::largest(run.column("kinetic_energy"));
    energy = std::max(energy, test::largest(run.column("strain_energy")));
    const std::string what = std::to_string(dim) + "D " + name;
    test::at_most(what + ": balance error / energy",
                  test::largest(run.column("balance_error")) / energy,
                  1e-13);
    check(test::largest(run.column("strain_energy")) > 1e-3 * energy,
          what + ": the block is strained");
    for (const char *loss : {"velocity_update_loss", "lumping_loss"})
      {
        const auto sums = run.column(loss);
        check(sums.back() > 0. && std::is_sorted(sums.begin(), sums.end()),
              what + ": " + loss + " never falls");
      }
    check(std::abs(run.ledger["residual_work"]) <= 1e-13 * energy,
          what + ": nothing is left over");
    check(run.scene.stepper->grid_start().active->graph().n_nonzeros() == 0,
          what + ": there is no matrix");
  }

  /** Whatever the scene has: what goes in is stored, dissipated or booked. */
  template <int dim>
  void
  check_balances()
  {
    const Settings plastic{{"Materials/m/Model", "von Mises"},
                           {"Materials/m/Yield stress", "3"},
                           {"Materials/m/Hardening modulus", "10"}},
      gimp{{"Method/Shape functions", "GIMP"}}, pic{{"Method/Mapping", "PIC"}},
      blend{{"Method/Mapping", "blend"}, {"Method/FLIP fraction", "0.9"}},
      gravity{{"Effects/Names", "gravity"},
              {"Effects/Gravity/Acceleration",
               dim == 2 ? "0.3, -1" : "0.3, -1, 0.2"}},
      wall{{"Bodies/block/box/Lower corner", dim == 2 ? "1, 0" : "1, 0, 0.5"},
           {"Boundary conditions/Roller", "y-min"}},
      moving{{"Bodies/block/box/Lower corner", dim == 2 ? "1, 0" : "1, 0, 0.5"},
             {"Boundary conditions/Fixed", "y-min"},
             {"Boundary conditions/Velocity of y-min",
              dim == 2 ? "0.2*sin(9*t); 0" : "0.2*sin(9*t); 0; 0.1"}},
      plain{{"Time/Stress update", "plain"}, {"Time/Factor", "0.05"}};
    check_balance<dim>("elastic", {});
    check_balance<dim>("plain", plain);
    check_balance<dim>("plastic, PIC", plastic + pic);
    check_balance<dim>("gravity, wall, blend", gravity + wall + blend);
    check_balance<dim>("moving wall, plain", moving + plain);
    check_balance<dim>("moving wall, gravity, plastic, GIMP",
                       moving + gravity + plastic + gimp);
    check_balance<dim>("GIMP, PIC, wall", gimp + pic + wall);
  }

  /** Momentum is constant, and with gravity grows by m g t. */
  template <int dim>
  void
  check_momentum()
  {
    for (const bool with_gravity : {false, true})
      {
        Settings settings;
        if (with_gravity)
          settings = settings + Settings{{"Effects/Names", "gravity"},
                                         {"Effects/Gravity/Acceleration",
                                          dim == 2 ? "0, -1" : "0, -1, 0"}};
        const SceneParameters<dim> parameters(block<dim>(settings));
        test::RunningScene<dim>    run(parameters);
        run.advance(dim == 2 ? 40 : 25);
        const double mass = test::total_mass(run.scene);
        for (unsigned int d = 0; d < dim; ++d)
          {
            const auto p =
              run.column(std::string("linear_momentum_") + "xyz"[d]);
            const double gain =
              with_gravity && d == 1 ? -mass * run.ledger["time"] : 0.;
            check_close(p.back() - p.front(),
                        gain,
                        1e-13 * mass,
                        std::to_string(dim) + "D: momentum, direction " +
                          std::to_string(d));
          }
        if (with_gravity)
          check(run.ledger["load_work"] > 0., "gravity does work");
      }
  }

  /**
   * Free flight: paths are straight and nothing is strained, also when
   * particles land exactly on faces, where nodes have no mass: in each step
   * they move by a quarter of a cell.
   */
  template <int dim>
  void
  check_free_flight(const Settings &settings)
  {
    const SceneParameters<dim> parameters(
      block<dim>(settings + Settings{{"Bodies/block/Initial velocity",
                                      dim == 2 ? "1; -0.5" : "1; -0.5; 0.25"},
                                     {"Bodies/block/box/Lower corner",
                                      dim == 2 ? "0.5, 1" : "0.5, 1, 0.5"},
                                     {"Time/Step rule", "fixed"},
                                     {"Time/Step size", "0.125"}}));
    test::RunningScene<dim>                    run(parameters);
    std::map<unsigned int, dealii::Point<dim>> start;
    for (const auto &particle : run.scene.particles)
      start[particle.get_id()] = particle.get_location();
    run.advance(8);
    for (const auto &particle : run.scene.particles)
      {
        dealii::Point<dim> x = start.at(particle.get_id());
        x[0] += 1.;
        x[1] -= 0.5;
        if (dim == 3)
          x[dim - 1] += 0.25;
        check_close(particle.get_location().distance(x),
                    0.,
                    1e-13,
                    std::to_string(dim) + "D free flight: straight path, m");
      }
    check_close(run.ledger["strain_energy"],
                0.,
                1e-20,
                std::to_string(dim) + "D free flight: strain energy, J");
  }

  /** A bar between rollers that vibrates, free at its end; all of the grid. */
  ParameterFile
  bar(const std::string &integrator, const std::string &update, const double dt)
  {
    return ParameterFile::from_text(
      "set Dimension = 2\n"
      "subsection Method\nset Shape functions = linear\n"
      "set Starved nodes = free\nend\n"
      "subsection Grid\nset Upper corner = 10, 1\nset Cells = 20, 2\nend\n"
      "subsection Materials\nset Names = m\nsubsection m\n"
      "set Model = Hencky\nset Density = 1\nset Young's modulus = 100\n"
      "set Poisson's ratio = 0\nend\nend\n"
      "subsection Bodies\nset Names = bar\nsubsection bar\n"
      "set Shape = box\nset Material = m\nset Points per direction = 2\n"
      "set Initial velocity = 0.01*sin(pi*x/16); 0\n"
      "subsection box\nset Lower corner = 0, 0\nset Upper corner = 8, 1\nend\nend\nend\n"
      "subsection Boundary conditions\nset Roller = x-min, y-min, y-max\nend\n"
      "subsection Method\nset Lumping = 1\nend\n"
      "subsection Time\nset Integrator = " +
        integrator + "\nset Stress update = " + update +
        "\nset End time = 2\n"
        "set Step rule = fixed\nset Step size = " +
        std::to_string(dt) + "\nend\n",
      "test");
  }

  /** Kinetic energy of the bar after 2 s, five eighths of a period, J. */
  double
  kinetic_energy_of_bar(const std::string &integrator,
                        const std::string &update,
                        const double       dt)
  {
    const SceneParameters<2> parameters(bar(integrator, update, dt));
    test::RunningScene<2>    run(parameters);
    run.advance(std::lround(2. / dt));
    check_close(run.ledger["time"], 2., 1e-12, "the bar's time, s");
    return run.ledger["kinetic_energy"];
  }

  /**
   * With the same lumped mass, explicit and implicit steps converge to the same
   * vibration; symplectic Euler with order 1, as its velocities lag by half a
   * step.
   */
  void
  check_vibration()
  {
    const double exact = kinetic_energy_of_bar("implicit", "modified", 0.005);
    for (const std::string update : {"modified", "plain"})
      {
        std::vector<double> errors;
        for (const double dt : {0.02, 0.01, 0.005})
          errors.push_back(kinetic_energy_of_bar("explicit", update, dt) -
                           exact);
        for (unsigned int i = 1; i < errors.size(); ++i)
          {
            const double order = std::log2(errors[i - 1] / errors[i]);
            std::cout << "vibration, " << update << ": error of kinetic energy "
                      << errors[i] / exact << ", order " << order << '\n';
            check(order > 0.9 && order < 1.1, "order of symplectic Euler");
          }
        check(std::abs(errors.back()) < 0.02 * exact,
              "explicit and implicit vibrate alike");
      }
  }

  /** A step that is too long ends the run in words, and leaves no trace. */
  void
  check_unstable()
  {
    const SceneParameters<2> parameters(block<2>({{"Time/Factor", "4"}}));
    test::RunningScene<2>    run(parameters);
    test::check_throws_with([&] { run.advance(100); },
                            {"Step ",
                             "Explicit steps are stable only if they are small",
                             "Time/Integrator = implicit"});
    double energy = 0.;
    for (const auto &particle : run.scene.particles)
      {
        const auto   fields   = particle.get_properties();
        const double mass     = fields[run.scene.layout["mass"]];
        const auto   velocity = run.scene.layout["velocity"];
        for (unsigned int d = 0; d < 2; ++d)
          energy += 0.5 * mass * fields[velocity + d] * fields[velocity + d];
      }
    check_close(energy,
                run.ledger["kinetic_energy"],
                1e-13 * energy,
                "the particles are those of the last accepted step");
  }

  void
  check_refusals()
  {
    const auto check_refused = [](const Settings                 &settings,
                                  const std::vector<std::string> &texts) {
      test::check_throws_with(
        [&] {
          const SceneParameters<2> parameters(block<2>(settings));
          Scene<2>                 scene(parameters, MPI_COMM_WORLD);
        },
        texts);
    };
    check_refused({{"Effects/Names", "ghost stabilisation"}},
                  {"Time/Integrator",
                   "no place for the effect <ghost stabilisation>"});
    check_refused({{"Method/Starved nodes", "follow"}},
                  {"Method/Starved nodes", "no equation that nodes"});
    check_refused({{"Method/Lumping", "0.5"}},
                  {"Method/Lumping", "the mass is always lumped"});
    check_refused({{"Method/Stress rule", "end-point"}},
                  {"Method/Stress rule", "at the start of the step"});
    for (const std::string mapping : {"unconstrained", "inelastic"})
      check_refused({{"Method/Wall mapping", mapping},
                     {"Boundary conditions/Fixed", "y-min"}},
                    {"Method/Wall mapping", "must be <constrained>"});
    check_refused({{"Diagnosis/Small cuts", "true"}},
                  {"Diagnosis/Small cuts", "no matrix"});
    // what says nothing against it is taken
    const SceneParameters<2> lumped(block<2>({{"Method/Lumping", "1"}}));
    check(Scene<2>(lumped, MPI_COMM_WORLD).mapping.lumping == 1.,
          "the mass is lumped");
  }

  /** Without the word there is no trace of explicit steps. */
  void
  check_absent()
  {
    const SceneParameters<2> parameters(
      block<2>({{"Time/Integrator", "implicit"}}));
    const test::RunningScene<2> run(parameters);
    for (const std::string &column : run.ledger.columns())
      check(column.find("update_loss") == std::string::npos,
            "implicit steps have no column " + column);
    check(!run.scene.explicit_force, "implicit steps have no explicit force");
  }

  void
  check_ranks()
  {
    const std::vector<std::string> columns{"time",
                                           "kinetic_energy",
                                           "kinetic_energy_grid_new",
                                           "strain_energy",
                                           "stress_update_loss",
                                           "velocity_update_loss",
                                           "lumping_loss",
                                           "linear_momentum_x"};
    test::compare_ranks<2>(block<2>({{"Method/Shape functions", "GIMP"},
                                     {"Method/Mapping", "blend"},
                                     {"Method/FLIP fraction", "0.9"},
                                     {"Boundary conditions/Roller", "y-min"}}),
                           40,
                           "GIMP on a roller, 2D",
                           columns);
    test::compare_ranks<3>(block<3>(
                             {{"Effects/Names", "gravity"},
                              {"Effects/Gravity/Acceleration", "0, -1, 0"}}),
                           20,
                           "linear functions and gravity, 3D",
                           columns);
    test::compare_ranks<2>(block<2>(
                             {{"Bodies/block/Initial velocity", "1; 0"},
                              {"Bodies/block/box/Lower corner", "0.5, 1"},
                              {"Time/Step rule", "fixed"},
                              {"Time/Step size", "0.125"}}),
                           8,
                           "massless nodes, 2D",
                           {"kinetic_energy", "linear_momentum_x"});
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_ranks();
  if (dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD) > 1)
    return test::report();
  check_balances<2>();
  check_balances<3>();
  check_momentum<2>();
  check_momentum<3>();
  for (const char *functions : {"linear", "GIMP"})
    {
      check_free_flight<2>({{"Method/Shape functions", functions}});
      check_free_flight<3>({{"Method/Shape functions", functions}});
    }
  check_vibration();
  check_unstable();
  check_refusals();
  check_absent();
  return test::report();
}
