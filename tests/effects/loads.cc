// Facts about loads, on one or several ranks: amplitudes take the values of
// their formula or table, the work of a load is what its forces do along the
// paths of the particles, a free body gains the momentum that the loads give,
// the choice of particles does not depend on the ranks, and a load that is not
// named leaves no trace.

#include <emmy/effects/amplitude.h>

#include "../check.h"
#include "../scene.h"

using namespace emmy;
using test::check;
using test::check_close;

namespace
{
  /** A soft block, free in the middle of its grid, that drifts and deforms. */
  template <int dim>
  std::string
  block(const std::string &effects)
  {
    const bool        is_space = dim == 3;
    const std::string corner   = is_space ? ", 1" : "";
    return std::string("set Dimension = ") + (is_space ? "3" : "2") +
           "\nsubsection Method\nset Shape functions = linear\nset Starved nodes = free\nend\n"
           "subsection Grid\nset Lower corner = 0, 0" +
           (is_space ? ", 0" : "") + "\nset Upper corner = 4, 3" +
           (is_space ? ", 3" : "") +
           "\nset Cells = " + (is_space ? "4, 3, 3" : "8, 6") +
           "\nend\nsubsection Materials\nset Names = rubber\n"
           "subsection rubber\nset Model = Hencky\nset Density = 5\n"
           "set Young's modulus = 100\nset Poisson's ratio = 0.3\nend\nend\n"
           "subsection Bodies\nset Names = block\nsubsection block\n"
           "set Shape = box\nset Material = rubber\n"
           "set Points per direction = 3\nset Initial velocity = 0.4; -0.1" +
           (is_space ? "; 0.2" : "") +
           "\nsubsection box\nset Lower corner = 1, 1" + corner +
           "\nset Upper corner = 2.5, 2" + (is_space ? ", 2" : "") +
           "\nend\nend\nend\nsubsection Effects\n" + effects +
           "\nend\nsubsection Time\nset End time = 2\n"
           "set Step rule = fixed\nset Step size = 0.125\nend\n"
           "subsection Solver\nset Newton tolerance = 1e-15\nend\n";
  }

  // 4t, then a jump at 0.5 s from 2 to -1, then up to 0 at 1 s
  const std::string table      = "0: 0, 0.5: 2, 0.5: -1, 1: 0";
  const std::string formula    = "if(t <= 0.5, 4*t, if(t < 1, 2*t - 2, 0))";
  const std::string as_table   = "set Amplitude table = " + table + "\n";
  const std::string as_formula = "set Amplitude = " + formula + "\n";
  double
  in_closed_form(const double t)
  {
    return t <= 0.5 ? 4. * t : t < 1. ? 2. * t - 2. : 0.;
  }

  double
  sample(const AmplitudeParameters &parameters,
         const double               time,
         const double               time_step)
  {
    return Amplitude(parameters, "test").over(time, time_step);
  }

  void
  check_amplitudes()
  {
    AmplitudeParameters parameters;
    check(Amplitude().over(3., 1.) == 1. && sample(parameters, 3., 1.) == 1.,
          "the amplitude is 1 by default");
    for (const std::string sampling : {"mid", "end"})
      for (const bool has_table : {false, true})
        {
          parameters            = AmplitudeParameters();
          parameters.sampling   = sampling;
          parameters.table      = has_table ? table : "";
          parameters.expression = has_table ? "1" : formula;
          const double part     = sampling == "mid" ? 0.5 : 1.;
          for (double t = -0.5; t < 1.5; t += 0.125)
            {
              const double where = t + part * 0.25;
              // a table is constant before its first time
              const double expected =
                has_table && where < 0. ? 0. : in_closed_form(where);
              check_close(sample(parameters, t, 0.25),
                          expected,
                          0.,
                          std::string(has_table ? "table, " : "formula, ") +
                            sampling + ", t = " + std::to_string(where));
            }
        }
    // steps of 0.1 add up to a little more than 0.3
    parameters.table    = "0: 5, 0.3: 5, 0.3: 7";
    parameters.sampling = "end";
    check(0.1 + 0.1 + 0.1 > 0.3 && sample(parameters, 0.1 + 0.1, 0.1) == 5.,
          "round-off does not carry a step over a jump");
    check(sample(parameters, 0.2, 0.10001) == 7., "a jump has come");
    parameters.table = "1: 3";
    check(sample(parameters, 0., 0.1) == 3. && sample(parameters, 2., 1.) == 3.,
          "a table of one time is constant");
    parameters.table      = "";
    parameters.expression = "1/(t - 1)";
    test::check_throws_with([&] { sample(parameters, 0.75, 0.25); },
                            {"test: Amplitude <1/(t - 1)> is inf at t = 1 s",
                             "must be finite"});
  }

  /** What the work of a load is made of. */
  template <int dim>
  struct Particle
  {
    dealii::Point<dim> position;
    double             share, mass;
  };

