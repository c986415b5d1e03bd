// Facts about the treatment of locking: the equation of a step has the
// derivative that it says, whether places stay or follow, in steps in time and
// in static ones; runs over many cells keep all balances and momenta, on any
// number of ranks; a body cut in two is as one; what cannot be is refused; who
// does not ask for it has none of its fields.

#include <emmy/effects/mean_dilatation.h>
#include <emmy/step/middle_equation.h>

#include <random>

#include "../check.h"
#include "../scene.h"

using namespace emmy;
using test::at_most;
using test::check;

namespace
{
  std::mt19937                           random_numbers(7);
  std::uniform_real_distribution<double> uniform(-1., 1.);

  /** A block, perhaps cut into bodies that touch within cells. */
  template <int dim>
  std::string
  bodies(const unsigned int n_bodies)
  {
    const auto in = [](const std::string &plane, const std::string &space) {
      return dim == 2 ? plane : space;
    };
    const auto part = [&](const std::string &name,
                          const std::string &lower,
                          const std::string &upper) {
      return "subsection " + name +
             "\nset Shape = box\nset Material = m\nset Points per direction = "
             "2\nset Initial velocity = 1 - (y - 1.9) + 0.5*(x - 2.1); "
             "0.5 + (x - 2.1) - 0.4*(y - 1.9)" +
             in("", "; 0.3*(x - 2.1)") +
             "\nsubsection box\nset Lower corner = " + lower + ", 1" +
             in("", ", 1") + "\nset Upper corner = " + upper + ", 2.5" +
             in("", ", 2") + "\nend\nend\n";
    };
    // 1.75 is in the middle of a cell
    return "subsection Bodies\n" +
           (n_bodies == 1 ? "set Names = block\n" + part("block", "1", "3")
                          : "set Names = a, b\n" + part("a", "1", "1.75") +
                              part("b", "1.75", "3")) +
           "end\n";
  }

  /** A block that flies, turns, breathes and flows. */
  template <int dim>
  std::string
  block(const std::string &method,
        const std::string &more,
        const unsigned int n_bodies = 1)
  {
    const auto in = [](const std::string &plane, const std::string &space) {
      return dim == 2 ? plane : space;
    };
    return "set Dimension = " + std::to_string(dim) +
           "\nsubsection Grid\nset Lower corner = " + in("0, 0", "0, 0, 0") +
           "\nset Upper corner = " + in("5, 5", "4, 4, 3") +
           "\nset Cells = " + in("10, 10", "8, 8, 6") +
           "\nend\nsubsection Method\nset Locking treatment = cell\n" + method +
           "end\nsubsection Materials\nset Names = m\nsubsection m\n"
           "set Model = von Mises\nset Density = 5\n"
           "set Young's modulus = 100\nset Poisson's ratio = 0.45\n"
           "set Yield stress = " +
           in("12", "4") + "\nset Hardening modulus = 10\nend\nend\n" +
           bodies<dim>(n_bodies) + more +
           "subsection Solver\nset Newton tolerance = 1e-15\nend\n";
  }

  const std::string in_time = "subsection Time\nset End time = 9\n"
                              "set Step rule = fixed\nset Step size = 0.04\n"
                              "end\n";

  template <int dim>
  SceneParameters<dim>
  parsed(const std::string &text)
  {
    return SceneParameters<dim>(ParameterFile::from_text(text, "test"));
  }

