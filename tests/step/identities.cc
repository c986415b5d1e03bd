// What one step conserves, on random clouds of particles, whether or not
// Newton has converged: the discrete identities of energy, linear and angular
// momentum on grid and particles (Pretti et al. 2023, tables 1 and 2), for
// every mapping, mass matrix and wall, linear functions and GIMP. Each is the
// sum of named terms and must vanish to round-off.

#include <emmy/step/velocity_map.h>

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

  /** Kinetic energy and momenta of particles, and the sizes of the sums. */
  struct Motion
  {
    double  energy = 0.;
    Vector3 linear, angular;
    double  angular_size = 0.;
  };

  template <int dim>
  Motion
  motion(const PointArrays<dim> &points, const FieldLayout &layout)
  {
    Motion result;
    for (std::size_t p = 0; p < points.n_points(); ++p)
      {
        const double m = points.component(layout["mass"])[p];
        Vector3      x, v;
        for (unsigned int d = 0; d < dim; ++d)
          {
            x[d] = points.position(d)[p];
            v[d] = points.component(layout["velocity"] + d)[p];
          }
        result.energy += 0.5 * m * v.norm_square();
        result.linear += m * v;
        result.angular += m * cross_product_3d(x, v);
        result.angular_size += m * x.norm() * v.norm();
      }
    return result;
  }

  template <int dim>
  void
  check_step(const test::CloudOptions &options,
             const PointMapping       &mapping,
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
    ParticlesToGrid<dim> particles_to_grid(*cloud.grid,
                                           *cloud.boundary_conditions,
                                           cloud.layout,
                                           mapping,
                                           cloud.balance->ghost_faces(),
                                           cloud.balance->aggregation());
    GridStart<dim>      &start  = particles_to_grid(stencils, points);
    const auto          &active = *start.active;
    const PointMapping   plain;
    ParticlesToGrid<dim> consistent(*cloud.grid,
                                    *cloud.boundary_conditions,
                                    cloud.layout,
                                    plain);
    const auto times = [](const Matrix &matrix, const Vector &vector) {
      Vector result = vector;
      matrix.vmult(result, vector);
      return result;
    };
    // M, and times X = M~ - M (M~ may have a larger pattern)
    const Matrix &M       = consistent(stencils, points).mass;
    const auto    X_times = [&](const Vector &vector) {
      Vector result = times(start.mass, vector);
      result -= times(M, vector);
      return result;
    };

    // the map
    const auto solver =
      make_linear_solver(*cloud.solver_parameters, active.n_dofs(), dim);
    const auto  &walls = *cloud.boundary_conditions;
    const Vector wall_velocity =
      active.on_walls(walls, walls.wall_velocities(0.));
    test::check(map_velocity(mapping, wall_velocity, *solver, start).is_solved,
                what + ": the map is solved");

    // some Newton iterations, or all it takes
    const StepData<dim> step{stencils, points, start, 0., dt};
    const auto          equation = cloud.balance->over(step);
    Vector              u        = start.mean_velocity;
    u *= dt;
    active.constraints().set_zero(u);
    u += active.on_walls(walls, walls.wall_displacements(0., dt));
    active.constraints().expand(u);
    cloud.solver_parameters->maximum_iterations = n_iterations;
    const NewtonResult newton =
      Newton(*cloud.solver_parameters, *solver, phases).solve(*equation, u);
    if (n_iterations >= 20)
      test::check(newton.is_converged, what + ": Newton converges");
    else
      test::check(!newton.is_converged, what + ": Newton is stopped early");

    const Vector v_new = velocity_new(u, start.velocity, dt);
    auto         trial = equation->trial();
    test::check(move_points(stencils,
                            points,
                            start,
                            *cloud.grid,
                            cloud.layout,
                            mapping.flip_fraction,
                            u,
                            v_new,
                            trial)
                  .empty(),
                what + ": no particle leaves the grid");
    const StepAccounts books =
      accounts(step, *equation, cloud.layout, mapping, u, v_new);

    // energies
    const Motion before   = motion(points, cloud.layout),
                 after    = motion(trial, cloud.layout);
    double     unresolved = 0., potential = 0.;
    const auto local_v_mapped = active.to_local(start.mapped_velocity);
    for (const auto &group : stencils.groups)
      for (unsigned int q = 0; q < group.n_points; ++q)
        {
          const auto   p = group.first_point + q;
          const double m = points.component(cloud.layout["mass"])[p];
          for (unsigned int d = 0; d < dim; ++d)
            {
              double v = points.component(cloud.layout["velocity"] + d)[p];
              for (unsigned int a = 0; a < group.n_nodes; ++a)
                v -= stencils.value(group, a)[q] *
                     local_v_mapped[dim * active.nodes(group)[a] + d];
              unresolved += 0.5 * m * v * v;
              potential -= m * cloud.acceleration[d] *
                           (trial.position(d)[p] - points.position(d)[p]);
            }
        }
    double stored = 0.; // and dissipated
    for (const auto &entry : equation->energies(u))
      {
        if (entry.kind != EnergyEntry::Kind::work)
          stored += entry.change;
        if (entry.name == "plastic_dissipation")
          test::check(entry.change > 0., what + ": it flows");
      }
    test::check(options.moving ? books.reaction_work != 0.
                               : std::abs(books.reaction_work) == 0.,
                what + ": only a wall that moves does work");

    const double W  = equation->load() * u;
    const double ru = equation->unconstrained_residual() * u;
    const double K_grid_old =
      0.5 * start.mass.matrix_norm_square(start.velocity);
    const double K_grid_new = 0.5 * start.mass.matrix_norm_square(v_new);
    const double K_mapped =
      0.5 * start.mass.matrix_norm_square(start.mapped_velocity);
    const double K_old = before.energy, K_new = after.energy;
    // v.M~ v is small beside its terms at nodes that few particles reach
    const auto size_of = [&](const Vector &v) {
      return absolute_product(v, times(start.mass, v));
    };
    const double scale = K_old + K_new + size_of(start.velocity) +
                         size_of(v_new) + size_of(start.mapped_velocity) +
                         std::abs(stored) + std::abs(W) + std::abs(ru);
    const auto vanishes = [&](const double value, const std::string &fact) {
      test::check_close(value, 0., tolerance * scale, what + ": " + fact);
    };

    vanishes(K_grid_new - K_grid_old + stored - W - ru, "energy of the grid");
    vanishes(K_new - K_old + stored - W - books.residual_work -
               books.reaction_work + books.lumping_loss + books.mapping_loss +
               books.ghost_mass_loss + books.wall_loss,
             "energy of the particles");
    vanishes(W + potential, "the work of gravity is the potential lost");
    Vector change = v_new;
    change -= start.mapped_velocity;
    vanishes(books.lumping_loss + books.ghost_mass_loss -
               0.5 * (change * X_times(change)),
             "lumping and ghost mass lose Dv.X Dv/2");
    test::check(books.lumping_loss >= 0., what + ": lumping takes energy");
    test::check(options.ghost_mass > 0. ? books.ghost_mass_loss > 0.
                                        : books.ghost_mass_loss == 0.,
                what + ": ghost mass takes energy");
    for (const auto &entry : equation->energies(u))
      if (entry.name == "ghost_stiffness_loss")
        test::check(options.ghost_stiffness > 0. ? entry.change > 0.
                                                 : entry.change == 0.,
                    what + ": ghost stiffness takes energy");
    // works of walls in closed form, on fixed unknowns: of the reactions R, and
    // of what the map leaves there (W1) or the impulse that stops the grid (W3)
    const auto on_fixed = [&](const Vector &a, const Vector &b) {
      Vector fixed = a;
      active.constraints().fold(fixed);
      Vector free = fixed;
      active.constraints().set_zero(free);
      fixed -= free;
      return fixed * b;
    };
    Vector stopped = start.mapped_velocity;
    stopped -= start.velocity;
    Vector misfit = start.momentum;
    misfit -= times(start.mass, start.velocity);
    double wall_work = on_fixed(equation->unconstrained_residual(), u);
    if (mapping.walls == PointMapping::Walls::constrained)
      wall_work += on_fixed(misfit, change);
    if (mapping.walls == PointMapping::Walls::inelastic)
      wall_work -= on_fixed(times(start.mass, stopped), start.velocity);
    vanishes(books.reaction_work - wall_work, "the work of walls");
    if (newton.is_converged)
      test::check(std::abs(books.residual_work) < 1e-8 * scale,
                  what + ": residuals do next to no work");
    vanishes(books.wall_loss - 0.5 * start.mass.matrix_norm_square(stopped),
             "the wall loss is w.M~ w/2");
    if (mapping.flip_fraction == 0.)
      vanishes(K_new - 0.5 * M.matrix_norm_square(v_new),
               "PIC: particles have the energy v.M v/2 of the grid");
    const bool is_free = (options.fixed.empty() && options.roller.empty()) ||
                         mapping.walls != PointMapping::Walls::constrained;
    if (is_free)
      vanishes(K_old - K_mapped - unresolved -
                 0.5 * (start.mapped_velocity * X_times(start.mapped_velocity)),
               "kinetic energy that the grid cannot see (table 1)");
    if (is_free && mapping.lumping == 0. && options.ghost_mass == 0.)
      vanishes(books.mapping_loss -
                 (1. - mapping.flip_fraction * mapping.flip_fraction) *
                   unresolved,
               "the mapping loses the energy that the grid cannot see");

    // momenta: what acts is load plus residual; on fixed components the
    // residual is the reaction. iota is what the map leaves
    Vector acting = equation->load();
    acting += equation->unconstrained_residual();
    Vector iota = start.momentum, iota_mapped = start.momentum;
    iota -= times(start.mass, start.velocity);
    iota_mapped -= times(start.mass, start.mapped_velocity);
    Vector left = is_free ? iota_mapped : iota;
    if (mapping.walls == PointMapping::Walls::constrained)
      active.constraints().condense(left);
    test::check_close(left.l2_norm(),
                      0.,
                      tolerance * start.momentum.l2_norm(),
                      what + ": the map leaves nothing");
    Vector braked = start.velocity; // what walls give to the map, over M~
    braked -= start.mapped_velocity;
    const Vector impulse = times(start.mass, braked);

    const double alpha = mapping.flip_fraction;
    const auto   force = active.to_local(acting), local_u = active.to_local(u);
    std::vector<double> x_old(local_u.size()), x_mid(local_u.size()),
      x_new(local_u.size());
    const auto total = [&](const Vector &vector) {
      const auto local = active.to_local(vector);
      Vector3    sum;
      for (unsigned int node = 0; node < active.n_local_nodes(); ++node)
        sum += in_space<dim>(local, node);
      return sum;
    };
    double force_size = 0.;
    for (unsigned int node = 0; node < active.n_local_nodes(); ++node)
      {
        force_size += in_space<dim>(force, node).norm();
        for (unsigned int c = 0; c < dim; ++c)
          {
            const unsigned int i = dim * node + c;
            x_old[i]             = active.position(node)[c];
            x_mid[i]             = x_old[i] + 0.5 * local_u[i];
            x_new[i]             = x_old[i] + local_u[i];
          }
      }
    test::check_close((after.linear - before.linear - dt * total(acting) -
                       alpha * total(impulse) + (1. - alpha) * total(iota))
                        .norm(),
                      0.,
                      tolerance * (before.linear.norm() + dt * force_size +
                                   start.momentum.l1_norm()),
                      what + ": linear momentum");

    test::check_close((before.linear -
                       total(times(start.mass, start.velocity)) - total(iota))
                        .norm(),
                      0.,
                      tolerance * start.momentum.l1_norm(),
                      what + ": linear momentum through the map (table 1)");

    double     J_scale = before.angular_size + after.angular_size;
    const auto moment  = [&](const std::vector<double> &x,
                            const Vector              &vector) {
      const auto [sum, size] = cross<dim>(x, active.to_local(vector));
      J_scale += size;
      return sum;
    };
    const Vector3 turned     = dt * moment(x_mid, acting);
    const Vector3 J_grid_old = moment(x_old, times(start.mass, start.velocity)),
                  J_grid_new = moment(x_new, times(start.mass, v_new));
    const Vector3 flip_defect = moment(x_old, impulse) -
                                moment(x_new, X_times(change)) +
                                moment(local_u, iota_mapped);
    const Vector3 pic_defect =
      Vector3() - moment(x_new, X_times(v_new)) - moment(x_old, iota);
    const Vector3 seen = moment(x_old, iota);
    test::check_close((J_grid_new - J_grid_old - turned).norm(),
                      0.,
                      tolerance * J_scale,
                      what + ": angular momentum of the grid");
    test::check_close((after.angular - before.angular - turned -
                       alpha * flip_defect - (1. - alpha) * pic_defect)
                        .norm(),
                      0.,
                      tolerance * J_scale,
                      what + ": angular momentum of the particles");
    test::check_close((before.angular - J_grid_old - seen).norm(),
                      0.,
                      tolerance * J_scale,
                      what + ": angular momentum through the map");
    if (options.aggregation == 0. || !is_free)
      return;

    // what the map leaves and what holds followers has no sum and no moment
    const Constraints &constraints = active.constraints();
    test::check(start.aggregates.n_followers > 0, what + ": nodes follow");
    test::check(constraints.has_followers(), what + ": by constraints");
    test::check_close(total(iota).norm() + seen.norm(),
                      0.,
                      tolerance * (start.momentum.l1_norm() + J_scale),
                      what + ": the map keeps both momenta");
    Vector rest = equation->unconstrained_residual(), held = rest;
    constraints.condense(rest); // Newton's, at the roots
    held -= rest;
    test::check_close(total(held).norm(),
                      0.,
                      tolerance * force_size,
                      what + ": what holds followers has no sum");
    test::check_close(moment(x_mid, held).norm(),
                      0.,
                      tolerance * J_scale / dt,
                      what + ": what holds followers has no moment");
    Vector again = u;
    constraints.expand(again);
    again -= u;
    test::check_close(again.linfty_norm(),
                      0.,
                      tolerance * u.linfty_norm(),
                      what + ": followers follow");
  }

  const std::vector<std::pair<PointMapping::Walls, std::string>> wall_mappings{
    {PointMapping::Walls::constrained, "W1"},
    {PointMapping::Walls::unconstrained, "W2"},
    {PointMapping::Walls::inelastic, "W3"}};

  /** Numbers of points, gravity, kinds of walls, Newton stopped or not. */
  template <int dim>
  void
  check_scenes()
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
                              PointMapping(),
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

  /** Ghost mass, ghost stiffness, and both, with every mapping and wall. */
  template <int dim>
  void
  check_ghosts()
  {
    for (const bool gimp : {false, true})
      for (const unsigned int ghosts : {1u, 2u, 3u})
        for (const double alpha : {1., 0., 0.7})
          for (const double epsilon : {0., 0.3})
            for (const auto &[walls, name] : wall_mappings)
              for (const unsigned int n_iterations : {1u, 50u})
                {
                  test::CloudOptions options;
                  // two points per cell, and enough where no ghost mass helps
                  options.n_points =
                    (ghosts & 1 ? 2 : 6) * (dim == 2 ? 12 : 36);
                  options.seed            = 17;
                  options.gimp            = gimp;
                  options.gravity         = true;
                  options.fixed           = {"y-min"};
                  options.roller          = {"x-max"};
                  options.moving          = true;
                  options.ghost_mass      = ghosts & 1 ? 0.25 : 0.;
                  options.ghost_stiffness = ghosts & 2 ? 0.01 : 0.;
                  PointMapping mapping;
                  mapping.flip_fraction = alpha;
                  mapping.lumping       = epsilon;
                  mapping.walls         = walls;
                  check_step<dim>(options,
                                  mapping,
                                  n_iterations,
                                  0.02,
                                  std::to_string(dim) + "D, " +
                                    (gimp ? "GIMP" : "MPM") + ", ghosts " +
                                    std::to_string(ghosts) +
                                    ", FLIP fraction " + shortest(alpha) +
                                    ", epsilon " + shortest(epsilon) + ", " +
                                    name + ", " + std::to_string(n_iterations) +
                                    " iterations");
                }
  }

  /** Few points, so that nodes starve, with all that aggregation allows. */
  template <int dim>
  void
  check_aggregation()
  {
    for (const unsigned int points_per_cell : {1u, 2u, 3u, 4u})
      for (const bool gimp : {false, true})
        for (const bool plastic : {false, true})
          for (const bool with_walls : {false, true})
            for (const double alpha : {1., 0., 0.7})
              for (const auto &[epsilon, ghosts] :
                   {std::make_pair(0., 0.), {0.3, 0.}, {0., 0.1}})
                for (const unsigned int n_iterations : {1u, 100u})
                  {
                    // fewer points than nodes: M~ is singular whoever follows,
                    // and where walls push, velocities have no digits
                    if (points_per_cell == 1 && with_walls)
                      continue;
                    test::CloudOptions options;
                    options.n_points   = points_per_cell * (dim == 2 ? 12 : 36);
                    options.seed       = 3 + points_per_cell;
                    options.gimp       = gimp;
                    options.plastic    = plastic;
                    options.gravity    = true;
                    options.ghost_mass = ghosts;
                    options.aggregation = 0.45;
                    if (with_walls)
                      {
                        options.fixed  = {"y-min"};
                        options.roller = {"x-max"};
                        options.moving = true;
                      }
                    PointMapping mapping;
                    mapping.flip_fraction = alpha;
                    mapping.lumping       = epsilon;
                    check_step<dim>(
                      options,
                      mapping,
                      n_iterations,
                      0.01,
                      std::to_string(dim) + "D, aggregation, " +
                        std::to_string(points_per_cell) + " points per cell, " +
                        (gimp ? "GIMP" : "MPM") +
                        (plastic ? ", plastic" : ", elastic") +
                        (with_walls ? ", walls" : "") + ", FLIP fraction " +
                        shortest(alpha) + ", epsilon " + shortest(epsilon) +
                        ", ghosts " + shortest(ghosts) + ", " +
                        std::to_string(n_iterations) + " iterations");
                  }
  }

  /** Every mapping with every mass, shape function and wall. */
  template <int dim>
  void
  check_methods()
  {
    enum Walls
    {
      none,
      resting,
      moving
    };
    for (const bool gimp : {false, true})
      for (const bool plastic : {false, true})
        for (const double alpha : {1., 0., 0.7})
          for (const double epsilon : {0., 0.3, 1.})
            for (const Walls kind : {none, resting, moving})
              for (const auto &[walls, name] : wall_mappings)
                for (const unsigned int n_iterations : {1u, 50u})
                  {
                    if (kind == none &&
                        walls != PointMapping::Walls::constrained)
                      continue;
                    test::CloudOptions options;
                    options.n_points = dim == 2 ? 6 * 12 : 5 * 36;
                    options.seed     = 17;
                    options.gimp     = gimp;
                    options.plastic  = plastic;
                    options.gravity  = true;
                    if (kind != none)
                      {
                        options.fixed  = {"y-min"};
                        options.roller = {"x-max"};
                        options.moving = kind == moving;
                      }
                    PointMapping mapping;
                    mapping.flip_fraction = alpha;
                    mapping.lumping       = epsilon;
                    mapping.walls         = walls;
                    check_step<dim>(options,
                                    mapping,
                                    n_iterations,
                                    0.02,
                                    std::to_string(dim) + "D, " +
                                      (gimp ? "GIMP" : "MPM") +
                                      (plastic ? ", plastic" : ", elastic") +
                                      ", FLIP fraction " + shortest(alpha) +
                                      ", epsilon " + shortest(epsilon) + ", " +
                                      (kind == none ? "free" : name) +
                                      (kind == moving ? ", moving" : "") +
                                      ", " + std::to_string(n_iterations) +
                                      " iterations");
                  }
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_scenes<2>();
  check_scenes<3>();
  check_methods<2>();
  check_methods<3>();
  check_ghosts<2>();
  check_ghosts<3>();
  check_aggregation<2>();
  check_aggregation<3>();
  return test::report();
}