  /** All particles of all ranks by id. */
  template <int dim>
  std::map<unsigned int, Particle<dim>>
  collect(const Scene<dim> &scene)
  {
    std::map<unsigned int, std::vector<double>> own;
    const bool has_share = scene.layout.has("point_load_share");
    for (const auto &particle : scene.particles)
      {
        auto      &values     = own[particle.get_id()];
        const auto properties = particle.get_properties();
        values = {has_share ? properties[scene.layout["point_load_share"]] : 0.,
                  properties[scene.layout["mass"]]};
        for (unsigned int d = 0; d < dim; ++d)
          values.push_back(particle.get_location()[d]);
      }
    std::map<unsigned int, Particle<dim>> all;
    for (const auto &part :
         dealii::Utilities::MPI::all_gather(scene.grid.communicator(), own))
      for (const auto &[id, values] : part)
        {
          Particle<dim> &particle = all[id];
          particle.share          = values[0];
          particle.mass           = values[1];
          for (unsigned int d = 0; d < dim; ++d)
            particle.position[d] = values[2 + d];
        }
    return all;
  }

  /** The loads of a run: what acts at full amplitude, and when it is taken. */
  template <int dim>
  struct Loads
  {
    std::string            effects;
    dealii::Tensor<1, dim> force;                         // N, shared
    dealii::Tensor<1, dim> gravity;                       // m/s^2
    double      force_sample = 0.5, gravity_sample = 0.5; // part of the step
    std::string fixed = "";
  };

  /** Work and, of a free body, momentum, step by step. */
  template <int dim>
  void
  check_work(const std::string &name, const Loads<dim> &loads)
  {
    ParameterFile file =
      ParameterFile::from_text(block<dim>(loads.effects), "test");
    if (!loads.fixed.empty())
      {
        file.set("Boundary conditions/Fixed=" + loads.fixed);
        file.set("Grid/Lower corner=1, 0");
        file.set("Grid/Upper corner=5, 3");
        file.set("Bodies/block/Initial velocity=0; 0");
      }
    const SceneParameters<dim> parameters(file);
    test::RunningScene<dim>    run(parameters);
    dealii::Tensor<1, dim>     momentum; // expected
    for (unsigned int d = 0; d < dim; ++d)
      momentum[d] = run.ledger[std::string("linear_momentum_") + "xyz"[d]];

    double work = 0., size = 0., impulse = momentum.norm(), energy = 1.;
    double worst_work = 0., worst_momentum = 0., worst_balance = 0.;
    for (unsigned int step = 0; step < 12; ++step)
      {
        const auto old = collect(run.scene);
        run.advance(1);
        const auto now = collect(run.scene);
        // a step that does not converge at once is halved
        const double dt = run.ledger["time_step"], t = run.ledger["time"] - dt;
        const auto   force =
                     in_closed_form(t + loads.force_sample * dt) * loads.force,
                   gravity = in_closed_form(t + loads.gravity_sample * dt) *
                             loads.gravity;
        for (const auto &[id, particle] : old)
          {
            const auto f    = particle.share * force + particle.mass * gravity;
            const auto path = now.at(id).position - particle.position;
            work += f * path;
            size += f.norm() * path.norm();
            momentum += dt * f;
            impulse += dt * f.norm();
          }
        worst_work =
          std::max(worst_work, std::abs(run.ledger["load_work"] - work) / size);
        energy = std::max(energy, run.ledger.total_energy());
        worst_balance =
          std::max(worst_balance,
                   std::abs(run.ledger["balance_error"]) / energy);
        for (unsigned int d = 0; d < dim && loads.fixed.empty(); ++d)
          worst_momentum =
            std::max(worst_momentum,
                     std::abs(
                       run.ledger[std::string("linear_momentum_") + "xyz"[d]] -
                       momentum[d]) /
                       impulse);
      }
    check_close(worst_work, 0., 1e-13, name + ": work along the paths");
    check_close(worst_momentum, 0., 1e-12, name + ": momentum given");
    check_close(worst_balance, 0., 1e-13, name + ": balance of energy");
    if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
      std::cout << name << ": work " << worst_work << ", momentum "
                << worst_momentum << ", energy " << worst_balance
                << " (relative)" << std::endl;
  }

  void
  check_works()
  {
    // With ghost stabilisation a step takes 3 or 4 Newton iterations; without,
    // one takes 96, and ranks that wait that often are slow on a busy machine.
    const std::string stable = ", ghost stabilisation\n";
    const std::string corner = "set Names = point load" + stable +
                               "subsection Point load\nset Force = 2; -3\n";
    Loads<2> loads;
    loads.force   = dealii::Tensor<1, 2>({2., -3.});
    loads.effects = corner + "set Points nearest to = 2.5, 2; 1, 1; 2.5, 2\n" +
                    as_table + "end\n";
    check_work("nearest points, table", loads);

    loads.effects = corner + "set Region = x - 2\nset Sampling = end\n" +
                    as_formula + "end\n";
    loads.force_sample = 1.;
    check_work("region, formula, end", loads);
    loads.fixed = "x-min";
    check_work("cantilever", loads);

    Loads<2> falling;
    falling.gravity = dealii::Tensor<1, 2>({0.5, -1.});
    falling.effects = "set Names = gravity" + stable +
                      "subsection Gravity\nset Acceleration = 0.5, -1\n" +
                      as_table + "end\n";
    check_work("gravity, table", falling);

    Loads<3> both;
    both.force        = dealii::Tensor<1, 3>({1., 2., -1.});
    both.gravity      = dealii::Tensor<1, 3>({0., 0.5, -0.5});
    both.force_sample = 1.;
    both.effects      = "set Names = gravity, point load" + stable +
                   "subsection Gravity\nset Acceleration = 0, 0.5, -0.5\n" +
                   as_formula +
                   "end\nsubsection Point load\nset Force = 1; 2; -1\n"
                   "set Points nearest to = 2.5, 2, 2; 2.5, 1, 1\n"
                   "set Sampling = end\n" +
                   as_table + "end\n";
    check_work("3D, gravity and points", both);
  }