  /** J du of an equation, and how r changes along du. */
  template <int dim>
  void
  check_tangent(NonlinearEquation    &equation,
                const GridStart<dim> &start,
                Vector               &solution,
                const std::string    &what)
  {
    equation.evaluate(solution, true);
    Vector direction = solution;
    for (auto &entry : direction)
      entry = uniform(random_numbers);
    start.active->constraints().set_zero(direction);
    equation.expand(direction);
    Vector expected = solution;
    equation.system().jacobian.vmult(expected, direction);
    start.active->constraints().set_zero(expected); // followers have none
    Vector step = direction;
    step *= 1e-6;
    Vector change = solution;
    for (const int sign : {1, -1})
      {
        equation.take(solution, step);
        check(equation.evaluate(solution, false), what + ": has meaning");
        if (sign == 1)
          change = equation.system().residual;
        else
          change -= equation.system().residual;
        equation.take_back(solution, step);
        equation.evaluate(solution, true);
        step *= -1.;
      }
    change *= 1. / 2e-6;
    change -= expected;
    at_most(what + ": derivative of the whole step",
            change.l2_norm() / expected.l2_norm(),
            1e-8);
  }

  template <int dim>
  void
  check_tangent_of_start(const std::string &functions)
  {
    const auto parameters = parsed<dim>(
      block<dim>("set Geometry = start\nset Starved nodes = follow\n"
                 "set Shape functions = " +
                   functions + "\n",
                 in_time));
    Scene<dim> scene(parameters, MPI_COMM_WORLD);
    scene.initial_report();
    for (unsigned int i = 0; i < 3; ++i)
      scene.advance();
    const auto stencils =
      scene.shape_functions->evaluate(scene.particles, scene.grid);
    const auto           points = gather(stencils, scene.layout);
    ParticlesToGrid<dim> to_grid(scene.grid,
                                 scene.boundary_conditions,
                                 scene.layout,
                                 scene.mapping);
    scene.balance.classify(stencils, points, scene.grid, nullptr);
    auto &start         = to_grid(stencils,
                          points,
                          scene.balance.couplings(stencils,
                                                  scene.grid,
                                                  scene.boundary_conditions,
                                                  nullptr));
    start.velocity      = start.mean_velocity;
    const auto equation = scene.balance.over(
      {stencils, points, start, scene.state.time, 0.04, nullptr, nullptr});
    Vector u = start.mean_velocity;
    u *= 0.04;
    start.active->constraints().expand(u);
    check_tangent<dim>(*equation,
                       start,
                       u,
                       std::to_string(dim) + "D, start, " + functions);
  }

  template <int dim>
  void
  check_tangent_of_middle(const std::string &functions,
                          const std::string &update)
  {
    const auto parameters = parsed<dim>(
      block<dim>("set Geometry = middle\nset Starved nodes = follow\n"
                 "set Domain update = " +
                   update + "\nset Shape functions = " + functions + "\n",
                 in_time));
    Scene<dim> scene(parameters, MPI_COMM_WORLD);
    scene.initial_report();
    for (unsigned int i = 0; i < 3; ++i)
      scene.advance();
    Places<dim> places =
      scene.shape_functions->places(scene.particles, scene.grid);
    PointArrays<dim> states = gather(places, scene.layout);
    places                  = scene.middle->first(
      std::move(places), states, 0.04, scene.domain_update.get(), scene.grid);
    ParticlesToGrid<dim> to_grid(scene.grid,
                                 scene.boundary_conditions,
                                 scene.layout,
                                 scene.mapping);
    MiddleEquation<dim>  equation({{*scene.shape_functions,
                                    scene.domain_update.get(),
                                    scene.grid,
                                    scene.layout,
                                    scene.mapping},
                                   scene.balance,
                                   scene.boundary_conditions,
                                   to_grid,
                                   std::move(states),
                                   scene.state.time,
                                   0.04,
                                   1e-8,
                                   &scene.phases},
                                 std::move(places));
    Vector               u = equation.first_displacement();
    // places settle where u is; they may move 12 times in all
    for (unsigned int i = 0; i < 5; ++i)
      {
        equation.evaluate(u, true);
        Vector none = u;
        none        = 0.;
        equation.take(u, none);
      }
    check_tangent<dim>(equation,
                       equation.grid_start(),
                       u,
                       std::to_string(dim) + "D, middle, " + functions + ", " +
                         update);
  }

