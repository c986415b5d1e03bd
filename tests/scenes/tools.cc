// Scenes with rigid tools, on one or several ranks. Closed forms: a cube under
// a plate takes what Hencky's law says, one on a slope sticks or slides as
// Coulomb says, a disc rolls. Numbers of a prototype that shares no code. All
// close to round-off, also where Newton stops early.

#include "../check.h"
#include "../scene.h"

#include "tool_scenes.h"

#include <iomanip>
#include <iostream>

using namespace emmy;

namespace
{
  using Case = test::ToolCase;
  using test::at_most;
  using test::bounce;
  using test::check;
  using test::drop;
  using test::middle_of;
  using test::of_prototype;
  using test::plate;
  using test::press;
  using test::RunningScene;
  using test::slope;
  using test::tube;

  /** Relative to the largest energy there is. */
  template <int dim>
  void
  check_balance(const RunningScene<dim> &run, const std::string &what)
  {
    const double scale = run.ledger.largest_energy();
    at_most(what + ": balance",
            test::largest(run.column("balance_error")) / scale,
            1e-12);
    // to round-off; how many it takes by default:
    // tests/program/tool_examples.sh
    at_most(what + ": iterations of Newton, most",
            test::largest(run.column("newton_iterations")),
            25.);
    const auto &columns = run.ledger.columns();
    if (std::count(columns.begin(), columns.end(), "friction_dissipation") == 0)
      return;
    const auto lost = run.column("friction_dissipation");
    at_most(what + ": slip that gives energy",
            -test::least_change(lost) / scale,
            1e-15);
  }

  void
  check_number(const double       found,
               const double       right,
               const double       tolerance,
               const std::string &what)
  {
    at_most(what, std::abs(found / right - 1.), tolerance);
  }

  void
  check_press()
  {
    {
      Case as_prototype   = press("100");
      as_prototype.method = of_prototype;
      const SceneParameters<2> parameters(
        ParameterFile::from_text(as_prototype.text(), "press"));
      RunningScene<2> run(parameters);
      run.advance(20);
      check_balance(run, "press");
      check_number(run.ledger["tool_plate_force_y"],
                   362754.725,
                   1e-8,
                   "press, force of the prototype");
      check_number(run.ledger["tool_plate_work"],
                   41105.495,
                   1e-8,
                   "press, work of the prototype");
      check_number(run.ledger["contact_energy"],
                   88.108,
                   1e-5,
                   "press, contact energy of the prototype");
    }
    // at the default stiffness, and with ten times that
    for (const auto &[stiffness, tolerance] :
         {std::make_pair("", 3e-3), {"1000", 5e-4}})
      {
        const SceneParameters<2> parameters(
          ParameterFile::from_text(press(stiffness).text(), "press"));
        RunningScene<2> run(parameters);
        run.advance(20);
        check_balance(run, "press, default");
        if (std::string(stiffness).empty())
          std::cout << std::setprecision(8) << "press, by default: force "
                    << run.ledger["tool_plate_force_y"] << " N, work "
                    << run.ledger["tool_plate_work"] << " J, contact energy "
                    << run.ledger["contact_energy"]
                    << " J; of the prototype 362754.725, 41105.495, 88.108\n";
        // in the middle of the last step
        const double stretch = 0.75625;
        check_number(run.ledger["tool_plate_force_y"],
                     -1e6 * std::log(stretch) / stretch,
                     tolerance,
                     std::string("press, Hencky, stiffness ") + stiffness);
      }
  }

