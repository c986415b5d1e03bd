// Scenes of bodies that meet: numbers of a prototype that shares no code, two
// squares head-on; smooth lattices that slide over each other without bumps;
// mirrored and renamed bodies; two discs off their axis.

#include "../check.h"
#include "../scene.h"

#include <iomanip>
#include <iostream>

using namespace emmy;
using test::at_most;
using test::check;
using test::RunningScene;

namespace
{
  const std::string of_prototype =
    "set Geometry = start\nset Starved nodes = free\n";
  const std::string narrow = "set Radius = 1\nset Exponent = 2\n"
                             "set Points per direction = 1\n"
                             "set Stiffness factor = 1\n";

  /** Two bodies that meet. */
  struct Pair
  {
    std::string upper = "5, 2", cells = "20, 8";
    std::string poisson = "0";
    /** Bodies, the first and the second. */
    std::string first = "1, 0.5", first_end = "2, 1.5", second = "2.5, 0.5",
                second_end   = "3.5, 1.5";
    std::string  first_speed = "1; 0", second_speed = "-1; 0";
    std::string  names = "a, b", groups = "a | b";
    unsigned int points = 2;
    std::string  method, contact, walls = "", effects = "contact", sections;
    std::string  tolerance = "1e-15";
    double       step = 0.01, end = 0.6;

    static std::string
    body(const std::string &name,
         const std::string &lower,
         const std::string &upper,
         const std::string &speed,
         const unsigned int points)
    {
      return "subsection " + name +
             "\nset Shape = box\nset Material = m\nset Points per direction = " +
             std::to_string(points) + "\nset Initial velocity = " + speed +
             "\nsubsection box\nset Lower corner = " + lower +
             "\nset Upper corner = " + upper + "\nend\nend\n";
    }

    std::string
    text() const
    {
      return "set Dimension = 2\nsubsection Grid\nset Lower corner = 0, 0\n"
             "set Upper corner = " +
             upper + "\nset Cells = " + cells +
             "\nend\nsubsection Materials\nset Names = m\nsubsection m\n"
             "set Model = Hencky\nset Density = 1\nset Young's modulus = 100\n"
             "set Poisson's ratio = " +
             poisson + "\nend\nend\nsubsection Bodies\nset Names = " + names +
             "\n" + body("a", first, first_end, first_speed, points) +
             body("b", second, second_end, second_speed, points) +
             "end\nsubsection Boundary conditions\nset Roller = " + walls +
             "\nend\nsubsection Effects\nset Names = " + effects + "\n" +
             sections + "subsection Contact\nset Groups = " + groups + "\n" +
             contact + "end\nend\nsubsection Method\n" + method +
             "end\nsubsection Time\nset Step rule = fixed\nset Step size = " +
             shortest(step) + "\nset End time = " + shortest(end) +
             "\nend\nsubsection Solver\nset Newton tolerance = " + tolerance +
             "\nend\n";
    }
  };

  /** Mean velocity of a body. */
  dealii::Tensor<1, 2>
  speed_of(const Scene<2> &scene, const unsigned int body)
  {
    dealii::Tensor<1, 2> v;
    double               mass = 0.;
    for (const auto &particle : scene.particles)
      {
        const auto values = particle.get_properties();
        if (values[scene.layout["body"]] != body)
          continue;
        const double m = values[scene.layout["mass"]];
        mass += m;
        for (unsigned int d = 0; d < 2; ++d)
          v[d] += m * values[scene.layout["velocity"] + d];
      }
    mass = dealii::Utilities::MPI::sum(mass, scene.grid.communicator());
    return dealii::Utilities::MPI::sum(v, scene.grid.communicator()) / mass;
  }

  void
  check_balances(const RunningScene<2> &run, const std::string &what)
  {
    double scale = test::largest(run.column("kinetic_energy"));
    for (const char *column : {"strain_energy", "contact_energy"})
      scale = std::max(scale, test::largest(run.column(column)));
    at_most(what + ": balance",
            test::largest(run.column("balance_error")) / scale,
            1e-12);
    double its = 0.;
    for (const double n : run.column("newton_iterations"))
      its += n;
    at_most(what + ": iterations of Newton, mean",
            its / (run.ledger.rows().size() - 1),
            6.);
    at_most(what + ": iterations of Newton, most",
            test::largest(run.column("newton_iterations")),
            25.);
    const auto &columns = run.ledger.columns();
    if (std::count(columns.begin(), columns.end(), "friction_dissipation") == 0)
      return;
    const auto lost  = run.column("friction_dissipation");
    double     least = 0.;
    for (unsigned int row = 1; row < lost.size(); ++row)
      least = std::min(least, lost[row] - lost[row - 1]);
    at_most(what + ": slip that gives energy", -least / scale, 1e-15);
  }

