// Facts about the effect tools: a block among tools that move, turn, rub, and
// are pushed by a force keeps all its balances; the equation of a step has the
// derivative that it says, whether places stay or follow; what cannot be is
// refused.

#include "tangent.h"

#include <fstream>

using namespace emmy;
using test::at_most;
using test::check;

namespace
{
  /** A soft block in a corner of tools, some of which turn. */
  template <int dim>
  std::string
  cornered(const std::string &geometry)
  {
    const auto in = [](const std::string &plane, const std::string &space) {
      return dim == 2 ? plane : space;
    };
    return "set Dimension = " + std::to_string(dim) +
           "\nsubsection Grid\nset Lower corner = " + in("0, 0", "0, 0, 0") +
           "\nset Upper corner = " + in("3, 3", "3, 3, 3") +
           "\nset Cells = " + in("6, 6", "6, 6, 6") +
           "\nend\nsubsection Method\nset Geometry = " + geometry +
           "\nset Starved nodes = follow\nend\n"
           "subsection Materials\nset Names = m\nsubsection m\n"
           "set Model = Hencky\nset Density = 5\n"
           "set Young's modulus = 100\nset Poisson's ratio = 0.3\nend\nend\n"
           "subsection Bodies\nset Names = block\nsubsection block\n"
           "set Shape = box\nset Material = m\nset Points per direction = 2\n"
           "set Initial velocity = -0.9 + 0.2*y; -0.4 + 0.3*x" +
           in("", "; 0.2*x") +
           "\nsubsection box\nset Lower corner = " + in("1, 1", "1, 1, 1") +
           "\nset Upper corner = " + in("2, 2", "2, 2, 1.5") +
           "\nend\nend\nend\nsubsection Effects\nset Names = tools\n"
           "subsection Tools\nset Names = floor, drum, punch, hammer\n"
           "subsection floor\nset Shape = plane\nset Friction coefficient = "
           "0.3\nset Reference point = " +
           in("1, 0.98", "1, 0.98, 0") +
           "\nset Displacement = " + in("0.1*t; 0.4*t", "0.1*t; 0.4*t; 0") +
           "\nsubsection plane\nset Normal = " + in("0.05, 1", "0.05, 1, 0.1") +
           "\nend\nend\nsubsection hammer\nset Shape = ball\n"
           "set Friction coefficient = 0.2\nset Reference point = " +
           in("2.5, 1.4", "2.5, 1.4, 1.2") +
           "\nset Displacement = " + in("0.02*t; 0.2*t", "0.02*t; 0.2*t; 0") +
           "\nset Rotation = t\n" + in("", "set Rotation axis = 0, 1, 1\n") +
           "set Pushed along = " + in("-1, 0.1", "-1, 0.1, 0") +
           "\nset Force = -20 - 10*t\nset Mass = 0.4\n"
           "set Initial speed = 3\nsubsection ball\nset Radius = 0.48\n"
           "end\nend\nsubsection drum\nset Shape = ball\n"
           "set Stiffness = 4\nset Friction coefficient = 5\n"
           "set Reference point = " +
           in("0.5, 1.6", "0.5, 1.6, 1.2") + "\nset Rotation = 2*t\n" +
           in("", "set Rotation axis = 0.1, 0.2, 1\n") +
           "subsection ball\nset Radius = 0.53\nend\nend\n"
           "subsection punch\nset Shape = " +
           in("box", "mesh") +
           "\nset Reference point = " + in("1.6, 2.2", "1.6, 2.2, 1.2") +
           "\nset Displacement = " + in("0; -0.5*t", "0; -0.5*t; 0") +
           "\nset Rotation = -t\n" + in("", "set Rotation axis = 0, 0, 1\n") +
           in("subsection box\nset Size = 0.5, 0.5\nset Rounding = 0.25\n",
              "subsection mesh\nset File = punch.off\nset Scale = 0.15\n"
              "set Rounding = 0.1\n") +
           "end\nend\nend\nend\n"
           "subsection Time\nset End time = 1\nset Step rule = fixed\n"
           "set Step size = 0.04\nend\n"
           "subsection Solver\nset Newton tolerance = 1e-15\nend\n";
  }

  /** A cube from -1 to 1, with one side drawn in to a point. */
  void
  write_punch()
  {
    std::ofstream file("punch.off");
    file << "OFF\n9 14 0\n";
    for (unsigned int i = 0; i < 8; ++i)
      file << (i & 1 ? 1 : -1) << ' ' << (i & 2 ? 1 : -1) << ' '
           << (i & 4 ? 1 : -1) << '\n';
    file << "0 0.6 0\n";
    for (const char *face : {"0 2 1",
                             "1 2 3",
                             "4 5 6",
                             "5 7 6",
                             "0 1 4",
                             "1 5 4",
                             "0 4 2",
                             "4 6 2",
                             "1 3 5",
                             "3 7 5",
                             "2 6 8",
                             "6 7 8",
                             "7 3 8",
                             "3 2 8"})
      file << "3 " << face << '\n';
  }