  /** The same with the geometry of the middle, GIMP and followers. */
  void
  print_slope_by_default(const double degrees)
  {
    Case by_default   = slope(degrees);
    by_default.method = "";
    const SceneParameters<2> parameters(
      ParameterFile::from_text(by_default.text(), "slope"));
    RunningScene<2> run(parameters);
    const auto      start = middle_of(run.scene).first;
    run.advance(degrees == 20. ? 20 : 30);
    const auto [x, v] = middle_of(run.scene);
    std::cout << std::setprecision(8) << "slope of " << degrees
              << " degrees, by default: way " << x[0] - start[0] << " m, speed "
              << v[0] << " m/s, slip " << run.ledger["friction_dissipation"]
              << " J; of the prototype "
              << (degrees == 20. ? "0.00525974 m, 0.16490272 J"
                                 : "0.27702692 m, 1.18126349 m/s, 992.89249 J")
              << '\n';
  }

  void
  check_slope()
  {
    const double angle = 40. / 180. * dealii::numbers::PI;
    for (const double degrees : {20., 40.})
      {
        const SceneParameters<2> parameters(
          ParameterFile::from_text(slope(degrees).text(), "slope"));
        RunningScene<2> run(parameters);
        const auto      start = middle_of(run.scene).first;
        run.advance(degrees == 20. ? 20 : 30);
        const std::string what =
          "slope of " + std::to_string(int(degrees)) + " degrees";
        check_balance(run, what);
        const auto [x, v] = middle_of(run.scene);
        check_number(x[0] - start[0],
                     degrees == 20. ? 0.00525974 : 0.27702692,
                     1e-6,
                     what + ", way of the prototype");
        check_number(run.ledger["friction_dissipation"],
                     degrees == 20. ? 0.16490272 : 992.89249,
                     1e-6,
                     what + ", slip of the prototype");
        print_slope_by_default(degrees);
        if (degrees == 20.)
          continue;
        check_number(v[0], 1.18126349, 1e-6, what + ", speed of the prototype");
        const double t = 0.6;
        check_number(x[0] - start[0],
                     10. * (std::sin(angle) - 0.5 * std::cos(angle)) *
                       (t * t / 2. - t * 0.15 + 0.015),
                     0.02,
                     what + ", Coulomb");
      }
  }

  void
  check_tubes()
  {
    for (const bool draws : {false, true})
      {
        const SceneParameters<2> parameters(
          ParameterFile::from_text(tube(draws).text(), "tube"));
        RunningScene<2> run(parameters);
        run.advance(200);
        const std::string what = draws ? "drawn bar" : "pressed bar";
        check_balance(run, what);
        const double strain = std::log(draws ? 1.5 : 0.5);
        check_number(run.ledger["tool_plate_work"],
                     1e5 * strain * strain,
                     3e-3,
                     what + ", work of Hencky's law");
        at_most(what + ", kinetic energy over its work",
                run.ledger["kinetic_energy"] / run.ledger["tool_plate_work"],
                1e-3);
      }
  }

  template <int dim>
  void
  check_bounce()
  {
    const std::string what = std::to_string(dim) + "D, bounce";
    {
      const SceneParameters<dim> parameters(
        ParameterFile::from_text(bounce<dim>(dim == 2 ? "0.65" : "0.61").text(),
                                 "bounce"));
      RunningScene<dim> run(parameters);
      run.advance(dim == 2 ? 40 : 10);
      check_balance(run, what);
      at_most(what + ": a tool at rest works",
              run.ledger["tool_plate_work"],
              0.);
      if (dim == 2)
        check(run.ledger["linear_momentum_y"] > 0., what + ": it flies back");
      check(run.ledger["friction_dissipation"] > 0., what + ": it rubs");
    }
    // what overlaps is pushed out, and its energy is booked
    const SceneParameters<dim> parameters(
      ParameterFile::from_text(bounce<dim>(dim == 2 ? "0.8" : "0.65").text(),
                               "overlap"));
    RunningScene<dim> run(parameters);
    const double      stored = run.ledger["contact_energy"];
    check(stored > 0. && stored == run.ledger["tool_plate_work"],
          what + ": overlap is stored, and work of the tool");
    check(run.scene.notes[0].find("overlaps bodies by up to") !=
            std::string::npos,
          what + ": overlap is told: " + run.scene.notes[0]);
    run.advance(3);
    check_balance(run, what + " from an overlap");
  }

