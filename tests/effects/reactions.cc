// What walls do to a body is what the ledger says they do: the momentum of the
// particles changes by the forces of the sides and the loads, to round-off, and
// the angular momentum by their moments once places have settled. (What flies
// into a side in <Roller> keeps a velocity that the grid does not see, and
// slides: its angular momentum changes without a moment. So these sides are in
// <Fixed>.)

#include "../check.h"
#include "../scene.h"

using namespace emmy;

namespace
{
  /** A block that is thrown into the corner of its grid. */
  std::string
  thrown(const unsigned int dim)
  {
    const bool        in_space = dim == 3;
    const std::string one      = in_space ? ", 1" : "";
    return "set Dimension = " + std::to_string(dim) +
           "\nsubsection Method\nset Stress rule = conserving\nend\n"
           "subsection Grid\nset Upper corner = 3, 3" +
           (in_space ? ", 3" : "") + "\nset Cells = 6, 6" +
           (in_space ? ", 6" : "") +
           "\nend\nsubsection Materials\nset Names = rubber\n"
           "subsection rubber\nset Model = Hencky\nset Density = 5\n"
           "set Young's modulus = 100\nset Poisson's ratio = 0.3\nend\nend\n"
           "subsection Bodies\nset Names = block\nsubsection block\n"
           "set Shape = box\nset Material = rubber\nset Points per direction = 2\n"
           "set Initial velocity = -0.6; -0.4" +
           (in_space ? "; 0.2" : "") +
           "\nsubsection box\nset Lower corner = 0, 0" +
           (in_space ? ", 0" : "") + "\nset Upper corner = 1.5, 1" + one +
           "\nend\nend\nend\nsubsection Boundary conditions\n"
           "set Fixed = y-min\nset Roller = x-min\nset Reactions = true\nend\n"
           "subsection Time\nset End time = 2\nset Step rule = fixed\n"
           "set Step size = 0.05\nend\n"
           "subsection Solver\nset Newton tolerance = 1e-14\nend\n";
  }

  /** The largest change of a momentum that walls and loads do not explain. */
  template <int dim>
  double
  unexplained(const test::RunningScene<dim> &run,
              const std::string             &momentum,
              const std::string             &cause,
              const double                   load)
  {
    const auto p = run.column(momentum), time = run.column("time");
    const auto x = run.column("wall_x_min_" + cause);
    const auto y = run.column("wall_y_min_" + cause);
    const auto left =
      cause[0] == 'm'
        ? run.column("angular_momentum_left_" + std::string(1, cause.back()))
        : std::vector<double>(p.size());
    double worst = 0., size = 0.;
    for (unsigned int row = 1; row < p.size(); ++row)
      {
        const double dt = time[row] - time[row - 1];
        const double d  = p[row] - p[row - 1] + dt * (x[row] + y[row] - load) -
                         left[row] + left[row - 1];
        worst = std::max(worst, std::abs(d));
        size  = std::max({size, dt * std::abs(x[row]), dt * std::abs(y[row])});
      }
    test::check(size > 1e-3, "the walls do something");
    return worst / size;
  }

  template <int dim>
  void
  check_momentum(const std::string &name, const std::vector<std::string> &sets)
  {
    ParameterFile file = ParameterFile::from_text(thrown(dim), "test");
    double        load = 0.;
    for (const std::string &set : sets)
      {
        file.set(set);
        load = set == "Effects/Names=gravity" ? -9.81 : load;
      }
    test::RunningScene<dim> run{SceneParameters<dim>(file)};
    load *= test::total_mass(run.scene);
    run.advance(dim == 2 ? 20 : 5);
    for (unsigned int d = 0; d < dim; ++d)
      test::at_most(name + ": momentum " + "xyz"[d],
                    unexplained(run,
                                std::string("linear_momentum_") + "xyz"[d],
                                std::string("force_") + "xyz"[d],
                                d == 1 ? load : 0.),
                    1e-11);
    if (load == 0. && name.find("fixed") != std::string::npos)
      for (unsigned int d = dim == 2 ? 2 : 0; d < 3; ++d)
        test::at_most(name + ": angular momentum " + "xyz"[d],
                      unexplained(run,
                                  std::string("angular_momentum_") + "xyz"[d],
                                  std::string("moment_") + "xyz"[d],
                                  0.),
                      1e-10);
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_momentum<2>("linear, start", {"Method/Shape functions=linear"});
  check_momentum<2>("GIMP, middle, fixed",
                    {"Method/Shape functions=GIMP",
                     "Boundary conditions/Fixed=x-min, y-min",
                     "Boundary conditions/Roller="});
  check_momentum<2>("GIMP, start, gravity",
                    {"Method/Shape functions=GIMP",
                     "Method/Geometry=start",
                     "Effects/Names=gravity",
                     "Effects/Gravity/Acceleration=0; -9.81"});
  check_momentum<2>("explicit",
                    {"Method/Shape functions=linear",
                     "Time/Integrator=explicit",
                     "Method/Stress rule=conserving"});
  check_momentum<3>("in space, GIMP, middle", {"Method/Shape functions=GIMP"});
  check_momentum<3>("in space, linear, middle, fixed",
                    {"Method/Shape functions=linear",
                     "Method/Geometry=middle",
                     "Boundary conditions/Fixed=x-min, y-min",
                     "Boundary conditions/Roller="});

  test::check_throws_with(
    [] {
      ParameterFile file = ParameterFile::from_text(thrown(2), "test");
      file.set("Boundary conditions/Fixed=");
      file.set("Boundary conditions/Roller=");
      test::RunningScene<2> run{SceneParameters<2>(file)};
    },
    {"Reactions", "no side holds anything"});
  return test::report();
}
