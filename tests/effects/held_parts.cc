// Facts about held parts: a plate of nodes that squeezes a block in a tube has
// the force of the closed form and its work; in time, momentum and energy
// balance with the forces on it; what a side holds belongs to the side; ranks
// agree; a part that reaches no body is told; mistakes are refused in words.

#include "../scene.h"

using namespace emmy;
using test::check;
using test::check_close;

namespace
{
  std::string
  block(const std::string &conditions, const std::string &time)
  {
    return "set Dimension = 2\nsubsection Grid\nset Lower corner = 0, 0\n"
           "set Upper corner = 2, 3\nset Cells = 4, 6\nend\n"
           "subsection Materials\nset Names = m\nsubsection m\n"
           "set Model = Hencky\nset Density = 1000\n"
           "set Young's modulus = 1e6\nset Poisson's ratio = 0\nend\nend\n"
           "subsection Bodies\nset Names = b\nsubsection b\nset Shape = box\n"
           "set Material = m\nset Points per direction = 2\nsubsection box\n"
           "set Lower corner = 0, 0\nset Upper corner = 2, 2\nend\nend\nend\n"
           "subsection Boundary conditions\nset Held parts = plate\n" +
           conditions + "end\nsubsection Time\n" + time + "end\n";
  }

  /** All of the top, down by 0.2 %: what presses is borne by the floor. */
  void
  check_force()
  {
    const SceneParameters<2> parameters(ParameterFile::from_text(
      block("set Roller = x-min, x-max, y-min\nset Reactions = true\n"
            "subsection plate\nset Region = 0.1 - abs(y - 2)\n"
            "set Velocity = free; -0.004\nend\n",
            "set Integrator = static\nset End time = 1\nset Increments = 1\n"),
      "force"));
    test::RunningScene<2>    run(parameters);
    run.most_residual_work = 1e-6;
    run.advance(1);
    const double right = -2e6 * std::log(0.998) / 0.998; // width 2 m
    const double force = run.ledger["held_plate_force_y"],
                 work  = run.ledger["reaction_work"];
    if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
      std::cout << "force " << force << " N, of a uniform stress " << right
                << ", work " << work << " J\n";
    // the top has left the nodes, which stay where they are
    check_close(force, right, 0.005 * right, "force on the plate");
    check_close(run.ledger["wall_y_min_force_y"],
                -force,
                1e-9 * force,
                "the floor bears it");
    check_close(run.ledger["held_plate_force_x"],
                0.,
                1e-9 * force,
                "a free component has no force");
    check_close(run.ledger["held_plate_moment_z"],
                force,
                1e-9 * force,
                "the moment is that of the middle of the plate");
    check_close(work, 0.5 * right * 0.004, 0.01 * work, "work");
    check_close(run.ledger["balance_error"], 0., 1e-12 * work, "balance");
  }

  /** In time: the change of momentum is the impulse of what holds. */
  void
  check_motion()
  {
    const SceneParameters<2> parameters(ParameterFile::from_text(
      block("set Roller = x-min\nsubsection plate\n"
            "set Region = if(abs(y - 2) < 0.1 & x < 1.01, 1, -1)\n"
            "set Velocity = 0; -0.1*t\nend\n",
            "set Step rule = fixed\nset Step size = 0.01\nset End time = 1\n"),
      "motion"));
    test::RunningScene<2>    run(parameters);
    run.advance(40);
    const auto force    = run.column("held_plate_force_y");
    const auto momentum = run.column("linear_momentum_y");
    double     worst = 0., largest = 0.;
    for (unsigned int i = 1; i < force.size(); ++i)
      {
        worst =
          std::max(worst,
                   std::abs(momentum[i] - momentum[i - 1] + 0.01 * force[i]));
        largest = std::max(largest, std::abs(0.01 * force[i]));
      }
    const double work = run.ledger["reaction_work"];
    if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
      std::cout << "impulses agree to " << worst / largest << ", work " << work
                << " J, balance " << run.ledger["balance_error"] / work << '\n';
    check(worst < 1e-10 * largest, "momentum balances with the force");
    check(work > 0., "the plate does work");
    check_close(run.ledger["balance_error"], 0., 1e-12 * work, "energy");
  }

  void
  check_refused(const std::string &plate, const std::vector<std::string> &words)
  {
    test::check_throws_with(
      [&] {
        const SceneParameters<2> parameters(ParameterFile::from_text(
          block("subsection plate\n" + plate + "end\n", "set End time = 1\n"),
          "refused"));
        test::RunningScene<2>    run(parameters);
      },
      words);
  }

  void
  check_nothing_held()
  {
    const SceneParameters<2> parameters(ParameterFile::from_text(
      block("set Roller = x-min\nsubsection plate\nset Region = y - 2.9\n"
            "set Velocity = 0; 0\nend\n",
            "set Step rule = fixed\nset Step size = 0.01\nset End time = 1\n"),
      "nothing"));
    test::RunningScene<2>    run(parameters);
    run.advance(1);
    const StepReport report = run.scene.advance();
    bool             told   = false;
    for (const std::string &finding : report.findings)
      told |=
        finding.find("held part <plate> holds nothing") != std::string::npos;
    check(told, "a part that holds nothing is told");
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_force();
  check_motion();
  check_nothing_held();
  check_refused("set Region = y\nset Velocity = 0\n",
                {"<Boundary conditions/plate/Velocity> is <0>",
                 "Write 2 components"});
  check_refused("set Region = y\nset Velocity = free; free\n",
                {"it holds nothing"});
  check_refused("set Velocity = 0; 0\n",
                {"Boundary conditions/plate/Region",
                 "positive at the nodes to be held"});
  return test::report();
}