  /** Balances of a run, and that all that can happen does. */
  template <int dim>
  void
  check_run(const std::string &geometry)
  {
    const SceneParameters<dim> parameters(
      ParameterFile::from_text(cornered<dim>(geometry), "test"));
    test::RunningScene<dim> run(parameters);
    run.advance(dim == 2 ? 12 : 9);
    const std::string what  = std::to_string(dim) + "D, " + geometry + ": ";
    const double      scale = test::largest(run.column("kinetic_energy"));
    at_most(what + "balance of energy",
            test::largest(run.column("balance_error")) / scale,
            1e-12);
    const auto lost  = run.column("friction_dissipation");
    double     least = 0.;
    for (unsigned int row = 1; row < lost.size(); ++row)
      least = std::min(least, lost[row] - lost[row - 1]);
    at_most(what + "slip that gives energy", -least / scale, 1e-15);
    for (const char *column :
         {"contact_energy", "friction_energy", "friction_dissipation"})
      check(std::abs(run.ledger[column]) > 1e-6 * scale,
            what + "there is " + column);
    for (const char *tool : {"floor", "drum", "punch", "hammer"})
      check(test::largest(run.column(std::string("tool_") + tool + "_work")) >
              1e-3 * scale,
            what + tool + " works");
    // the impulses of the tools are what the body gains, but for what Newton
    // may leave: 1e-8 of the forces
    const auto dt = run.column("time_step");
    for (unsigned int d = 0; d < dim; ++d)
      {
        const std::string axis(1, "xyz"[d]);
        const auto        momentum = run.column("linear_momentum_" + axis);
        double            sum      = momentum.back() - momentum.front();
        for (const char *tool : {"floor", "drum", "punch", "hammer"})
          {
            const auto force =
              run.column(std::string("tool_") + tool + "_force_" + axis);
            for (unsigned int row = 1; row < dt.size(); ++row)
              sum += dt[row] * force[row];
          }
        at_most(what + "momentum without a tool",
                std::abs(sum) / test::largest(momentum),
                1e-9);
      }
    // a tool gains what force and bodies give it, to round-off
    const auto of_hammer = run.column("tool_hammer_momentum"),
               time      = run.column("time");
    double gained = of_hammer.back() - of_hammer.front(), most = 0.;
    for (unsigned int row = 1; row < dt.size(); ++row)
      {
        double along = 20. + 10. * (time[row] - 0.5 * dt[row]); // against e
        for (unsigned int d = 0; d < 2; ++d)
          along -=
            run.column(std::string("tool_hammer_force_") + "xy"[d])[row] *
            (d == 0 ? -1. : 0.1) / std::sqrt(1.01);
        gained += dt[row] * along;
        most = std::max(most, dt[row] * std::abs(along));
      }
    at_most(what + "momentum of a tool that is pushed",
            std::abs(gained) / test::largest(of_hammer),
            1e-13);
    check(most > 0.1 * test::largest(of_hammer) &&
            std::abs(of_hammer.front() - 1.2) < 1e-15,
          what + "forces act on it");
    // and their moments, about the origin
    const auto spin = run.column("angular_momentum_z");
    double     sum  = spin.back() - spin.front();
    for (const char *tool : {"floor", "drum", "punch", "hammer"})
      {
        const auto of = [&](const char *name) {
          return run.column(std::string("tool_") + tool + name);
        };
        const auto x = of("_x"), y = of("_y"), fx = of("_force_x"),
                   fy = of("_force_y"), moment = of("_moment_z");
        for (unsigned int row = 1; row < dt.size(); ++row)
          sum +=
            dt[row] * (moment[row] + 0.5 * (x[row] + x[row - 1]) * fy[row] -
                       0.5 * (y[row] + y[row - 1]) * fx[row]);
      }
    at_most(what + "angular momentum without a tool",
            std::abs(sum) / test::largest(spin),
            geometry == "start" ? 1e-9 : 1e-8);
  }