  /** Balances of a run over cells, and what it comes to. */
  template <int dim>
  std::vector<double>
  run_block(const std::string &method,
            const std::string &what,
            const unsigned int n_bodies     = 1,
            const MPI_Comm     communicator = MPI_COMM_WORLD)
  {
    const auto parameters = parsed<dim>(block<dim>(method, in_time, n_bodies));
    test::RunningScene<dim> run(parameters, communicator);
    run.advance(dim == 2 ? 30 : 10);
    const double scale        = test::largest(run.column("kinetic_energy"));
    const bool   is_at_middle = what.find("middle") != std::string::npos;
    at_most(what + ": balance of energy",
            test::largest(run.column("balance_error")) / scale,
            1e-12);
    check(run.ledger["plastic_dissipation"] > 1e-3 * scale, what + ": flows");
    for (const char *name : {"linear_momentum_x", "angular_momentum_z"})
      {
        const auto column = run.column(name);
        at_most(what + ": change of " + name,
                std::abs(column.back() - column.front()) /
                  test::largest(column),
                is_at_middle ? 1e-8 : 1e-11);
      }
    return {run.ledger["kinetic_energy"],
            run.ledger["strain_energy"],
            run.ledger["plastic_dissipation"],
            run.ledger["angular_momentum_z"]};
  }

  /** On all ranks, on each alone, and with a body that is cut. */
  template <int dim>
  void
  check_alike(const std::string &method, const std::string &what)
  {
    const auto all = run_block<dim>(method, what),
               alone =
                 run_block<dim>(method, what + ", alone", 1, MPI_COMM_SELF),
               cut = run_block<dim>(method, what + ", cut", 2);
    for (unsigned int i = 0; i < all.size(); ++i)
      {
        at_most(what + ": difference of ranks",
                std::abs(all[i] - alone[i]) / std::abs(all[i]),
                1e-9);
        at_most(what + ": difference of a cut body",
                std::abs(all[i] - cut[i]) / std::abs(all[i]),
                1e-9);
      }
  }

  void
  check_refusals()
  {
    const auto refused = [](const std::string              &method,
                            const std::string              &time,
                            const std::vector<std::string> &words) {
      test::check_throws_with(
        [&] {
          const auto parameters = parsed<2>(block<2>(method, time));
          Scene<2>(parameters, MPI_COMM_WORLD);
        },
        words);
    };
    refused("set Stress rule = trapezoidal\n",
            in_time,
            {"Method", "Locking treatment", "conserving"});
    refused("set Domain update = corners\n",
            in_time,
            {"Method", "Domain update", "corners"});
    refused("",
            "subsection Time\nset End time = 9\nset Step rule = fixed\n"
            "set Step size = 0.04\nset Integrator = explicit\nend\n",
            {"explicit", "Locking treatment"});
  }

  void
  check_absence()
  {
    std::string text = block<2>("", in_time);
    text.replace(text.find("= cell"), 6, "= none");
    const auto     parameters = parsed<2>(text);
    const Scene<2> scene(parameters, MPI_COMM_WORLD);
    check(!scene.layout.has(own_volume_field) &&
            !scene.layout.has("cell_mean_stress"),
          "no fields of a treatment that is not asked for");
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_tangent_of_start<2>("linear");
  check_tangent_of_start<2>("GIMP");
  check_tangent_of_start<3>("GIMP");
  check_tangent_of_middle<2>("linear", "stretch");
  for (const char *update : {"none", "detF", "diagF", "stretch"})
    check_tangent_of_middle<2>("GIMP", update);
  check_tangent_of_middle<3>("GIMP", "stretch");
  check_refusals();
  check_absence();
  const std::string start  = "set Geometry = start\n",
                    middle = "set Geometry = middle\n";
  check_alike<2>(start, "2D, start");
  check_alike<2>(middle, "2D, middle");
  run_block<3>(middle, "3D, middle");
  return test::report();
}
