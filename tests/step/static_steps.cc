// Facts about static steps: a column at rest under its weight has the stress of
// the closed form, turned columns too; works, stored energies and dissipation
// add up in each increment; what is left out of balance at the end is next to
// nothing; a load that is raised acts on top of one that acts in full; an
// increment that is too large is halved; bodies that nothing holds, that turn,
// or that move, are refused in words; tools and other rules too.

#include "../check.h"
#include "../scene.h"

using namespace emmy;
using test::check;
using test::check_close;

namespace
{
  constexpr double height = 10., gravity = 2.5, density = 1000.;

  /** A column of 20 cells, soft or plastic, in a tube. */
  std::string
  column(const std::string &material = "set Model = Hencky\n",
         const std::string &time     = "set Increments = 10\n",
         const std::string &walls    = "x-min, x-max, y-min")
  {
    return "set Dimension = 2\nsubsection Grid\nset Lower corner = 0, 0\n"
           "set Upper corner = 1, 12\nset Cells = 2, 24\nend\n"
           "subsection Materials\nset Names = m\nsubsection m\n" +
           material +
           "set Density = 1000\nset Young's modulus = 1e5\n"
           "set Poisson's ratio = 0.25\nend\nend\n"
           "subsection Bodies\nset Names = b\nsubsection b\nset Shape = box\n"
           "set Material = m\nset Points per direction = 2\nsubsection box\n"
           "set Lower corner = 0, 0\nset Upper corner = 1, 10\nend\nend\nend\n"
           "subsection Boundary conditions\nset Roller = " +
           walls +
           "\nend\nsubsection Effects\nset Names = gravity\n"
           "subsection Gravity\nset Acceleration = 0, -2.5\nend\nend\n"
           "subsection Time\nset Integrator = static\nset End time = 1\n" +
           time +
           "end\nsubsection Output\nset Particle fields = displacement, "
           "cauchy_stress\nend\n";
  }

  SceneParameters<2>
  scene(const std::string &text, const std::vector<std::string> &changes = {})
  {
    ParameterFile file = ParameterFile::from_text(text, "test");
    for (const std::string &change : changes)
      file.set(change);
    return SceneParameters<2>(file);
  }

  /** The largest |sigma_yy + rho g depth| over rho g height, and |balance|. */
  void
  check_column(const std::string              &name,
               const std::string              &text,
               const std::vector<std::string> &changes = {})
  {
    const auto            parameters = scene(text, changes);
    test::RunningScene<2> run(parameters);
    run.most_residual_work = 1e-6;
    run.advance_to(1.);
    double worst = 0.;
    for (const auto &particle : run.scene.particles)
      {
        std::vector<double> u, stress;
        run.scene.written_fields[0].append(particle, u);
        run.scene.written_fields[1].append(particle, stress);
        const double depth = height - (particle.get_location()[1] - u[1]);
        worst =
          std::max(worst, std::abs(stress[4] / (density * gravity) + depth));
      }
    worst = dealii::Utilities::MPI::max(worst, MPI_COMM_WORLD) / height;
    // stresses are constant in a cell, depths are not
    check(worst <= 0.5 * 0.5 / height + 0.01, name + ": stress");
    const auto   iterations = run.column("newton_iterations");
    const double most = *std::max_element(iterations.begin(), iterations.end());
    check(run.ledger.rows().size() <= 11 && most <= 4.,
          name + ": at most 10 increments, and 4 iterations in each");
    const double strain_energy = run.ledger["strain_energy"];
    double       largest       = 0.;
    for (const double error : run.column("balance_error"))
      largest = std::max(largest, std::abs(error));
    check_close(largest, 0., 1e-12 * strain_energy, name + ": balance");
    // the path of the load, to second order in the increments
    check_close(run.ledger["load_work"],
                strain_energy,
                0.02 * strain_energy,
                name + ": the load works what is stored");
    check(std::abs(run.ledger["imbalance_work"]) < 0.02 * strain_energy,
          name + ": what was out of balance worked little");
    if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
      std::cout << name << ": error of stress " << worst << ", at most " << most
                << " iterations, load work / strain energy "
                << run.ledger["load_work"] / strain_energy
                << ", imbalance work / strain energy "
                << run.ledger["imbalance_work"] / strain_energy
                << ", balance / strain energy " << largest / strain_energy
                << '\n';
  }

