// Scenes with rigid tools, on one or several ranks. Closed forms: a cube under
// a plate takes what Hencky's law says, one on a slope sticks or slides as
// Coulomb says, a disc rolls. Numbers of a prototype that shares no code. All
// close to round-off, also where Newton stops early.

#include "../check.h"
#include "../scene.h"

using namespace emmy;
using test::at_most;
using test::check;
using test::RunningScene;

namespace
{
  /** A square or cube of 1 m, or a ball, and what acts on it. */
  struct Case
  {
    unsigned int dim   = 2;
    std::string  upper = "1.25, 1.25", cells = "5, 5";
    std::string  lower_of_box = "0, 0", upper_of_box = "1, 1";
    std::string  shape; ///< in place of the box
    std::string  velocity = "";
    unsigned int points   = 2;
    double       density = 1., modulus = 1e6, poisson = 0.;
    std::string  walls = "", effects = "tools", sections, method, time;
    std::string  tools;

    std::string
    text() const
    {
      return "set Dimension = " + std::to_string(dim) +
             "\nsubsection Grid\nset Lower corner = " +
             (dim == 2 ? "0, 0" : "0, 0, 0") + "\nset Upper corner = " + upper +
             "\nset Cells = " + cells +
             "\nend\nsubsection Materials\nset Names = m\nsubsection m\n"
             "set Model = Hencky\nset Density = " +
             shortest(density) +
             "\nset Young's modulus = " + shortest(modulus) +
             "\nset Poisson's ratio = " + shortest(poisson) +
             "\nend\nend\nsubsection Bodies\nset Names = body\n"
             "subsection body\nset Material = m\nset Initial velocity = " +
             velocity +
             "\nset Points per direction = " + std::to_string(points) + "\n" +
             (shape.empty() ? "set Shape = box\nsubsection box\n"
                              "set Lower corner = " +
                                lower_of_box + "\nset Upper corner = " +
                                upper_of_box + "\nend\n"
                            : shape) +
             "end\nend\nsubsection Boundary conditions\nset Roller = " + walls +
             "\nend\nsubsection Effects\nset Names = " + effects + "\n" +
             sections + "subsection Tools\n" + tools +
             "end\nend\nsubsection Method\n" + method +
             "end\nsubsection Time\nset Step rule = fixed\n" + time +
             "end\nsubsection Solver\nset Newton tolerance = 1e-15\nend\n";
    }
  };

  const std::string of_prototype =
    "set Geometry = start\nset Starved nodes = free\n";

  /** A smooth plate, as a section; more statements for it. */
  std::string
  plate(const std::string &point,
        const std::string &normal,
        const std::string &more)
  {
    return "set Names = plate\nsubsection plate\nset Shape = plane\n"
           "set Reference point = " +
           point + "\n" + more + "subsection plane\nset Normal = " + normal +
           "\nend\nend\n";
  }

  Case
  press(const std::string &stiffness)
  {
    Case result;
    result.walls = "x-min, y-min";
    result.time  = "set Step size = 0.05\nset End time = 1\n";
    result.tools =
      plate("0.5, 1",
            "0, -1",
            "set Displacement = 0; -0.25*t\nset Stiffness = " + stiffness +
              "\n");
    return result;
  }

  Case
  slope(const double degrees)
  {
    const double angle = degrees / 180. * dealii::numbers::PI;
    Case         result;
    result.upper        = "6, 2.5";
    result.cells        = "24, 10";
    result.lower_of_box = "0.5, 0.5";
    result.upper_of_box = "1.5, 1.5";
    result.points       = 4;
    result.density      = 1000.;
    result.poisson      = 0.3;
    result.effects      = "gravity, tools";
    result.sections     = "subsection Gravity\nset Acceleration = " +
                      shortest(10. * std::sin(angle)) + ", " +
                      shortest(-10. * std::cos(angle)) +
                      "\nset Amplitude table = 0: 0, 0.3: 1\nend\n";
    result.method = of_prototype + "set Shape functions = linear\n";
    result.time   = "set Step size = 0.02\nset End time = 1\n";
    result.tools  = plate("0, 0.5", "0, 1", "set Friction coefficient = 0.5\n");
    return result;
  }

  /** Where the body's middle is, and how fast. */
  template <int dim>
  std::pair<dealii::Tensor<1, dim>, dealii::Tensor<1, dim>>
  middle_of(const Scene<dim> &scene)
  {
    dealii::Tensor<1, dim> x, v;
    double                 mass = 0.;
    for (const auto &particle : scene.particles)
      {
        const auto   values = particle.get_properties();
        const double m      = values[scene.layout["mass"]];
        mass += m;
        x += m * dealii::Tensor<1, dim>(particle.get_location());
        for (unsigned int d = 0; d < dim; ++d)
          v[d] += m * values[scene.layout["velocity"] + d];
      }
    mass = dealii::Utilities::MPI::sum(mass, scene.grid.communicator());
    return {dealii::Utilities::MPI::sum(x, scene.grid.communicator()) / mass,
            dealii::Utilities::MPI::sum(v, scene.grid.communicator()) / mass};
  }

  /** Relative to the largest energy there is. */
  template <int dim>
  void
  check_balance(const RunningScene<dim> &run, const std::string &what)
  {
    double scale = 0.;
    for (const char *column :
         {"kinetic_energy", "strain_energy", "contact_energy"})
      scale = std::max(scale, test::largest(run.column(column)));
    at_most(what + ": balance",
            test::largest(run.column("balance_error")) / scale,
            1e-12);
    const auto &columns = run.ledger.columns();
    if (std::count(columns.begin(), columns.end(), "friction_dissipation") == 0)
      return;
    const auto lost  = run.column("friction_dissipation");
    double     least = 0.;
    for (unsigned int row = 1; row < lost.size(); ++row)
      least = std::min(least, lost[row] - lost[row - 1]);
    at_most(what + ": slip that gives energy", -least / scale, 1e-15);
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
    for (const auto &[stiffness, tolerance] :
         {std::make_pair("100", 3e-3), {"1000", 5e-4}})
      {
        const SceneParameters<2> parameters(
          ParameterFile::from_text(press(stiffness).text(), "press"));
        RunningScene<2> run(parameters);
        run.advance(20);
        check_balance(run, "press, default");
        // in the middle of the last step
        const double stretch = 0.75625;
        check_number(run.ledger["tool_plate_force_y"],
                     -1e6 * std::log(stretch) / stretch,
                     tolerance,
                     std::string("press, Hencky, stiffness ") + stiffness);
      }
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
    }
  return test::report();
}
