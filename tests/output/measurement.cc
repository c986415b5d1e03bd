// Facts about measurements, on one or several ranks: the path of a particle in
// free flight is a line, whatever cells and ranks it passes; the extent of a
// spinning square is that of the turned square; both are what the particles
// say; a scene that measures nothing has no column, and measuring changes no
// other number.

#include "../check.h"
#include "../scene.h"

using namespace emmy;
using test::check;
using test::check_close;

namespace
{
  /** A box from 1 to 2 m in all directions, free in its grid. */
  template <int dim>
  std::string
  box(const std::string &velocity, const std::string &more)
  {
    const auto in_space = [](const std::string &text) {
      return dim == 3 ? text : std::string();
    };
    return "set Dimension = " + std::to_string(dim) +
           "\nsubsection Method\nset Shape functions = linear\n"
           "set Starved nodes = free\nend\n"
           "subsection Grid\nset Lower corner = 0, 0" +
           in_space(", 0") + "\nset Upper corner = 6, 3" + in_space(", 3") +
           "\nset Cells = 12, 6" + in_space(", 6") +
           "\nend\nsubsection Materials\nset Names = rubber\n"
           "subsection rubber\nset Model = Hencky\nset Density = 5\n"
           "set Young's modulus = 1e4\nset Poisson's ratio = 0.3\nend\nend\n"
           "subsection Bodies\nset Names = left, right\n"
           "subsection left\nset Shape = box\nset Material = rubber\n"
           "set Points per direction = 2\nset Initial velocity = " +
           velocity + "\nsubsection box\nset Lower corner = 1, 1" +
           in_space(", 1") + "\nset Upper corner = 2, 2" + in_space(", 2") +
           "\nend\nend\n"
           "subsection right\nset Shape = box\nset Material = rubber\n"
           "set Points per direction = 2\n"
           "subsection box\nset Lower corner = 5, 0.5" +
           in_space(", 0.5") + "\nset Upper corner = 5.5, 1" + in_space(", 1") +
           "\nend\nend\nend\nsubsection Time\nset End time = 2\n"
           "set Step rule = fixed\nset Step size = 0.0625\nend\n"
           "subsection Solver\nset Newton tolerance = 1e-15\nend\n" +
           more;
  }

  /** A section Measurements: of each its name and entries. */
  std::string
  measure(const std::vector<std::pair<std::string, std::string>> &measurements)
  {
    std::string names, sections;
    for (const auto &[name, entries] : measurements)
      {
        names += (names.empty() ? "" : ", ") + name;
        sections += "subsection " + name + "\n" + entries + "\nend\n";
      }
    return "subsection Measurements\nset Names = " + names + "\n" + sections +
           "end\n";
  }

  const std::string gimp = "Method/Shape functions=GIMP";

  /** All columns that the test measures. */
  template <int dim>
  std::string
  path_and_extents()
  {
    const std::string z = dim == 3 ? ", 1.1" : "";
    return measure({{"tip", "set Type = particle\nset Nearest to = 2, 1.9" + z},
                    {"middle",
                     "set Type = particle\nset Body = left\n"
                     "set Nearest to = 1.5, 1.5" +
                       std::string(dim == 3 ? ", 1.5" : "")},
                    {"far",
                     "set Type = particle\nset Body = right\n"
                     "set Nearest to = 2, 1.9" +
                       z},
                    {"left", "set Type = extent\nset Body = left"},
                    {"all", "set Type = extent"}});
  }

  template <int dim>
  void
  check_flight(const bool has_domains)
  {
    const std::string name =
      std::to_string(dim) + "D, " + (has_domains ? "GIMP, " : "linear, ");
    ParameterFile file =
      ParameterFile::from_text(box<dim>(dim == 2 ? "1; 0.3" : "1; 0.3; -0.2",
                                        path_and_extents<dim>()),
                               "test");
    if (has_domains)
      file.set(gimp);
    const SceneParameters<dim> parameters(file);
    test::RunningScene<dim>    run(parameters);
    run.advance(32);

    const double velocity[] = {1., 0.3, -0.2};
    // points sit 1/8 m inside the faces of a body; boxes reach the faces
    const double inside = has_domains ? 0. : 0.125;
    // in z the particles with 1.125, as 1.1 is nearest to them
    const double tip[] = {1.875, 1.875, 1.125}, far[] = {5.125, 0.875, 0.875};
    double       worst = 0.;
    for (const auto &row : run.ledger.rows())
      {
        const auto value = [&](const std::string &column) {
          const auto &names = run.ledger.columns();
          return row[std::find(names.begin(), names.end(), column) -
                     names.begin()];
        };
        for (unsigned int d = 0; d < dim; ++d)
          {
            const std::string x(1, "xyz"[d]);
            const double      way    = velocity[d] * row[1];
            const auto        expect = [&](const std::string &column,
                                    const double       position) {
              worst = std::max(worst, std::abs(value(column) - position));
            };
            expect("tip_" + x, tip[d] + way);
            expect("middle_" + x, 1.5 + way);
            expect("far_" + x, far[d]);
            expect("left_lower_" + x, 1. + inside + way);
            expect("left_upper_" + x, 2. - inside + way);
            expect("all_lower_" + x,
                   std::min(1. + way, d == 0 ? 5. : 0.5) + inside);
            expect("all_upper_" + x,
                   std::max(2. + way, d == 0 ? 5.5 : 1.) - inside);
          }
      }
    check_close(worst, 0., 2e-13, name + "paths and extents are lines");
    if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
      std::cout << name << "farthest from a line " << worst << " m\n";
    check(run.ledger.rows().size() == 33 && run.ledger["time"] == 2.,
          name + "32 steps of 1/16 s");
  }

