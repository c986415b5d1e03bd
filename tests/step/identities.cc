// What one step conserves, on random clouds of particles, whether or not
// Newton has converged: the discrete identities of energy, linear and angular
// momentum on grid and particles. Each is the sum of named terms and must
// vanish to round-off.

#include "../check.h"
#include "cloud.h"

using namespace emmy;
using Vector3 = dealii::Tensor<1, 3>;

namespace
{
  template <int dim>
  Vector3
  in_space(const std::vector<double> &values, const unsigned int node)
  {
    Vector3 result;
    for (unsigned int c = 0; c < dim; ++c)
      result[c] = values[dim * node + c];
    return result;
  }

  /** Sum of a_A x b_A over nodes, and of the sizes of its terms. */
  template <int dim>
  std::pair<Vector3, double>
  cross(const std::vector<double> &a, const std::vector<double> &b)
  {
    Vector3 sum;
    double  size = 0.;
    for (unsigned int node = 0; node < a.size() / dim; ++node)
      {
        const auto a_A = in_space<dim>(a, node), b_A = in_space<dim>(b, node);
        sum += cross_product_3d(a_A, b_A);
        size += a_A.norm() * b_A.norm();
      }
    return {sum, size};
  }

  template <int dim>
  void
  check_step(const test::CloudOptions &options,
             const unsigned int        n_iterations,
             const double              dt,
             const std::string        &what)
  {
    constexpr double tolerance = 1e-13;

    test::Cloud<dim> cloud(options);
    Phases           phases(MPI_COMM_WORLD);
    const auto       stencils =
      cloud.shape_functions->evaluate(cloud.particles, *cloud.grid);
    const auto           points = gather(stencils, cloud.layout);
    ParticlesToGrid<dim> map(*cloud.grid,
                             *cloud.boundary_conditions,
                             cloud.layout);
    GridStart<dim>      &start  = map(stencils, points);
    const auto          &active = *start.active;

    // the map
    const auto solver =
      make_linear_solver(*cloud.solver_parameters, active.n_dofs(), dim);
    solver->prepare(start.damped_mass);
    start.velocity = start.mean_velocity;
    solve_to_round_off(*solver,
                       start.mass,
                       active.constraints(),
                       start.momentum,
                       start.velocity);

    // some Newton iterations, or all it takes
    const StepData<dim> step{stencils, points, start, 0., dt};
    const auto          equation = cloud.balance->over(step);
    Vector              u        = start.mean_velocity;
    u *= dt;
    cloud.solver_parameters->maximum_iterations = n_iterations;
    const NewtonResult newton =
      Newton(*cloud.solver_parameters, *solver, phases).solve(*equation, u);
    if (n_iterations >= 20)
      test::check(newton.is_converged, what + ": Newton converges");
    else
      test::check(!newton.is_converged, what + ": Newton is stopped early");

    const Vector v_new    = velocity_new(u, start.velocity, dt);
    Vector       v_change = v_new;
    v_change -= start.velocity;
    auto trial = equation->trial();
    test::check(
      move_points(
        stencils, points, active, *cloud.grid, cloud.layout, u, v_change, trial)
        .empty(),
      what + ": no particle leaves the grid");

    // energies
    double     K_old = 0., K_new = 0., unresolved = 0., potential = 0.;
    const auto local_v_old = active.to_local(start.velocity);
    Vector3    L_old, L_new, J_old, J_new;
    double     J_size = 0.;
    for (const auto &group : stencils.groups)
      for (unsigned int q = 0; q < group.n_points; ++q)
        {
          const auto   p = group.first_point + q;
          const double m = points.component(cloud.layout["mass"])[p];
          Vector3      x0, x1, v0, v1, v_grid;
          for (unsigned int d = 0; d < dim; ++d)
            {
              x0[d] = points.position(d)[p];
              x1[d] = trial.position(d)[p];
              v0[d] = points.component(cloud.layout["velocity"] + d)[p];
              v1[d] = trial.component(cloud.layout["velocity"] + d)[p];
              for (unsigned int a = 0; a < group.n_nodes; ++a)
                v_grid[d] += stencils.value(group, a)[q] *
                             local_v_old[dim * active.nodes(group)[a] + d];
              potential -= m * cloud.acceleration[d] * (x1[d] - x0[d]);
            }
          K_old += 0.5 * m * v0.norm_square();
          K_new += 0.5 * m * v1.norm_square();
          unresolved += 0.5 * m * (v0 - v_grid).norm_square();
          L_old += m * v0;
          L_new += m * v1;
          J_old += m * cross_product_3d(x0, v0);
          J_new += m * cross_product_3d(x1, v1);
          J_size += m * x1.norm() * v1.norm();
        }
    double stored = 0.;
    for (const auto &entry : equation->energies(u))
      if (entry.name == "strain_energy")
        stored = entry.change;

    const double W  = equation->load() * u;
    const double ru = equation->residual() * u;
    const double K_grid_old =
      0.5 * start.mass.matrix_norm_square(start.velocity);
    const double K_grid_new = 0.5 * start.mass.matrix_norm_square(v_new);
    const double scale =
      K_old + K_new + std::abs(stored) + std::abs(W) + std::abs(ru);

    test::check_close(K_grid_new - K_grid_old + stored - W - ru,
                      0.,
                      tolerance * scale,
                      what + ": energy of the grid");
    test::check_close(K_new - K_old + stored - W - ru,
                      0.,
                      tolerance * scale,
                      what + ": energy of the particles");
    test::check_close(W + potential,
                      0.,
                      tolerance * scale,
                      what + ": the work of gravity is the potential lost");
    if (active.constraints().n_constraints() == 0)
      test::check_close(K_old - K_grid_old - unresolved,
                        0.,
                        tolerance * scale,
                        what + ": kinetic energy that the grid cannot see");

    // momenta: what acts is load plus residual; on fixed components the
    // residual is the reaction
    Vector acting = equation->load();
    acting += equation->unconstrained_residual();
    Vector misfit = start.momentum; // iota: zero on free components
    {
      Vector mapped = active.make_vector();
      start.mass.vmult(mapped, start.velocity);
      misfit -= mapped;
      Vector free = misfit;
      active.constraints().set_zero(free);
      test::check_close(free.l2_norm(),
                        0.,
                        tolerance * start.momentum.l2_norm(),
                        what + ": the map is solved");
    }
    const auto force = active.to_local(acting), local_u = active.to_local(u),
               iota = active.to_local(misfit);
    std::vector<double> x_old(local_u.size()), x_mid(local_u.size()),
      x_new(local_u.size());
    Vector3 total_force;
    double  force_size = 0.;
    for (unsigned int node = 0; node < active.n_local_nodes(); ++node)
      {
        total_force += in_space<dim>(force, node);
        force_size += in_space<dim>(force, node).norm();
        for (unsigned int c = 0; c < dim; ++c)
          {
            const unsigned int i = dim * node + c;
            x_old[i]             = active.position(node)[c];
            x_mid[i]             = x_old[i] + 0.5 * local_u[i];
            x_new[i]             = x_old[i] + local_u[i];
          }
      }
    test::check_close((L_new - L_old - dt * total_force).norm(),
                      0.,
                      tolerance * (L_old.norm() + dt * force_size),
                      what + ": linear momentum");

    Vector p_old = active.make_vector(), p_new = active.make_vector();
    start.mass.vmult(p_old, start.velocity);
    start.mass.vmult(p_new, v_new);
    const auto [J_grid_old, s0]  = cross<dim>(x_old, active.to_local(p_old));
    const auto [J_grid_new, s1]  = cross<dim>(x_new, active.to_local(p_new));
    const auto [moment, s2]      = cross<dim>(x_mid, force);
    const auto [wall_spin, s3]   = cross<dim>(local_u, iota);
    const auto [wall_moment, s4] = cross<dim>(x_old, iota);
    const double J_scale         = J_size + s0 + s1 + dt * s2 + s3 + s4;
    test::check_close((J_grid_new - J_grid_old - dt * moment).norm(),
                      0.,
                      tolerance * J_scale,
                      what + ": angular momentum of the grid");
    test::check_close((J_new - J_old - dt * moment - wall_spin).norm(),
                      0.,
                      tolerance * J_scale,
                      what + ": angular momentum of the particles");
    test::check_close((J_old - J_grid_old - wall_moment).norm(),
                      0.,
                      tolerance * J_scale,
                      what + ": angular momentum through the map");
  }

  template <int dim>
  void
  check_all()
  {
    const unsigned int n_cells = dim == 2 ? 12 : 36;
    // three, five and 25 points per cell
    for (const unsigned int n_points :
         {3u * n_cells, 5u * n_cells, 25u * n_cells})
      for (const bool gravity : {false, true})
        for (const unsigned int walls : {0u, 1u, 2u})
          for (const unsigned int n_iterations : {1u, 2u, 50u})
            {
              test::CloudOptions options;
              options.n_points = n_points;
              options.seed     = n_points + walls;
              options.gravity  = gravity;
              if (walls == 1)
                options.roller = {"x-min", "y-max"};
              if (walls == 2)
                options.fixed = {"y-min"};
              check_step<dim>(options,
                              n_iterations,
                              0.02,
                              std::to_string(dim) + "D, " +
                                std::to_string(n_points) + " points, " +
                                (gravity ? "gravity, " : "") +
                                (walls == 0   ? "free"
                                 : walls == 1 ? "rollers"
                                              : "fixed") +
                                ", " + std::to_string(n_iterations) +
                                " iterations");
            }
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_all<2>();
  check_all<3>();
  return test::report();
}