  /** Who holds how much, by position. */
  template <int dim>
  std::vector<std::vector<double>>
  shares(const std::string &selection, const MPI_Comm communicator)
  {
    const SceneParameters<dim>       parameters(ParameterFile::from_text(
      block<dim>("set Names = point load\nsubsection Point load\nset Force = " +
                 std::string(dim == 2 ? "1; 1" : "1; 1; 1") + "\n" + selection +
                 "\nend\n"),
      "test"));
    const Scene<dim>                 scene(parameters, communicator);
    std::vector<std::vector<double>> result;
    for (const auto &[id, particle] : collect(scene))
      {
        (void)id;
        if (particle.share > 0.)
          {
            result.emplace_back();
            for (unsigned int d = 0; d < dim; ++d)
              result.back().push_back(particle.position[d]);
            result.back().push_back(particle.share);
          }
      }
    std::sort(result.begin(), result.end());
    return result;
  }

  void
  check_choice()
  {
    // four particles are equally near to a corner of cells; h/6 = 1/12
    const auto tied =
      shares<2>("set Points nearest to = 1.5, 1.5", MPI_COMM_WORLD);
    check(tied.size() == 4 && tied[0][2] == 0.25 && tied[1][2] == 0.25 &&
            tied[2][2] == 0.25 && tied[3][2] == 0.25 &&
            std::abs(tied[0][0] - 17. / 12.) < 1e-14 &&
            std::abs(tied[3][1] - 19. / 12.) < 1e-14,
          "equally near particles part a share");
    const auto twice = shares<2>("set Points nearest to = 2.1, 1.4; 0, 0; "
                                 "2.1, 1.4",
                                 MPI_COMM_WORLD);
    check(twice.size() == 2 && twice[0][2] == 1. / 3. && twice[1][2] == 2. / 3.,
          "a particle that is chosen twice holds two shares");
    // the last column: 2.5 - h/6
    const auto column = shares<2>("set Region = x - 2.4", MPI_COMM_WORLD);
    check(column.size() == 6 && column[0][2] == 1. / 6.,
          "a region shares equally");
    for (const char *selection :
         {"set Points nearest to = 1.5, 1.5; 1, 1; 2, 2; 4, 0",
          "set Region = 0.3 - (x - 1.5)^2 - (y - 1.5)^2"})
      check(shares<2>(selection, MPI_COMM_WORLD) ==
              shares<2>(selection, MPI_COMM_SELF),
            std::string("2D, ranks choose alike: ") + selection);
    const char *selection = "set Points nearest to = 2, 1.5, 1.5; 2, 2, 2";
    check(shares<3>(selection, MPI_COMM_WORLD) ==
            shares<3>(selection, MPI_COMM_SELF),
          std::string("3D, ranks choose alike: ") + selection);
  }

  /** The ledger of five steps, and the numbers that a particle has. */
  std::vector<std::vector<double>>
  five_steps(const std::string &effects, unsigned int &n_components)
  {
    const SceneParameters<2> parameters(
      ParameterFile::from_text(block<2>(effects), "test"));
    test::RunningScene<2> run(parameters);
    run.advance(5);
    n_components = run.scene.particles.n_properties_per_particle();
    return run.ledger.rows();
  }

  void
  check_absence()
  {
    const std::string section = "subsection Point load\nset Force = 1; 0\n"
                                "set Region = 1\n" +
                                as_table + "end\n",
                      gravity = "subsection Gravity\n"
                                "set Acceleration = 0.5, -1\n";
    unsigned int n_plain = 0, n = 0;
    const auto   plain = five_steps("", n_plain);
    check(five_steps(section, n) == plain && n == n_plain,
          "a load that is not named changes nothing and has no field");
    check(five_steps("set Names = point load\n" + section, n) != plain &&
            n == n_plain + 1,
          "a point load that is named has one number per particle");
    const auto falling =
      five_steps("set Names = gravity\n" + gravity + "end\n", n);
    check(n == n_plain, "gravity has no field of its own");
    for (const char *one : {"set Amplitude table = 0: 1\n",
                            "set Sampling = end\n",
                            "set Amplitude = cos(0*t)\n"})
      check(five_steps("set Names = gravity\n" + gravity + one + "end\n", n) ==
              falling,
            "gravity with an amplitude of one is the same: " +
              std::string(one));
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_amplitudes();
  check_works();
  check_choice();
  check_absence();
  return test::report();
}