  /** The balance knows what Newton has left. */
  void
  check_stopped()
  {
    const std::string text = slope(40.).text() +
                             "subsection Solver\nset Newton tolerance = 1e-2\n"
                             "end\n";
    // the entry of before counts no more
    std::string       first = text;
    const std::string exact = "set Newton tolerance = 1e-15\n";
    first.erase(first.find(exact), exact.size());
    const SceneParameters<2> parameters(
      ParameterFile::from_text(first, "stopped"));
    RunningScene<2> run(parameters);
    run.most_residual_work = 1.;
    run.advance(30);
    check_balance(run, "stopped");
    check(std::abs(run.ledger["residual_work"]) >
            1e-9 * run.ledger["kinetic_energy"],
          "Newton has left something");
  }

  /**
   * A disc on a slope of 30 degrees that does not slide: a = 2/3 g sin. Its
   * edge has stairs; it is soft, so that it does not hop on them.
   */
  void
  check_roll()
  {
    Case roll    = slope(30.);
    roll.modulus = 1e5;
    roll.upper   = "4, 2";
    roll.cells   = "16, 8";
    roll.shape  = "set Shape = ball\nsubsection ball\nset Center = 0.75, 0.75\n"
                  "set Radius = 0.5\nend\n";
    roll.method = "";
    roll.time   = "set Step size = 0.01\nset End time = 1\n";
    roll.sections = "subsection Gravity\nset Acceleration = 5, "
                    "-8.66025403784439\nend\n";
    roll.tools    = plate("0, 0.25", "0, 1", "set Friction coefficient = 1\n");
    const SceneParameters<2> parameters(
      ParameterFile::from_text(roll.text(), "roll"));
    RunningScene<2> run(parameters);
    run.advance(100);
    check_balance(run, "roll");
    // it swings on its stairs: the mean from 0.4 s on
    const auto time     = run.column("time"),
               momentum = run.column("linear_momentum_x");
    const double mass   = test::total_mass(run.scene);
    double       ratio  = 0.;
    for (unsigned int row = 40; row < time.size(); ++row)
      ratio +=
        momentum[row] / (mass * 10. / 3. * time[row]) / (time.size() - 40);
    check_number(ratio, 1., 0.05, "roll, speed of a rigid disc");
    at_most("roll, lost of its energy",
            run.ledger["friction_dissipation"] / run.ledger["kinetic_energy"],
            0.04);
  }

  void
  check_drop()
  {
    const SceneParameters<2> parameters(
      ParameterFile::from_text(drop().text(), "drop"));
    RunningScene<2> run(parameters);
    run.advance(115);
    check_balance(run, "drop");
    const auto momentum   = run.column("tool_plate_momentum"),
               force      = run.column("tool_plate_force_y");
    const double most     = *std::max_element(force.begin(), force.end());
    const double by_hooke = 0.2 * 0.5 * std::sqrt(1e6 * 1000.);
    check(by_hooke < most && most < 1.1 * by_hooke,
          "drop, largest force between Hooke's law and Boussinesq's waves");
    check_number(-momentum.back(), momentum.front(), 0.01, "drop, rebound");
    unsigned int n = 0;
    for (const double value : force)
      n += value > 0. ? 1 : 0;
    check_number(n * 0.001,
                 dealii::numbers::PI * std::sqrt(1e-3),
                 0.02,
                 "drop, time of contact");
  }

