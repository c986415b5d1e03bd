// Facts about whole scenes, on one or several ranks: ranks agree, a turned
// scene gives the turned result, a body that crosses many cells and ranks in
// a step loses no particle, two balls in space conserve what two discs do,
// and Newton converges quadratically.

#include <emmy/solve/newton.h>
#include <emmy/step/step_equation.h>
#include <emmy/step/velocity_map.h>

#include "../check.h"
#include "../scene.h"

using namespace emmy;
using test::check;
using test::check_close;

namespace
{
  const auto n_ranks = [] {
    return dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD);
  };

  /** Positions of all particles by id. */
  template <int dim>
  std::map<unsigned int, dealii::Point<dim>>
  positions(const Scene<dim> &scene)
  {
    std::map<unsigned int, dealii::Point<dim>> own;
    for (const auto &particle : scene.particles)
      own[particle.get_id()] = particle.get_location();
    std::map<unsigned int, dealii::Point<dim>> all;
    for (const auto &part :
         dealii::Utilities::MPI::all_gather(MPI_COMM_WORLD, own))
      all.insert(part.begin(), part.end());
    return all;
  }

  /**
   * What a column of a free collision is measured by: the energy at the start,
   * the momentum of all mass at the speed that this energy stands for, or its
   * own largest value.
   */
  template <int dim>
  double
  scale_of(const std::string &column, const test::RunningScene<dim> &run)
  {
    const double kinetic = run.column("kinetic_energy")[0],
                 momentum =
                   std::sqrt(2. * kinetic * test::total_mass(run.scene)),
                 lever = run.scene.grid.upper_corner().norm();
    if (column.find("angular_momentum") == 0)
      return momentum * lever;
    if (column.find("linear_momentum") == 0)
      return momentum;
    if (column.find("energy") != std::string::npos)
      return kinetic;
    return test::largest(run.column(column));
  }

  /** Energy and momenta of a free collision. */
  template <int dim>
  void
  check_conservation(const test::RunningScene<dim> &run)
  {
    const std::string name    = std::to_string(dim) + "D collision: ";
    const auto        kinetic = run.column("kinetic_energy"),
               strain         = run.column("strain_energy"),
               error          = run.column("balance_error");
    double largest_strain     = 0.;
    for (unsigned int row = 0; row < kinetic.size(); ++row)
      {
        check_close(error[row],
                    0.,
                    1e-12 * kinetic[0],
                    name + "balance error, J");
        check_close(kinetic[row] + strain[row],
                    kinetic[0],
                    1e-11 * kinetic[0],
                    name + "total energy, J");
        largest_strain = std::max(largest_strain, strain[row]);
      }
    check(largest_strain > 0.2 * kinetic[0],
          name + "the bodies did collide (strain energy " +
            std::to_string(largest_strain / kinetic[0]) + " of the total)");
    for (const std::string &column : run.ledger.columns())
      if (column.find("_momentum_") != std::string::npos)
        {
          const auto values = run.column(column);
          for (const double value : values)
            check_close(value,
                        values[0],
                        1e-12 * scale_of(column, run),
                        name + column);
        }
  }

  template <int dim>
  void
  check_collision(const ParameterFile &file, const unsigned int n_steps)
  {
    const SceneParameters<dim> parameters(file);
    test::RunningScene<dim>    run(parameters);
    run.advance(n_steps);
    check_conservation(run);
    if (n_ranks() == 1)
      return;

    test::RunningScene<dim> one_rank(parameters, MPI_COMM_SELF);
    one_rank.advance(n_steps);
    for (const std::string &column : run.ledger.columns())
      if (column != "residual_work" && column != "balance_error" &&
          column != "linear_iterations" && column != "newton_iterations")
        {
          const auto   a = one_rank.column(column), b = run.column(column);
          const double scale = scale_of(column, run);
          for (unsigned int row = 0; row < a.size(); ++row)
            check_close(b[row],
                        a[row],
                        1e-10 * scale,
                        std::to_string(dim) + "D, ranks agree: " + column);
        }
  }

  /** The scene turned by 90 degrees about the origin gives turned results. */
  void
  check_turned()
  {
    const auto text = [](const bool turned) {
      ParameterFile file =
        ParameterFile::from_text(test::collision_text(3), "test");
      if (turned)
        for (const char *assignment : {"Grid/Lower corner=-4, 0",
                                       "Grid/Upper corner=0, 6",
                                       "Grid/Cells=8, 12",
                                       "Bodies/left/ball/Center=-1.8, 1.9",
                                       "Bodies/right/ball/Center=-2.3, 4",
                                       "Bodies/left/Initial velocity=-0.1; 0.9",
                                       "Bodies/right/Initial velocity=0; -0.7"})
          file.set(assignment);
      return file;
    };
    constexpr unsigned int n_steps = 40;
    std::vector<double>    energy, strain;
    dealii::Point<2>       center;
    double                 spin = 0.;
    for (const bool turned : {false, true})
      {
        const SceneParameters<2> parameters(text(turned));
        test::RunningScene<2>    run(parameters);
        run.advance(n_steps);
        dealii::Point<2> sum;
        for (const auto &[id, x] : positions(run.scene))
          {
            (void)id;
            sum += x;
          }
        if (!turned)
          {
            energy = run.column("kinetic_energy");
            strain = run.column("strain_energy");
            center = sum;
            spin   = run.ledger["angular_momentum_z"];
            check(strain.back() > 0.01, "turned: there is strain to compare");
            continue;
          }
        for (unsigned int row = 0; row <= n_steps; ++row)
          {
            check_close(run.column("kinetic_energy")[row],
                        energy[row],
                        1e-11 * energy[0],
                        "turned: kinetic energy, J");
            check_close(run.column("strain_energy")[row],
                        strain[row],
                        1e-11 * energy[0],
                        "turned: strain energy, J");
          }
        check_close(run.ledger["angular_momentum_z"],
                    spin,
                    1e-11,
                    "turned: angular momentum");
        check_close(sum.distance(dealii::Point<2>(-center[1], center[0])),
                    0.,
                    1e-11 * center.norm(),
                    "turned: positions, m");
      }
  }

  /** Free flight over several cells, and ranks, in each step. */
  template <int dim>
  void
  check_free_flight()
  {
    const std::string          more = dim == 2 ? "" : ", 3";
    const SceneParameters<dim> parameters(ParameterFile::from_text(
      "set Dimension = " + std::to_string(dim) +
        "\nsubsection Method\nset Shape functions = linear\n"
        "set Starved nodes = free\nend\n"
        "subsection Grid\n"
        "set Lower corner = 0, 0" +
        (dim == 2 ? "" : ", 0") + "\nset Upper corner = 8, 4" + more +
        "\nset Cells = 16, 8" + (dim == 2 ? "" : ", 6") +
        "\nend\nsubsection Materials\nset Names = m\nsubsection m\n"
        "set Model = Hencky\nset Density = 5\nset Young's modulus = 100\n"
        "set Poisson's ratio = 0.3\nend\nend\n"
        "subsection Bodies\nset Names = flyer\nsubsection flyer\n"
        "set Shape = ball\nset Material = m\nset Points per direction = 2\n"
        "set Initial velocity = 4.9; 0.3" +
        (dim == 2 ? "" : "; 0.1") + "\nsubsection ball\nset Center = 1.9, 1.8" +
        (dim == 2 ? "" : ", 1.5") +
        "\nset Radius = 0.8\nend\nend\nend\n"
        "subsection Time\nset End time = 1\nset Step rule = fixed\n"
        "set Step size = 0.4\nend\n",
      "test"));
    test::RunningScene<dim>    run(parameters);
    const auto                 before  = positions(run.scene);
    constexpr unsigned int     n_steps = 2;
    run.advance(n_steps);
    const auto after = positions(run.scene);

    const std::string name = std::to_string(dim) + "D free flight: ";
    check(after.size() == before.size(), name + "no particle is lost");
    dealii::Tensor<1, dim> path;
    path[0] = 4.9 * 0.4 * n_steps;
    path[1] = 0.3 * 0.4 * n_steps;
    if (dim == 3)
      path[dim - 1] = 0.1 * 0.4 * n_steps;
    for (const auto &[id, x] : before)
      {
        const auto found = after.find(id);
        check(found != after.end(), name + "ids stay");
        if (found != after.end())
          check_close(found->second.distance(x + path),
                      0.,
                      1e-11,
                      name + "straight path, m");
      }
    check_close(run.ledger["strain_energy"],
                0.,
                1e-20,
                name + "no strain energy, J");
    check(run.ledger["newton_iterations"] == 0, name + "nothing to solve");
  }

  /** |r| after each iteration: r_k+1 / r_k^2 stays bounded. */
  void
  check_quadratic_convergence()
  {
    // a block of full cells, so that no node is reached by few particles
    const SceneParameters<2> parameters(ParameterFile::from_text(
      "set Dimension = 2\n"
      "subsection Method\nset Shape functions = linear\n"
      "set Starved nodes = free\nend\n"
      "subsection Grid\nset Upper corner = 6, 6\nset Cells = 6, 6\nend\n"
      "subsection Materials\nset Names = m\nsubsection m\n"
      "set Model = Hencky\nset Density = 5\nset Young's modulus = 100\n"
      "set Poisson's ratio = 0.3\nend\nend\n"
      "subsection Bodies\nset Names = block\nsubsection block\n"
      "set Shape = box\nset Material = m\nset Points per direction = 3\n"
      "set Initial velocity = 2 * sin(x) * y; cos(x * y)\n"
      "subsection box\nset Lower corner = 2, 2\nset Upper corner = 4, 4\n"
      "end\nend\nend\n"
      "subsection Time\nset End time = 1\nset Step rule = fixed\n"
      "set Step size = 0.1\nend\n",
      "test"));
    test::RunningScene<2>    run(parameters);

    Scene<2>  &scene = run.scene;
    const auto stencils =
      scene.shape_functions->evaluate(scene.particles, scene.grid);
    const auto         points = gather(stencils, scene.layout);
    ParticlesToGrid<2> map(scene.grid,
                           scene.boundary_conditions,
                           scene.layout,
                           scene.mapping);
    GridStart<2>      &start = map(stencils, points);
    const auto         solver =
      make_linear_solver(parameters.solver, start.active->n_dofs(), 2);
    const StepData<2> step{stencils, points, start, 0., 0.1};
    map_velocity(scene.balance, step, *solver, start);
    const auto equation = scene.balance.over(step);
    Vector     u        = start.mean_velocity;
    u *= step.time_step;
    const NewtonResult newton =
      Newton(parameters.solver, *solver, scene.phases).solve(*equation, u);
    check(newton.is_converged, "quadratic convergence: converged");

    const auto  &r           = newton.residual_history;
    const double f           = equation->system().scale;
    unsigned int n_quadratic = 0;
    for (unsigned int k = 1; k + 1 < r.size(); ++k)
      {
        if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
          std::cout << "|r| " << r[k] / f << " -> " << r[k + 1] / f << '\n';
        // until round-off takes over
        if (r[k] / f < 1e-2 && r[k + 1] / f > 1e-13)
          {
            ++n_quadratic;
            check(r[k + 1] / f < 10. * (r[k] / f) * (r[k] / f),
                  "quadratic convergence");
          }
      }
    check(n_quadratic >= 1, "quadratic convergence was seen");
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_free_flight<2>();
  check_free_flight<3>();
  check_collision<2>(ParameterFile::from_text(test::collision_text(4), "test"),
                     60);
  check_collision<3>(ParameterFile(argv[1]), 36);
  check_turned();
  check_quadratic_convergence();
  return test::report();
}
