// Scenes of bodies that meet: numbers of a prototype that shares no code, two
// squares head-on; smooth lattices that slide over each other without bumps;
// mirrored and renamed bodies; two discs off their axis.

#include "../check.h"
#include "../scene.h"

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
    std::string  method, contact, walls = "", more;
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
             "\nend\nsubsection Effects\nset Names = contact\n"
             "subsection Contact\nset Groups = " +
             groups + "\n" + contact + "end\nend\nsubsection Method\n" +
             method +
             "end\nsubsection Time\nset Step rule = fixed\nset Step size = " +
             shortest(step) + "\nset End time = " + shortest(end) +
             "\nend\nsubsection Solver\nset Newton tolerance = 1e-15\nend\n" +
             more;
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
       "",
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
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_head_on();
  return test::report();
}
