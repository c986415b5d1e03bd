// Random scenes of all that contact has at once: two bodies with friction
// between them, a floor that rises and rubs, a drum that comes and turns, a lid
// that a force pushes. Laws that hold in each of them; those of energy also
// where Newton stops early; the same scene mirrored, and with other names and
// another order.

#include "../check.h"
#include "../scene.h"

#include <emmy/base/text.h>

#include <random>

using namespace emmy;
using test::at_most;
using test::check;
using test::RunningScene;

namespace
{
  constexpr double width = 4.; // m, of the grid

  /** What is written in two ways, and what a seed decides. */
  struct Crowd
  {
    unsigned int seed        = 1;
    std::string  geometry    = "start";
    std::string  tolerance   = "1e-24";
    bool         is_mirrored = false, is_renamed = false;

    double
    x(const double value) const
    {
      return is_mirrored ? width - value : value;
    }
    /** Of a direction or an angle. */
    double
    along(const double value) const
    {
      return is_mirrored ? -value : value;
    }

    std::string
    body(const std::string           &name,
         const std::array<double, 4> &box,
         const std::array<double, 3> &speed,
         const std::string           &points) const
    {
      const double left  = std::min(x(box[0]), x(box[2])),
                   right = std::max(x(box[0]), x(box[2]));
      return "subsection " + name +
             "\nset Shape = box\nset Material = m\n"
             "set Points per direction = " +
             points + "\nset Initial velocity = " +
             // it turns about (2, 1)
             shortest(along(speed[0])) + " - " + shortest(along(speed[2])) +
             "*(y - 1); " + shortest(speed[1]) + " + " +
             shortest(along(speed[2])) + "*(x - 2)\nsubsection box\n" +
             "set Lower corner = " + shortest(left) + ", " + shortest(box[1]) +
             "\nset Upper corner = " + shortest(right) + ", " +
             shortest(box[3]) + "\nend\nend\n";
    }

    std::string
    text() const
    {
      std::mt19937 numbers(seed);
      const auto   any = [&](const double least, const double most) {
        // not the library's distribution, which is its own affair
        return least + (most - least) * (numbers() % 1001) / 1000.;
      };
      const std::string a        = is_renamed ? "zinc" : "a",
                        b        = is_renamed ? "ash" : "b",
                        floor    = is_renamed ? "zone" : "floor",
                        drum     = is_renamed ? "arm" : "drum";
      const std::string bodies[] = {
        body(a,
             {{1., 0.75, 1.75, 1.5}},
             {{any(0.2, 1.), any(-0.4, 0.), any(-0.3, 0.3)}},
             "2"),
        body(b,
             {{2., 0.75, 2.75, 1.25}},
             {{any(-1., -0.2), any(-0.4, 0.), any(-0.3, 0.3)}},
             "3")};
      const std::string rough = shortest(any(0.1, 0.6)),
                        rise  = shortest(any(0.1, 0.5));
      // one after the other: the order within an expression is the compiler's
      const double floor_friction = any(0.1, 0.6), floor_way = any(-0.3, 0.3),
                   floor_slope = any(-0.05, 0.05), drum_friction = any(0.1, 1.),
                   drum_way = any(-1., -0.5), drum_turn = any(-3., 3.),
                   lid_force = any(5., 20.), lid_mass = any(0.5, 2.),
                   lid_speed    = any(0., 1.);
      const std::string tools[] = {
        "subsection " + floor +
          "\nset Shape = plane\nset Friction coefficient = " +
          shortest(floor_friction) +
          "\nset Reference point = " + shortest(x(2.)) +
          ", 0.72\nset Displacement = " + shortest(along(floor_way)) + "*t; " +
          rise + "*t\nsubsection plane\nset Normal = " +
          shortest(along(floor_slope)) + ", 1\nend\nend\n",
        "subsection " + drum +
          "\nset Shape = ball\nset Friction coefficient = " +
          shortest(drum_friction) +
          "\nset Reference point = " + shortest(x(3.2)) +
          ", 1.1\nset Displacement = " + shortest(along(drum_way)) +
          "*t; 0\nset Rotation = " + shortest(along(drum_turn)) +
          "*t\nsubsection ball\nset Radius = 0.42\nend\nend\n",
        "subsection lid\nset Shape = plane\nset Friction coefficient = 0.2\n"
        "set Reference point = " +
          shortest(x(2.)) + ", 1.52\nset Pushed along = " +
          shortest(along(0.1)) + ", -1\nset Force = " + shortest(lid_force) +
          "\nset Mass = " + shortest(lid_mass) +
          "\nset Initial speed = " + shortest(lid_speed) +
          "\nsubsection plane\nset Normal = " + shortest(along(0.02)) +
          ", -1\nend\nend\n"};
      return "set Dimension = 2\nsubsection Grid\nset Lower corner = 0, 0\n"
             "set Upper corner = 4, 2.5\nset Cells = 8, 5\nend\n"
             "subsection Method\nset Geometry = " +
             geometry +
             "\nend\nsubsection Materials\nset Names = m\nsubsection m\n"
             "set Model = Hencky\nset Density = 5\n"
             "set Young's modulus = 100\nset Poisson's ratio = 0.3\nend\nend\n"
             "subsection Bodies\nset Names = " +
             (is_renamed ? b + ", " + a : a + ", " + b) + "\n" +
             bodies[is_renamed ? 1 : 0] + bodies[is_renamed ? 0 : 1] +
             "end\nsubsection Effects\nset Names = contact, tools\n"
             "subsection Contact\nset Groups = " +
             (is_renamed ? b + " | " + a : a + " | " + b) +
             "\nset Friction coefficient = " + rough +
             "\nend\nsubsection Tools\nset Names = " +
             (is_renamed ? "lid, " + drum + ", " + floor
                         : floor + ", " + drum + ", lid") +
             "\n" + tools[0] + tools[1] + tools[2] +
             "end\nend\nsubsection Time\nset End time = 1\n"
             "set Step rule = fixed\nset Step size = 0.04\nend\n"
             "subsection Solver\nset Newton tolerance = " +
             tolerance + "\nend\n";
    }
  };