  void
  check_refusals()
  {
    const auto refused = [](const std::string              &tools,
                            const std::vector<std::string> &words,
                            const std::string &walls = "x-min, y-min") {
      const std::string text =
        "set Dimension = 2\nsubsection Grid\nset Lower corner = 0, 0\n"
        "set Upper corner = 2, 2\nset Cells = 4, 4\nend\n"
        "subsection Materials\nset Names = m\nsubsection m\n"
        "set Model = Hencky\nset Density = 1\nset Young's modulus = 1\n"
        "set Poisson's ratio = 0\nend\nend\nsubsection Bodies\n"
        "set Names = b\nsubsection b\nset Shape = box\nset Material = m\n"
        "set Points per direction = 1\nsubsection box\n"
        "set Lower corner = 0, 0\nset Upper corner = 1, 1\nend\nend\nend\n"
        "subsection Boundary conditions\nset Roller = " +
        walls +
        "\nend\nsubsection Effects\nset Names = tools\nsubsection Tools\n" +
        tools +
        "end\nend\nsubsection Time\nset Step rule = fixed\n"
        "set Step size = 0.1\nset End time = 1\nend\n";
      test::check_throws_with(
        [&] {
          const SceneParameters<2> parameters(
            ParameterFile::from_text(text, "refused"));
          Scene<2>(parameters, MPI_COMM_WORLD);
        },
        words);
    };
    const auto tool = [](const std::string &statements) {
      return "set Names = it\nsubsection it\n" + statements + "end\n";
    };
    const std::string plane =
      "set Reference point = 0, 1\nsubsection plane\nset Normal = 0, -1\nend\n"
      "set Shape = plane\n";
    refused("", {"Effects/Tools/Names", "at least one tool"});
    refused(tool(""), {"Effects/Tools/it/Shape", "Known are: plane, ball"});
    refused(tool("set Shape = plain\n"), {"did you mean <plane>?"});
    refused(tool("set Shape = plane\nsubsection plane\nset Normal = 0, 1\n"
                 "end\n"),
            {"it/Reference point", "2 coordinates"});
    refused(tool("set Reference point = 0, 1\nset Shape = plane\n"),
            {"it/plane/Normal", "2 components, not all zero"});
    refused(tool(plane + "set Stiffness = -1\n"), {"it/Stiffness", "positive"});
    refused(tool(plane + "set Friction coefficient = -1\n"),
            {"it/Friction coefficient", "not be negative"});
    refused(tool(plane + "set Holds = true\nset Friction coefficient = 1\n"),
            {"it/Friction coefficient", "slides along it without friction"});
    refused(tool(
              "set Shape = plane\nset Reference point = 0, 1.1\n"
              "set Holds = true\nsubsection plane\nset Normal = 0, -1\nend\n"),
            {"Effects/Tools/it", "nothing touches the tool at the start"});
    refused(tool("set Shape = ball\nset Reference point = 0, 2\nset Holds = "
                 "true\nsubsection ball\nset Radius = 1\nend\n"),
            {"it/Holds", "only a plane can hold"});
    const std::string pushed = plane + "set Pushed along = 0, -1\n";
    refused(tool(plane + "set Force = 1\n"),
            {"it/Force", "nothing pushes the tool"});
    refused(tool(pushed + "set Force = 1\n"), {"it/Mass", "positive"});
    refused(tool(pushed + "set Mass = 1\n"),
            {"it/Force", "required for a tool that is pushed"});
    refused(tool(pushed + "set Mass = 1\nset Force = x\n"),
            {"it/Force", "Write a formula in t"});
    refused(tool(plane + "set Displacement = t\n"),
            {"it/Displacement", "Write 2 components"});
    refused(tool(plane + "set Velocity table = 0: 0, 0; 1\n"),
            {"it/Velocity table", "cannot be read"});
    refused(tool(plane +
                 "set Velocity table = 0: 0, 0\nset Displacement = t; 0\n"),
            {"it/Displacement", "<Velocity table> is given too"});
    refused(tool(plane + "set Displacement table = 0: 0, 0; 0: 1, 1\n"),
            {"it/Displacement table", "two places at a time"});
    refused(tool("set Shape = box\nset Reference point = 0, 2\nsubsection box\n"
                 "set Size = 1, 1\nset Rounding = 0.6\nend\n"),
            {"it/box/Rounding", "not larger than half the size"});
    refused(tool(plane),
            {"Velocity of y-max",
             "name <tools> in Effects/Names",
             "Holds = true"},
            "x-min, y-min, y-max\nset Velocity of y-max = -0.1");
  }

  /** In the second step the hammer touches, in the third it has left. */
  template <int dim>
  void
  check_derivatives()
  {
    for (const unsigned int n_steps : {1u, 2u})
      {
        const std::string after = ", step " + std::to_string(n_steps + 1);
        const double      start =
          test::check_tangent_of_start<dim>(cornered<dim>("start"),
                                            "start" + after,
                                            n_steps);
        const double middle =
          test::check_tangent_of_middle<dim>(cornered<dim>("middle"),
                                             "middle" + after,
                                             n_steps);
        if (n_steps == 1)
          check(std::min(start, middle) > 1e-4,
                std::to_string(dim) + "D" + after +
                  ": the hammer's way matters");
        else
          check(std::max(start, middle) == 0.,
                std::to_string(dim) + "D" + after + ": it has left");
      }
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  write_punch();
  for (const char *geometry : {"start", "middle"})
    {
      check_run<2>(geometry);
      check_run<3>(geometry);
    }
  check_derivatives<2>();
  check_derivatives<3>();
  check_refusals();
  return test::report();
}