  struct HeadOn
  {
    std::string  name, method, contact;
    unsigned int points;
    double       step, speed, kinetic, strain; ///< 0: not known
  };

  void
  check_head_on()
  {
    const std::vector<HeadOn> cases{
      {"GIMP",
       of_prototype,
       narrow,
       2,
       0.01,
       -0.9833960426,
       0.9826234416,
       0.01737655841},
      {"linear",
       of_prototype + "set Shape functions = linear\n",
       narrow,
       8,
       0.02,
       -0.9390001,
       0.904325,
       0.},
      {"wide",
       "set Geometry = start\nset Starved threshold = 0.1\n",
       "set Stiffness factor = 0.3\n",
       2,
       0.01,
       -0.9930096728,
       0.,
       0.}};
    for (const HeadOn &head_on : cases)
      {
        Pair pair;
        pair.method  = head_on.method;
        pair.contact = head_on.contact;
        pair.points  = head_on.points;
        pair.step    = head_on.step;
        const SceneParameters<2> parameters(
          ParameterFile::from_text(pair.text(), head_on.name));
        RunningScene<2> run(parameters);
        run.advance(std::lround(0.6 / head_on.step));
        const std::string what = "head-on, " + head_on.name;
        check_balances(run, what);
        // numbers are known to 1e-6 or their last digit
        at_most(what + ", speed of the prototype",
                std::abs(speed_of(run.scene, 0)[0] - head_on.speed),
                1e-6);
        if (head_on.kinetic > 0.)
          at_most(what + ", kinetic energy of the prototype",
                  std::abs(run.ledger["kinetic_energy"] - head_on.kinetic),
                  1e-6);
        if (head_on.strain > 0.)
          at_most(what + ", strain energy of the prototype",
                  std::abs(run.ledger["strain_energy"] - head_on.strain),
                  1e-6);
      }
    // beside them
    Pair                     by_default;
    const SceneParameters<2> parameters(
      ParameterFile::from_text(by_default.text(), "by default"));
    RunningScene<2> run(parameters);
    run.advance(60);
    check_balances(run, "head-on, by default");
    std::cout << std::setprecision(8) << "head-on, by default: speed "
              << speed_of(run.scene, 0)[0] << " m/s, kinetic energy "
              << run.ledger["kinetic_energy"] << " J, strain energy "
              << run.ledger["strain_energy"]
              << " J; of the prototype, narrow -0.9833960426, 0.9826234416, "
                 "0.01737655841, wide -0.9930096728\n";
  }

  /** What a block that slides over a smooth bed loses or wins of 1 m/s. */
  double
  bumps(const std::string &contact)
  {
    Pair pair;
    pair.upper        = "6, 3";
    pair.cells        = "24, 12";
    pair.poisson      = "0.3";
    pair.first        = "0, 0";
    pair.first_end    = "6, 1";
    pair.second       = "1, 1.08";
    pair.second_end   = "2, 2.08";
    pair.first_speed  = "0; 0";
    pair.second_speed = "1; 0";
    pair.method       = "set Geometry = start\n";
    pair.contact      = contact;
    pair.walls        = "x-min, x-max, y-min";
    pair.effects      = "contact, gravity";
    pair.sections     = "subsection Gravity\nset Acceleration = 0, -2\n"
                        "set Amplitude table = 0: 0, 0.3: 1\nend\n";
    const SceneParameters<2> parameters(
      ParameterFile::from_text(pair.text(), "bumps"));
    RunningScene<2> run(parameters);
    run.advance(100);
    check_balances(run, "block on a bed");
    return std::abs(speed_of(run.scene, 1)[0] - 1.);
  }