  /** A soil that flows: what is dissipated is in the balance. */
  void
  check_plastic()
  {
    const auto            parameters = scene(column(
      "set Model = Drucker-Prager\nset Cohesion = 100\nset Friction angle = 40\n"
                 "set Dilation angle = 0\n"));
    test::RunningScene<2> run(parameters);
    run.most_residual_work = 1e-6;
    run.advance_to(1.);
    const double scale      = run.ledger["load_work"];
    const double dissipated = run.ledger["plastic_dissipation"];
    double       largest = 0., before = 0.;
    for (const double error : run.column("balance_error"))
      largest = std::max(largest, std::abs(error));
    check_close(largest, 0., 1e-12 * scale, "plastic: balance");
    check(dissipated > 1e-3 * scale, "plastic: it flows");
    for (const double now : run.column("plastic_dissipation"))
      {
        check(now >= before, "plastic: no step gives energy back");
        before = now;
      }
    const double lost = run.ledger["stress_rule_loss"];
    if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
      std::cout << "plastic: dissipated " << dissipated / scale
                << " of the work, stress rule loss " << lost / scale
                << ", balance " << largest / scale << '\n';
    check(std::abs(lost) < 0.03 * scale, "plastic: the path of the load");
  }

  /** An increment that Newton does not manage is halved, and grows back. */
  void
  check_halving()
  {
    const auto parameters =
      scene(column(), {"Time/Increments=2", "Solver/Maximum iterations=3"});
    test::RunningScene<2> run(parameters);
    run.most_residual_work = 1e-6;
    unsigned int halvings  = 0;
    while (run.ledger["time"] < 1.)
      {
        const StepReport report = run.scene.advance();
        halvings += report.halvings;
        run.ledger.add(report);
      }
    check(halvings > 0, "increments are halved");
    check(run.ledger["time"] == 1., "the end is reached exactly");
  }

  /** A load that is raised, on top of one that acts in full. */
  void
  check_raised()
  {
    const std::string push =
      "subsection Effects\nsubsection Point load\nset Force = 0, -1e4\n"
      "set Points nearest to = 0.5, 10\nend\nend\n"
      "subsection Measurements\nset Names = foot\nsubsection foot\n"
      "set Type = mean\nset Upper corner = 1, 1\nend\nend\n";
    const auto stress = [&push](const std::string &raised) {
      const auto            parameters = scene(column() + push,
                                    {"Effects/Names=gravity, point load",
                                                "Time/Raised loads=" + raised});
      test::RunningScene<2> run(parameters);
      run.most_residual_work = 1e-6;
      run.advance_to(1.);
      return run.column("foot_cauchy_stress_yy");
    };
    const auto all = stress(""), push_only = stress("point load");
    if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
      std::cout << "stress above the foot, Pa: all loads raised " << all[1]
                << " to " << all.back() << ", the push alone " << push_only[1]
                << " to " << push_only.back() << '\n';
    // the mean of the metre above the foot has 9.5 m and less above it
    check_close(all.back(), push_only.back(), 0.005 * 35e3, "the same end");
    check(all.back() < -32.5e3 && all.back() > -35e3, "all loads in full");
    check(all[1] > -4e3, "all are raised: little at first");
    check(push_only[1] < -23.5e3 && push_only[1] > -26e3,
          "gravity in full from the start");
  }