  /** 2 rad/s about the centre of the left box. */
  const std::string spin = "-2*(y-1.5); 2*(x-1.5)";

  void
  check_spin()
  {
    const SceneParameters<2> parameters(
      ParameterFile::from_text(box<2>(spin, path_and_extents<2>()), "test"));
    test::RunningScene<2> run(parameters);
    double                largest_stretch = 0., smallest = 1.;
    for (unsigned int step = 0; step < 32; ++step)
      {
        run.advance(1);
        // the square of the points, turned; it breathes, as nothing held it
        const double angle = 2. * run.ledger["time"];
        const double side =
          0.75 * (std::abs(std::cos(angle)) + std::abs(std::sin(angle)));
        for (const std::string x : {"x", "y"})
          {
            const double stretch =
              (run.ledger["left_upper_" + x] - run.ledger["left_lower_" + x]) /
              side;
            largest_stretch = std::max(largest_stretch, stretch);
            smallest        = std::min(smallest, stretch);
          }
        check_close(0.5 *
                      (run.ledger["left_upper_x"] + run.ledger["left_lower_x"]),
                    1.5,
                    1e-10,
                    "a square that spins stays where it is");
        check_close(run.ledger["middle_y"],
                    1.5,
                    1e-10,
                    "and so does its middle");
        // what the particles themselves say
        double upper = 0.;
        for (const auto &particle : run.scene.particles)
          if (particle.get_properties()[run.scene.layout["body"]] == 0.)
            upper = std::max(upper, particle.get_location()[1]);
        upper = dealii::Utilities::MPI::max(upper, MPI_COMM_WORLD);
        check(upper == run.ledger["left_upper_y"],
              "the extent is the particles'");
      }
    if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
      std::cout << "spinning square, extent / that of a rigid one: " << smallest
                << " to " << largest_stretch << '\n';
    check(smallest > 0.97 && largest_stretch < 1.03,
          "the extent of a stiff square that spins, within 3 %");
  }

  void
  check_absence()
  {
    const auto run = [](const std::string &more) {
      const SceneParameters<2> parameters(
        ParameterFile::from_text(box<2>(spin, more), "test"));
      test::RunningScene<2> running(parameters);
      running.advance(5);
      return std::make_pair(running.ledger.columns(), running.ledger.rows());
    };
    const auto absent = run(""), present = run(path_and_extents<2>());
    check(absent.first.back() == "overfill", "absent: no column");
    check(present.first.size() == absent.first.size() + 3 * 2 + 2 * 4,
          "present: its columns");
    bool is_same = absent.second.size() == present.second.size();
    for (unsigned int row = 0; is_same && row < absent.second.size(); ++row)
      is_same = std::equal(absent.second[row].begin(),
                           absent.second[row].end(),
                           present.second[row].begin());
    check(is_same, "measuring changes no other number");
    const SceneParameters<2> parameters(
      ParameterFile::from_text(box<2>(spin, ""), "test"));
    test::RunningScene<2> running(parameters);
    running.advance(1);
    for (const Phases::Row &phase : running.scene.phases.rows())
      check(phase.name != "measurements", "absent: no time");
  }

  void
  check_errors()
  {
    const auto refused = [](const std::string              &entries,
                            const std::vector<std::string> &words,
                            const std::string              &name = "tip") {
      test::check_throws_with(
        [&] {
          const SceneParameters<2> parameters(
            ParameterFile::from_text(box<2>("0; 0", measure({{name, entries}})),
                                     "test"));
          test::RunningScene<2> run(parameters);
        },
        words);
    };
    const std::string particle = "set Type = particle\n";
    refused("", {"<Measurements/tip/Type>", "required", "particle, extent"});
    refused("set Type = extend",
            {"<Measurements/tip/Type> is <extend>", "did you mean <extent>?"});
    refused(particle, {"<Measurements/tip/Nearest to>", "2 coordinates in m"});
    refused(particle + "set Nearest to = 7, 1",
            {"<Measurements/tip/Nearest to> is <7, 1>", "outside the grid"});
    refused(particle + "set Nearest to = 1, 1\nset Body = lefd",
            {"<Measurements/tip/Body> is <lefd>",
             "did you mean <left>?",
             "Bodies/Names: left, right"});
    refused("set Type = extent\nset Nearest to = 1, 1",
            {"unknown parameter <Measurements/tip/Nearest to>"});
    refused(particle + "set Nearest to = 1, 1",
            {"<Measurements/Names> is <linear_momentum_x>",
             "two columns of this name"},
            "linear_momentum");
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_flight<2>(false);
  check_flight<2>(true);
  check_flight<3>(false);
  check_flight<3>(true);
  check_spin();
  check_absence();
  check_errors();
  ParameterFile square =
    ParameterFile::from_text(box<2>(spin, path_and_extents<2>()), "test");
  square.set(gimp);
  square.set("Method/Starved nodes=follow");
  test::compare_ranks<2>(square,
                         16,
                         "spinning square, GIMP",
                         {"tip_x",
                          "tip_y",
                          "middle_x",
                          "far_y",
                          "left_lower_x",
                          "left_upper_x",
                          "left_lower_y",
                          "left_upper_y",
                          "all_upper_x"});
  return test::report();
}