  /** Two blocks that meet and rub, as they are, mirrored and renamed. */
  void
  check_relations(const std::string &geometry)
  {
    Pair as_it_is;
    as_it_is.method       = "set Geometry = " + geometry + "\n";
    as_it_is.contact      = "set Friction coefficient = 0.4\n";
    as_it_is.second_speed = "-1; 0.7";
    as_it_is.end          = 0.5;
    Pair mirrored         = as_it_is;
    mirrored.first        = "3, 0.5";
    mirrored.first_end    = "4, 1.5";
    mirrored.second       = "1.5, 0.5";
    mirrored.second_end   = "2.5, 1.5";
    mirrored.first_speed  = "-1; 0";
    mirrored.second_speed = "1; 0.7";
    Pair renamed          = as_it_is;
    renamed.names         = "b, a";
    renamed.groups        = "b | a";
    const auto run_of     = [](const Pair &pair) {
      const SceneParameters<2> parameters(
        ParameterFile::from_text(pair.text(), "relations"));
      auto run = std::make_unique<RunningScene<2>>(parameters);
      run->advance(50);
      return run;
    };
    const auto run = run_of(as_it_is);
    check_balances(*run, "rubbing, " + geometry);
    const double scale = test::largest(run->column("kinetic_energy"));
    for (const Pair *other : {&mirrored, &renamed})
      {
        const auto same = run_of(*other);
        for (const char *column : {"kinetic_energy",
                                   "strain_energy",
                                   "contact_energy",
                                   "friction_energy",
                                   "friction_dissipation"})
          {
            double error = 0.;
            for (unsigned int row = 0; row < run->ledger.rows().size(); ++row)
              error = std::max(error,
                               std::abs(run->column(column)[row] -
                                        same->column(column)[row]));
            at_most(geometry +
                      (other == &mirrored ? ", mirrored: " : ", renamed: ") +
                      column,
                    error / scale,
                    1e-12);
            check(test::largest(run->column(column)) > 1e-6 * scale,
                  std::string("there is ") + column);
          }
      }
    // a Newton that stops early loses neither energy nor the sign of the slip
    as_it_is.tolerance = "1e-2";
    const SceneParameters<2> parameters(
      ParameterFile::from_text(as_it_is.text(), "stopped"));
    RunningScene<2> stopped(parameters);
    stopped.most_residual_work = 1.;
    stopped.advance(50);
    check(std::abs(stopped.ledger["residual_work"]) > 1e-9 * scale,
          "Newton has stopped early");
    check_balances(stopped, "stopped early, " + geometry);
  }

  /** Of the particles of two bodies that are nearest, between their boxes. */
  double
  gap_of(const Scene<2> &scene, const double spacing)
  {
    std::array<std::vector<dealii::Point<2>>, 2> places;
    for (const auto &particle : scene.particles)
      places[particle.get_properties()[scene.layout["body"]]].push_back(
        particle.get_location());
    double least = std::numeric_limits<double>::max();
    for (const auto &x : places[0])
      for (const auto &y : places[1])
        least = std::min(least, x.distance(y));
    return least - spacing;
  }

  void
  check_discs(const std::string &path)
  {
    const SceneParameters<2> parameters{ParameterFile(path)};
    RunningScene<2>          run(parameters);
    double                   first_touch = -1.;
    for (unsigned int step = 0; step < 140; ++step)
      {
        run.advance(1);
        if (first_touch < 0. && run.ledger["contact_pairs"] > 0.)
          first_touch = gap_of(run.scene, 0.25);
      }
    check_balances(run, "two discs");
    check(first_touch > 0., "they touch");
    at_most("two discs: distance of the first touch, m", first_touch, 0.3);
    const auto pairs = run.column("contact_pairs");
    check(test::largest({pairs.end() - 20, pairs.end()}) == 0.,
          "two discs: they have parted");
    check(speed_of(run.scene, 0)[0] < -0.4, "two discs: the left flies back");
    // 35 x 35 particles in a cell of 2 m, one contact point each
    at_most("two discs: strain energy, of that of many particles, less one",
            std::abs(test::largest(run.column("strain_energy")) / 28.6727 - 1.),
            0.03);
    const auto spin = run.column("angular_momentum_z");
    at_most("two discs: angular momentum made",
            std::abs(spin.back() / spin.front() - 1.),
            1e-10);
  }

  /** Bodies that overlap are pushed apart, and that is booked. */
  void
  check_overlap()
  {
    Pair pair;
    pair.second     = "2, 0.5";
    pair.second_end = "3, 1.5";
    const SceneParameters<2> parameters(
      ParameterFile::from_text(pair.text(), "overlap"));
    RunningScene<2> run(parameters);
    check(run.ledger["contact_energy"] > 1e-3 &&
            run.ledger["contact_energy"] == run.ledger["contact_overlap_work"],
          "what overlaps has stored energy");
    run.advance(20);
    check_balances(run, "overlap");
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_head_on();
  for (const char *geometry : {"start", "middle"})
    check_relations(geometry);
  at_most("smooth bed: change of 1 m/s", bumps(""), 0.01);
  check(bumps(narrow) > 0.1, "narrow points find bumps");
  check_overlap();
  check_discs(argv[1]);
  return test::report();
}