  /** A block in plane strain between smooth plates bears its strength. */
  void
  check_squeezed(const std::string &name,
                 const std::string &material,
                 const double       strength)
  {
    const auto parameters = scene(
      "set Dimension = 2\nsubsection Grid\nset Lower corner = 0, 0\n"
      "set Upper corner = 2, 1\nset Cells = 2, 1\nend\n"
      "subsection Materials\nset Names = m\nsubsection m\n" +
      material +
      "set Density = 2000\nset Young's modulus = 3e7\n"
      "set Poisson's ratio = 0.3\nend\nend\n"
      "subsection Bodies\nset Names = b\nsubsection b\nset Shape = box\n"
      "set Material = m\nset Points per direction = 4\nsubsection box\n"
      "set Lower corner = 0, 0\nset Upper corner = 1, 1\nend\nend\nend\n"
      "subsection Boundary conditions\nset Roller = x-min, y-min, y-max\n"
      "set Velocity of y-max = -0.009\nend\nsubsection Time\n"
      "set Integrator = static\nset End time = 1\nset Increments = 20\nend\n"
      "subsection Output\nset Particle fields = kirchhoff_stress\nend\n");
    test::RunningScene<2> run(parameters);
    run.most_residual_work = 1e-6;
    run.advance_to(1.);
    double worst = 0.;
    for (const auto &particle : run.scene.particles)
      {
        std::vector<double> stress;
        run.scene.written_fields[0].append(particle, stress);
        worst = std::max(worst, std::abs(stress[4] / strength + 1.));
      }
    worst             = dealii::Utilities::MPI::max(worst, MPI_COMM_WORLD);
    const double work = run.ledger["reaction_work"];
    if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
      std::cout << name << ": off its strength by " << worst << ", dissipated "
                << run.ledger["plastic_dissipation"] / work
                << " of the work, balance "
                << run.ledger["balance_error"] / work << '\n';
    check(worst < 1e-4, name + ": it bears its strength");
    check(std::abs(run.ledger["balance_error"]) < 1e-12 * work,
          name + ": balance");
    check(run.ledger["plastic_dissipation"] > 0.4 * work, name + ": it flows");
  }

  void
  check_refused(const std::string              &text,
                const std::vector<std::string> &changes,
                const std::vector<std::string> &words)
  {
    test::check_throws_with(
      [&] {
        const auto            parameters = scene(text, changes);
        test::RunningScene<2> run(parameters);
        run.advance(1);
      },
      words);
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_column("GIMP", column());
  // stiffer: linear functions jump where particles cross cells
  check_column("linear",
               column(),
               {"Method/Shape functions=linear",
                "Materials/m/Young's modulus=3e6"});
  check_column("starved nodes free", column(), {"Method/Starved nodes=free"});

  check_plastic();
  const double angle = std::acos(-1.) / 6.;
  check_squeezed("soil",
                 "set Model = Drucker-Prager\nset Cohesion = 1e4\n"
                 "set Friction angle = 30\nset Dilation angle = 10\n",
                 2e4 * std::cos(angle) / (1. - std::sin(angle)));
  check_squeezed("clay",
                 "set Model = von Mises\nset Yield measure = undrained\n"
                 "set Yield stress = 1e4\n",
                 2e4);
  check_halving();
  check_raised();

  check_refused(column("set Model = Hencky\n", "", "x-min, x-max"),
                {},
                {"nothing holds the bodies along y",
                 "Boundary conditions",
                 "Integrator = implicit"});
  check_refused(column("set Model = Hencky\n", "", ""),
                {},
                {"nothing holds the bodies along x and y"});
  check_refused(column(),
                {"Bodies/b/Initial velocity=0; 1"},
                {"the bodies move", "Initial velocity"});
  check_refused(column(),
                {"Method/Geometry=middle"},
                {"<Method/Geometry> is <middle>", "Remove the entry"});
  check_refused(column(),
                {"Method/Stress rule=conserving"},
                {"<Method/Stress rule> is <conserving>"});
  check_refused(column(),
                {"Effects/Names=gravity, ghost stabilisation"},
                {"no place for the effect <ghost stabilisation>"});
  check_refused(column(),
                {"Time/Raised loads=gravty"},
                {"<Time/Raised loads> is <gravty>", "did you mean <gravity>?"});
  check_refused(column(),
                {"Time/Integrator=implicit", "Time/Raised loads=gravity"},
                {"only static steps raise loads"});
  return test::report();
}
