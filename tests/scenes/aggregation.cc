// Whole runs with nodes that follow, 4 points per cell where the paper
// takes 64 and 1225: examples 7.3B and 7.2 on its grid lose no energy and no
// momentum, and Newton has no hard step. Several ranks agree with one.

#include "../scene.h"

using namespace emmy;

namespace
{
  ParameterFile
  example(const std::string &folder, const std::string &name)
  {
    ParameterFile file(folder + "/paper/" + name);
    file.set("Grid/Cells=40, 24");
    file.set("Bodies/left/Points per direction=2");
    file.set("Bodies/right/Points per direction=2");
    file.set("Time/Step rule=fixed");
    file.set("Time/Step size=0.0602");
    file.set("Method/Starved nodes=follow");
    // what Newton leaves must not hide what followers might lose
    file.set("Solver/Newton tolerance=1e-15");
    return file;
  }

  double
  value(const Ledger &ledger, const std::string &column)
  {
    const auto &names = ledger.columns();
    return std::find(names.begin(), names.end(), column) == names.end()
             ? 0.
             : ledger[column];
  }

  void
  check_example(const std::string &folder, const std::string &name)
  {
    std::cout << name << '\n';
    const SceneParameters<2> parameters(example(folder, name));
    test::RunningScene<2>    run(parameters, MPI_COMM_SELF);
    const double             mass = test::total_mass(run.scene),
                 start_energy     = run.ledger.total_energy();
    const double momentum         = mass * std::sqrt(2. * start_energy / mass);
    double       drift            = 0.;
    while (run.ledger["time"] < 8.)
      {
        run.advance(1);
        drift = std::max(drift,
                         std::abs(run.ledger.total_energy() +
                                  value(run.ledger, "plastic_dissipation") -
                                  start_energy));
      }
    const auto change = [&run](const std::string &column) {
      auto         values = run.column(column);
      const double start  = values[0];
      for (double &x : values)
        x -= start;
      return test::largest(values);
    };
    test::check(run.ledger["step"] == 133, name + ": no step is halved");
    test::at_most("drift of the energy", drift / start_energy, 1e-11);
    test::at_most("change of linear momentum / (m v), x",
                  change("linear_momentum_x") / momentum,
                  1e-11);
    test::at_most("change of linear momentum / (m v), y",
                  change("linear_momentum_y") / momentum,
                  1e-11);
    test::at_most("change of angular momentum, relative",
                  change("angular_momentum_z") /
                    std::abs(run.column("angular_momentum_z")[0]),
                  1e-11);
    test::at_most("Newton iterations of a step",
                  test::largest(run.column("newton_iterations")),
                  6);
    test::at_most("largest weight",
                  test::largest(run.column("largest_weight")),
                  4);
    test::check(test::largest(run.column("followers")) > 40,
                name + ": nodes follow");
    test::check(test::largest(run.column("free_starved")) == 0.,
                name + ": every starved node has a root");
  }

  template <int dim>
  void
  compare(const ParameterFile &file,
          const unsigned int   n_steps,
          const std::string   &name)
  {
    test::compare_ranks<dim>(file,
                             n_steps,
                             name,
                             {"time",
                              "kinetic_energy",
                              "kinetic_energy_grid_new",
                              "strain_energy",
                              "angular_momentum_z",
                              "active_dofs",
                              "followers",
                              "largest_weight"});
  }

  void
  check_ranks(const std::string &folder)
  {
    compare<2>(example(folder, "7.3b.prm"), 50, "7.3b");
    compare<2>(example(folder, "7.2.prm"), 50, "7.2");
    for (const char *shape_functions : {"linear", "GIMP"})
      {
        // a wall that moves, and a body that leaves it
        ParameterFile file =
          ParameterFile::from_text(test::collision_text(2), "test");
        file.set(std::string("Method/Shape functions=") + shape_functions);
        file.set("Boundary conditions/Fixed=y-min");
        file.set("Boundary conditions/Velocity of y-min=0.2 + 0.1*sin(t); "
                 "0.002*sin(t)");
        file.set("Bodies/left/ball/Center=1.9, 0.9");
        file.set("Method/Starved nodes=follow");
        compare<2>(file, 20, std::string("wall, ") + shape_functions);

        ParameterFile balls(folder + "/validation/two-balls.prm");
        balls.set(std::string("Method/Shape functions=") + shape_functions);
        balls.set("Bodies/left/Points per direction=2");
        balls.set("Bodies/right/Points per direction=2");
        balls.set("Method/Starved nodes=follow");
        balls.set("Solver/Newton tolerance=1e-15");
        compare<3>(balls, 15, std::string("two balls, ") + shape_functions);
      }
  }

  /** A block that fills its box of rollers and shakes in it. */
  std::string
  shaken_text(const std::string &method)
  {
    return "set Dimension = 2\nsubsection Grid\nset Lower corner = 0, 0\n"
           "set Upper corner = 4, 3\nset Cells = 8, 6\nend\n"
           "subsection Materials\nset Names = m\nsubsection m\n"
           "set Model = Hencky\nset Density = 5\nset Young's modulus = 100\n"
           "set Poisson's ratio = 0.3\nend\nend\n"
           "subsection Bodies\nset Names = b\nsubsection b\n"
           "set Shape = box\nset Material = m\n"
           "set Points per direction = 2\n"
           "set Initial velocity = 0.5*sin(pi*x/4); 0.3*sin(pi*y/3)\n"
           "subsection box\nset Lower corner = 0, 0\n"
           "set Upper corner = 4, 3\nend\nend\nend\n"
           "subsection Boundary conditions\n"
           "set Roller = x-min, x-max, y-min, y-max\nend\n"
           "subsection Time\nset Step rule = fixed\nset Step size = 0.05\n"
           "set End time = 10\nend\nsubsection Method\n" +
           method + "end\n";
  }

  /** Where no node is starved, following costs no digit. */
  void
  check_none_starved(const std::string &method)
  {
    const auto parameters = [&method](const char *nodes) {
      return SceneParameters<2>(ParameterFile::from_text(
        shaken_text(method + "set Starved nodes = " + nodes + "\n"), nodes));
    };
    const auto            follow = parameters("follow");
    test::RunningScene<2> following(follow);
    following.advance(20);
    const auto            free = parameters("free");
    test::RunningScene<2> without(free);
    without.advance(20);
    test::check(test::largest(following.column("followers")) == 0.,
                "no node is starved, " + method);
    for (const std::string &column : without.ledger.columns())
      test::check(following.column(column) == without.column(column),
                  "follow and free are the same, " + column + ", " + method);
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::string                        folder = argv[1];
  if (dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD) == 1)
    {
      check_example(folder, "7.3b.prm");
      check_example(folder, "7.2.prm");
    }
  else
    check_ranks(folder);
  check_none_starved("set Shape functions = linear\n");
  check_none_starved("set Geometry = start\n");
  check_none_starved("");
  return test::report();
}