  /** A side that only pushes lets go of what a plane tool lets go of. */
  void
  check_side()
  {
    Case by_tool            = bounce<2>("0");
    by_tool.shape           = "set Shape = ball\nsubsection ball\n"
                              "set Center = 1.5, 0.55\nset Radius = 0.5\nend\n";
    by_tool.tools           = plate("1.5, 0", "0, 1", "");
    Case by_side            = by_tool;
    by_side.effects         = "";
    by_side.tools           = "";
    std::string       text  = by_side.text();
    const std::string walls = "set Roller = \n";
    text.insert(text.find(walls), "set Contact = y-min\n");
    const SceneParameters<2> of_tool(
      ParameterFile::from_text(by_tool.text(), "tool"));
    RunningScene<2> tool(of_tool);
    tool.advance(30);
    const auto               force_of_tool = tool.column("tool_plate_force_y");
    const SceneParameters<2> of_side(ParameterFile::from_text(text, "side"));
    RunningScene<2>          side(of_side);
    side.advance(30);
    check(side.column("tool_y_min_force_y") == force_of_tool,
          "a side that pushes is a plane");
    check(test::largest(force_of_tool) > 0. &&
            side.ledger["tool_y_min_force_y"] == 0. &&
            side.ledger["linear_momentum_y"] > 0.,
          "it pushes, and lets go");
    check_balance(side, "side");
  }

  /** A thin plate that is faster than it is thick does not jump over a body. */
  void
  check_fast()
  {
    Case fast         = press("10");
    fast.walls        = "";
    fast.time         = "set Step size = 0.1\nset End time = 1\n";
    fast.upper_of_box = "0.5, 0.5";
    fast.tools        = "set Names = blade\nsubsection blade\nset Shape = box\n"
                        "set Reference point = 0.25, 1\n"
                        "set Displacement = 0; -12*t\nsubsection box\n"
                        "set Size = 1, 0.1\nset Rounding = 0.05\nend\nend\n";
    const SceneParameters<2> parameters(
      ParameterFile::from_text(fast.text(), "fast"));
    RunningScene<2> run(parameters);
    run.advance(1);
    check(run.ledger["time_step"] < 0.1, "a step over a body is halved");

    // a soft penalty lets a body sink in, and the log says so
    const Case               soft = press("0.5");
    const SceneParameters<2> of_soft(
      ParameterFile::from_text(soft.text(), "soft"));
    RunningScene<2> sinking(of_soft);
    std::string     told;
    for (unsigned int step = 0; step < 8; ++step)
      {
        const StepReport report = sinking.scene.advance();
        sinking.ledger.add(report);
        for (const std::string &finding : report.findings)
          told += finding;
      }
    check(sinking.ledger["tool_plate_sinking"] > 0.05 &&
            told.find("sink into the tool <plate> by up to") !=
              std::string::npos,
          "what sinks in is told: " + told);
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const bool                               is_alone =
    dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD) == 1;
  if (is_alone)
    {
      check_press();
      check_slope();
      check_tubes();
      check_bounce<2>();
      check_bounce<3>();
      check_stopped();
      check_roll();
      check_fast();
      check_drop();
      check_side();
    }
  else
    {
      const std::vector<std::string> columns{"kinetic_energy",
                                             "contact_energy",
                                             "tool_plate_force_x",
                                             "tool_plate_force_y",
                                             "tool_plate_moment_z",
                                             "friction_dissipation"};
      test::compare_ranks<2>(ParameterFile::from_text(slope(40.).text(),
                                                      "slope"),
                             12,
                             "slope",
                             columns);
      test::compare_ranks<2>(ParameterFile::from_text(bounce<2>("0.8").text(),
                                                      "bounce"),
                             8,
                             "bounce",
                             columns);
      test::compare_ranks<2>(
        ParameterFile::from_text(tube(true).text(), "tube"),
        8,
        "drawn bar",
        {"strain_energy", "tool_plate_work", "tool_plate_force_x"});
      test::compare_ranks<2>(ParameterFile::from_text(drop().text(), "drop"),
                             20,
                             "drop",
                             {"strain_energy",
                              "tool_plate_kinetic_energy",
                              "tool_plate_momentum"});
    }
  return test::report();
}
