// Geometry in the middle of a step (Method/Geometry = middle): what every step
// conserves in small scenes with all that it may meet, on one rank and on
// several; and that steps can be taken back. Columns are in columns.cc.

#include <emmy/run/scene.h>

#include <map>

#include "../scene.h"

using namespace emmy;

namespace
{
  using Settings = std::vector<std::string>;

  ParameterFile
  with(const std::string &text, const Settings &settings)
  {
    ParameterFile file = ParameterFile::from_text(text, "middle");
    for (const std::string &setting : settings)
      file.set(setting);
    return file;
  }

  /** A ball (disc) that spins, breathes and flies. */
  std::string
  ball_text(const unsigned int dim)
  {
    const bool in_space = dim == 3;
    return "set Dimension = " + std::to_string(dim) +
           "\nsubsection Grid\n"
           "set Lower corner = 0, 0" +
           (in_space ? ", 0" : "") + "\nset Upper corner = 5, 4" +
           (in_space ? ", 4" : "") + "\nset Cells = 10, 8" +
           (in_space ? ", 8" : "") +
           "\nend\n"
           "subsection Materials\nset Names = m\nsubsection m\n"
           "set Model = Hencky\nset Density = 5\n"
           "set Young's modulus = 100\nset Poisson's ratio = 0.3\n"
           "end\nend\n"
           "subsection Bodies\nset Names = b\nsubsection b\n"
           "set Shape = ball\nset Material = m\n"
           "set Points per direction = 2\n"
           "set Initial velocity = 0.3 + 0.5*(x-2.1) - (y-1.9); "
           "-0.3*(y-1.9) + (x-2.1)" +
           (in_space ? "; 0.2*(x-2.1) + 0.1" : "") +
           "\nsubsection ball\nset Center = 2.1, 1.9" +
           (in_space ? ", 2" : "") +
           "\nset Radius = 1.2\nend\nend\nend\n"
           "subsection Method\nset Shape functions = GIMP\n"
           "set Geometry = middle\nset Starved threshold = 0.1\nend\n"
           "subsection Time\nset Step rule = fixed\nset Step size = 0.04\n"
           "set End time = 10\nend\n"
           "subsection Solver\nset Newton tolerance = 1e-15\nend\n";
  }

  /** Ledger identities of some steps; bounds relative to the sums' sizes. */
  template <int dim>
  void
  check_conservation(const std::string &what,
                     const Settings    &settings,
                     const bool         is_free,
                     const bool         settles = true)
  {
    const SceneParameters<dim> parameters(with(ball_text(dim), settings));
    test::RunningScene<dim>    run(parameters);
    run.advance(dim == 2 ? 20 : 6);
    std::cout << what << '\n';
    double energy = 0.;
    for (const char *name : {"kinetic_energy", "strain_energy", "load_work"})
      for (const auto &column : run.ledger.columns())
        if (column == name)
          energy = std::max(energy, test::largest(run.column(name)));
    test::at_most("  balance error / energy",
                  test::largest(run.column("balance_error")) / energy,
                  1e-12);
    bool stops_early = false;
    for (const std::string &setting : settings)
      stops_early =
        stops_early || setting.find("tolerance") != std::string::npos;
    if (!stops_early)
      test::at_most("  work of residuals / energy",
                    test::largest(run.column("residual_work")) / energy,
                    1e-9);
    if (!is_free)
      return;
    for (const std::string &axis : dim == 2
                                     ? std::vector<std::string>{"x", "y"}
                                     : std::vector<std::string>{"x", "y", "z"})
      {
        const auto   p     = run.column("linear_momentum_" + axis);
        const double scale = test::total_mass(run.scene);
        test::at_most("  change of linear momentum " + axis,
                      std::abs(p.back() - p.front()) / scale,
                      1e-12);
      }
    for (const std::string &axis : dim == 2
                                     ? std::vector<std::string>{"z"}
                                     : std::vector<std::string>{"x", "y", "z"})
      {
        const auto J    = run.column("angular_momentum_" + axis);
        const auto left = run.column("angular_momentum_left_" + axis);
        double     sum  = 0.;
        for (const double l : left)
          sum += l;
        const double scale = 2. * test::total_mass(run.scene);
        test::at_most("  change of angular momentum " + axis + ", not booked",
                      std::abs(J.back() - J.front() - sum) / scale,
                      1e-12);
        if (settles)
          test::at_most("  change of angular momentum " + axis,
                        std::abs(J.back() - J.front()) / scale,
                        1e-10);
      }
  }

  template <int dim>
  void
  check_all()
  {
    const std::string in = std::to_string(dim) + "D, ";
    check_conservation<dim>(in + "GIMP, followers", {}, true);
    check_conservation<dim>(in + "linear, followers",
                            {"Method/Shape functions=linear"},
                            true,
                            false); // where points cross cells
    for (const char *update : {"none", "detF", "diagF", "corners"})
      check_conservation<dim>(in + "boxes " + update,
                              {std::string("Method/Domain update=") + update},
                              true,
                              update != std::string("corners"));
    check_conservation<dim>(in + "PIC and lumped mass",
                            {"Method/Mapping=PIC", "Method/Lumping=0.3"},
                            false);
    check_conservation<dim>(in + "ghosts",
                            {"Effects/Names=ghost stabilisation",
                             "Method/Starved nodes=free"},
                            false);
    check_conservation<dim>(in + "plastic",
                            {"Method/Locking treatment=none",
                             "Materials/m/Model=von Mises",
                             "Materials/m/Yield stress=3",
                             "Materials/m/Hardening modulus=10"},
                            true);
    check_conservation<dim>(in + "walls and gravity",
                            {"Effects/Names=gravity",
                             dim == 2 ? "Effects/Gravity/Acceleration=0, -2"
                                      : "Effects/Gravity/Acceleration=0, -2, 0",
                             "Boundary conditions/Roller=y-min, x-max"},
                            false);
    check_conservation<dim>(in + "Newton stopped early",
                            {"Solver/Newton tolerance=1e-4"},
                            false);
  }

  /** Steps forward, all velocities turned round, as many steps back. */
  void
  check_reversal()
  {
    const SceneParameters<2> parameters(
      with(ball_text(2), {"Method/Domain update=stretch"}));
    test::RunningScene<2> run(parameters);
    const auto            positions = [&] {
      std::map<unsigned int, dealii::Point<2>> result;
      for (const auto &particle : run.scene.particles)
        result[particle.get_id()] = particle.get_location();
      return result;
    };
    const auto start = positions();
    run.advance(50);
    for (auto &particle : run.scene.particles)
      for (const char *name : {"velocity", "grid_velocity"})
        for (unsigned int c = 0; c < 2; ++c)
          particle.get_properties()[run.scene.layout[name] + c] *= -1.;
    for (auto &particle : run.scene.particles)
      for (unsigned int c = 0; c < 4; ++c)
        particle
          .get_properties()[run.scene.layout["grid_velocity_gradient"] + c] *=
          -1.;
    run.advance(50);
    double farthest = 0.;
    for (const auto &[id, x] : positions())
      farthest = std::max(farthest, x.distance(start.at(id)));
    test::at_most("50 steps and back, in cells", farthest / 0.5, 1e-8);
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_all<2>();
  check_all<3>();
  if (dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD) == 1)
    check_reversal();
  return test::report();
}
