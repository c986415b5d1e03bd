// Bodies on rough slopes, with all defaults: a disc rolls or slides, a block
// sticks or slides, as rigid ones do. Scenes of prm/examples, turned by
// gravity.

#include "../check.h"
#include "../scene.h"

#include <emmy/base/text.h>

using namespace emmy;
using test::at_most;
using test::check;
using test::RunningScene;

namespace
{
  constexpr double g = 9.81;

  double
  radians(const double degrees)
  {
    return degrees / 180. * dealii::numbers::PI;
  }

  std::string
  gravity(const double degrees)
  {
    return "Effects/Gravity/Acceleration = " +
           shortest(g * std::sin(radians(degrees))) + ", " +
           shortest(-g * std::cos(radians(degrees)));
  }

  /**
   * How far the middle of all has come along the slope: v is the mean of both
   * ends in each step, so this is exact.
   */
  double
  way(const RunningScene<2> &run)
  {
    const auto dt = run.column("time_step"),
               p  = run.column("linear_momentum_x");
    double sum    = 0.;
    for (unsigned int row = 1; row < dt.size(); ++row)
      sum += 0.5 * dt[row] * (p[row] + p[row - 1]);
    return sum / test::total_mass(run.scene);
  }

  void
  check_balance(const RunningScene<2> &run, const std::string &what)
  {
    const double scale = run.ledger.largest_energy();
    at_most(what + ": balance",
            test::largest(run.column("balance_error")) / scale,
            1e-12);
    const auto iterations = run.column("newton_iterations");
    double     sum        = 0.;
    for (const double n : iterations)
      sum += n;
    at_most(what + ": iterations of Newton, mean",
            sum / (iterations.size() - 1),
            6.);
    at_most(what + ": iterations of Newton, most",
            test::largest(iterations),
            25.);
  }

  /** A disc rolls with 2/3 of what it slides with. */
  void
  check_disc(const std::string &folder, const bool rolls)
  {
    ParameterFile file(folder + "/roll.prm");
    file.set(gravity(60.));
    if (!rolls)
      file.set("Effects/Tools/slope/Friction coefficient = 0");
    const SceneParameters<2> parameters(file);
    RunningScene<2>          run(parameters);
    run.advance_to(1. - 1e-9);
    const std::string what = rolls ? "disc that rolls" : "disc that slides";
    const double right = (rolls ? 1. / 3. : 0.5) * g * std::sin(radians(60.));
    check_balance(run, what);
    at_most(what + ", " + shortest(way(run)) + " m of " + shortest(right) +
              ", misfit",
            std::abs(way(run) / right - 1.),
            0.005);
    if (!rolls)
      return;
    const double v = run.ledger["linear_momentum_x"];
    at_most("disc that rolls: lost of its energy",
            run.ledger["friction_dissipation"] / run.ledger["kinetic_energy"],
            0.04);
    check(v > 0., "it rolls down");
  }

  /**
   * A block with mu = 0.5 under gravity that rises over 0.3 s: what it slides
   * after this first contact.
   */
  void
  check_block(const std::string &folder, const double degrees)
  {
    ParameterFile file(folder + "/slope-friction.prm");
    file.set(gravity(degrees));
    const SceneParameters<2> parameters(file);
    RunningScene<2>          run(parameters);
    const std::string        what =
      "block on " + std::to_string(int(degrees)) + " degrees";
    const auto slid = [&](const double t) {
      return g *
             (std::sin(radians(degrees)) - 0.5 * std::cos(radians(degrees))) *
             (t * t / 2. - 0.15 * t + 0.015);
    };
    if (std::tan(radians(degrees)) > 0.5)
      {
        // while gravity rises it bends into its place
        run.advance_to(0.3 - 1e-9);
        const double before = way(run);
        run.advance_to(0.6 - 1e-9);
        const double found = way(run) - before, right = slid(0.6) - slid(0.3);
        at_most(what + ", " + shortest(found) + " m of " + shortest(right) +
                  " from 0.3 s on, misfit",
                std::abs(found / right - 1.),
                0.02);
        at_most(what + ", " + shortest(way(run)) + " m of " +
                  shortest(slid(0.6)) + " in all, misfit",
                std::abs(way(run) / slid(0.6) - 1.),
                0.025);
      }
    else
      {
        // elastic: its shear and the springs of what sticks
        run.advance_to(0.4 - 1e-9);
        const double before = way(run);
        run.advance_to(0.6 - 1e-9);
        at_most(what + ": it stays, way in m", std::abs(way(run)), 0.01);
        at_most(what + ": it does not creep, m",
                std::abs(way(run) - before),
                0.005);
        at_most(what + ": slip, of the work of gravity",
                run.ledger["friction_dissipation"] /
                  std::abs(test::total_mass(run.scene) * g *
                           std::sin(radians(degrees)) * way(run)),
                0.02);
      }
    check_balance(run, what);
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  if (argc != 2)
    {
      std::cerr << "write the folder of the scenes: prm/examples\n";
      return 1;
    }
  const std::string folder = argv[1];
  for (const bool rolls : {true, false})
    check_disc(folder, rolls);
  for (const double degrees : {20., 40.})
    check_block(folder, degrees);
  return test::report();
}