  std::unique_ptr<RunningScene<2>>
  run_of(const Crowd &crowd)
  {
    const SceneParameters<2> parameters(
      ParameterFile::from_text(crowd.text(), "crowd"));
    auto run = std::make_unique<RunningScene<2>>(parameters);
    if (crowd.tolerance != Crowd().tolerance)
      run->most_residual_work = 1.;
    run->advance(12);
    return run;
  }

  /** What holds whatever Newton leaves. */
  void
  check_energies(const RunningScene<2> &run, const std::string &what)
  {
    const double scale = run.ledger.largest_energy();
    at_most(what + "balance of energy",
            test::largest(run.column("balance_error")) / scale,
            1e-12);
    const auto lost = run.column("friction_dissipation");
    at_most(what + "slip that gives energy",
            -test::least_change(lost) / scale,
            1e-15);
    check(lost.back() > 1e-6 * scale, what + "there is slip");
  }

  /** Momenta are those that tools give: nothing else acts from outside. */
  void
  check_momenta(const RunningScene<2> &run,
                const std::string     &what,
                const bool             is_start)
  {
    const auto            dt   = run.column("time_step");
    const auto            spin = run.column("angular_momentum_z");
    double                turn = spin.back() - spin.front();
    std::array<double, 2> push{}, size{};
    for (unsigned int d = 0; d < 2; ++d)
      {
        const auto p = run.column(std::string("linear_momentum_") + "xy"[d]);
        push[d]      = p.back() - p.front();
        size[d]      = test::largest(p);
      }
    for (const std::string name : {"tool_floor", "tool_drum", "tool_lid"})
      {
        const auto x = run.column(name + "_x"), y = run.column(name + "_y"),
                   fx     = run.column(name + "_force_x"),
                   fy     = run.column(name + "_force_y"),
                   moment = run.column(name + "_moment_z");
        check(std::max(test::largest(fx), test::largest(fy)) > 1e-3,
              what + name + " touches");
        for (unsigned int row = 1; row < dt.size(); ++row)
          {
            push[0] += dt[row] * fx[row];
            push[1] += dt[row] * fy[row];
            turn +=
              dt[row] * (moment[row] + 0.5 * (x[row] + x[row - 1]) * fy[row] -
                         0.5 * (y[row] + y[row - 1]) * fx[row]);
          }
      }
    at_most(what + "linear momentum made",
            std::max(std::abs(push[0]), std::abs(push[1])) /
              std::max(size[0], size[1]),
            1e-12);
    at_most(what + "angular momentum made",
            std::abs(turn) / test::largest(spin),
            is_start ? 1e-12 : 1e-10);
  }

  void
  check_relations(const Crowd &crowd, const RunningScene<2> &run)
  {
    for (const bool is_mirrored : {true, false})
      {
        Crowd other       = crowd;
        other.is_mirrored = is_mirrored;
        other.is_renamed  = !is_mirrored;
        const auto same   = run_of(other);
        for (const char *column : {"kinetic_energy",
                                   "strain_energy",
                                   "contact_energy",
                                   "friction_energy",
                                   "friction_dissipation",
                                   "tool_lid_kinetic_energy"})
          {
            const auto one = run.column(column), two = same->column(column);
            std::vector<double> difference = one;
            for (unsigned int row = 0; row < one.size(); ++row)
              difference[row] -= two.at(row);
            at_most(crowd.geometry +
                      (is_mirrored ? ", mirrored: " : ", renamed: ") + column,
                    test::largest(difference) / run.ledger.largest_energy(),
                    1e-11);
          }
      }
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  for (const char *geometry : {"start", "middle"})
    for (unsigned int seed = 1; seed <= 3; ++seed)
      {
        Crowd crowd;
        crowd.seed     = seed;
        crowd.geometry = geometry;
        const std::string what =
          std::string(geometry) + ", seed " + std::to_string(seed) + ": ";
        const auto run = run_of(crowd);
        check_energies(*run, what);
        check_momenta(*run, what, crowd.geometry == "start");
        if (seed == 1)
          check_relations(crowd, *run);
        crowd.tolerance    = "1e-2";
        const auto stopped = run_of(crowd);
        check(test::largest(stopped->column("residual_work")) >
                1e-9 * stopped->ledger.largest_energy(),
              what + "Newton stops early");
        check_energies(*stopped, "stopped early, " + what);
      }
  return test::report();
}
