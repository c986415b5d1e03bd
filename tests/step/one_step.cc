#include "grid_sums.h"

#include <emmy/step/velocity_map.h>
#include <emmy/transfer/grid_to_particles.h>

#include <cmath>
#include <map>

#include "../check.h"

namespace emmy
{
  namespace test
  {
    namespace
    {
      constexpr double tolerance = 1e-14;
    } // namespace

    template <int dim>
    OneStep<dim>::OneStep(const CloudOptions &options,
                          const PointMapping &mapping,
                          const unsigned int  n_iterations,
                          const double        dt,
                          const std::string  &what)
      : options(options)
      , mapping(mapping)
      , dt(dt)
      , what(what)
      , cloud(options)
      , stencils(cloud.shape_functions->evaluate(cloud.particles, *cloud.grid))
      , points(gather(stencils, cloud.layout))
      , particles_to_grid(*cloud.grid,
                          *cloud.boundary_conditions,
                          cloud.layout,
                          this->mapping)
      , consistent(*cloud.grid, *cloud.boundary_conditions, cloud.layout, plain)
      , start(particles_to_grid(stencils, points, couplings()))
      , active(*start.active)
      , M(consistent(stencils, points).mass)
    {
      solve(n_iterations);
      before = motion(points, cloud.layout);
      after  = motion(trial, cloud.layout);
      for (const auto &entry : equation->energies(u))
        if (entry.kind != EnergyEntry::Kind::work)
          stored += entry.change;

      // v.M~ v is small beside its terms at nodes that few particles reach
      const auto size_of = [&](const Vector &v) {
        return absolute_product(v, times(start.mass, v));
      };
      scale = before.energy + after.energy + size_of(start.velocity) +
              size_of(v_new) + size_of(v_mapped) + std::abs(stored) +
              std::abs(equation->load() * u) +
              std::abs(equation->unconstrained_residual() * u);

      local_u = x_old = x_mid = x_new = active.to_local(u);
      for (unsigned int node = 0; node < active.n_local_nodes(); ++node)
        for (unsigned int c = 0; c < dim; ++c)
          {
            const unsigned int i = dim * node + c;
            x_old[i]             = active.position(node)[c];
            x_mid[i]             = x_old[i] + 0.5 * local_u[i];
            x_new[i]             = x_old[i] + local_u[i];
          }
    }

    template <int dim>
    void
    OneStep<dim>::solve(const unsigned int n_iterations)
    {
      const auto solver =
        make_linear_solver(*cloud.solver_parameters, active.n_dofs(), dim);
      const StepData<dim> step{stencils, points, start, 0., dt};
      test::check(map_velocity(*cloud.balance, step, *solver, start).is_solved,
                  what + ": the map is solved");
      v_mapped = cloud.balance->velocity_map().mapped(start);

      // some Newton iterations, or all it takes
      equation = cloud.balance->over(step);
      u        = Vector(start.mean_velocity);
      u *= dt;
      active.constraints().set_zero(u);
      cloud.balance->add_given_displacement(active, 0., dt, u, nullptr);
      active.constraints().expand(u);
      cloud.solver_parameters->maximum_iterations = n_iterations;
      Phases phases(MPI_COMM_WORLD);
      is_converged = Newton(*cloud.solver_parameters, *solver, phases)
                       .solve(*equation, u)
                       .is_converged;
      if (n_iterations >= 20)
        test::check(is_converged, what + ": Newton converges");
      else
        test::check(!is_converged, what + ": Newton is stopped early");

      v_new         = velocity_new(u, start.velocity, dt);
      trial         = equation->trial();
      Vector change = v_new;
      change.add(-mapping.flip_fraction, v_mapped);
      test::check(move_points(stencils,
                              points,
                              active,
                              *cloud.grid,
                              cloud.layout,
                              mapping.flip_fraction,
                              active.to_local(u),
                              active.to_local(change),
                              trial)
                    .empty(),
                  what + ": no particle leaves the grid");
      books =
        accounts(step,
                 *cloud.balance,
                 *equation,
                 cloud.layout,
                 mapping,
                 GridMotion{u, v_new, motion(points, cloud.layout).energy});
    }

    template <int dim>
    void
    OneStep<dim>::check()
    {
      check_energies();
      check_losses();
      check_map();
      check_momenta();
      if (options.aggregation > 0. && is_free())
        check_followers();
    }

    template <int dim>
    void
    OneStep<dim>::check_energies() const
    {
      const double W  = equation->load() * u;
      const double ru = equation->unconstrained_residual() * u;
      const double K_grid_old =
        0.5 * start.mass.matrix_norm_square(start.velocity);
      const double K_grid_new = 0.5 * start.mass.matrix_norm_square(v_new);
      const double K_mapped   = 0.5 * start.mass.matrix_norm_square(v_mapped);
      const double K_old = before.energy, K_new = after.energy;

      vanishes(K_grid_new - K_grid_old + stored - W - ru, "energy of the grid");
      vanishes(K_new - K_old + stored - W - books.residual_work -
                 books.reaction_work + books.lumping_loss + books.mapping_loss +
                 ghost_mass_loss() + wall_loss(),
               "energy of the particles");

      double potential = 0.;
      for (std::size_t p = 0; p < points.n_points(); ++p)
        for (unsigned int d = 0; d < dim; ++d)
          potential -= points.component(cloud.layout["mass"])[p] *
                       cloud.acceleration[d] *
                       (trial.position(d)[p] - points.position(d)[p]);
      vanishes(W + sum_over_ranks(potential),
               "the work of gravity is the potential lost");

      if (is_converged)
        test::check(std::abs(books.residual_work) < 1e-8 * scale,
                    what + ": residuals do next to no work");
      for (const auto &entry : equation->energies(u))
        if (entry.name == "plastic_dissipation")
          test::check(entry.change > 0., what + ": it flows");
      vanishes(books.hidden_kinetic_energy - unresolved(),
               "what the accounts say the grid cannot see");
      if (mapping.flip_fraction == 0.)
        vanishes(K_new - 0.5 * M.matrix_norm_square(v_new),
                 "PIC: particles have the energy v.M v/2 of the grid");
      if (is_free())
        vanishes(K_old - K_mapped - unresolved() -
                   0.5 * (v_mapped * X_times(v_mapped)),
                 "kinetic energy that the grid cannot see (table 1)");
    }

    template <int dim>
    void
    OneStep<dim>::check_losses() const
    {
      vanishes(books.lumping_loss + ghost_mass_loss() -
                 0.5 * (change() * X_times(change())),
               "lumping and ghost mass lose Dv.X Dv/2");
      test::check(books.lumping_loss >= 0., what + ": lumping takes energy");
      test::check(options.ghost_mass > 0. ? ghost_mass_loss() > 0.
                                          : ghost_mass_loss() == 0.,
                  what + ": ghost mass takes energy");
      for (const auto &entry : equation->energies(u))
        if (entry.name == "ghost_stiffness_loss")
          test::check(options.ghost_stiffness > 0. ? entry.change > 0.
                                                   : entry.change == 0.,
                      what + ": ghost stiffness takes energy");
      if (is_free() && mapping.lumping == 0. && options.ghost_mass == 0.)
        vanishes(books.mapping_loss -
                   (1. - mapping.flip_fraction * mapping.flip_fraction) *
                     unresolved(),
                 "the mapping loses the energy that the grid cannot see");

      // works of walls in closed form, on fixed unknowns: of the reactions R,
      // and of what the map leaves there (W1) or the impulse that stops the
      // grid (W3)
      const auto on_fixed = [&](const Vector &a, const Vector &b) {
        Vector fixed = a;
        active.constraints().fold(fixed);
        Vector free = fixed;
        active.constraints().set_zero(free);
        fixed -= free;
        return fixed * b;
      };
      double wall_work = on_fixed(equation->unconstrained_residual(), u);
      if (options.wall_mapping == "constrained")
        wall_work += on_fixed(misfit(start.velocity), change());
      if (options.wall_mapping == "inelastic")
        wall_work -= on_fixed(times(start.mass, stopped()), start.velocity);
      vanishes(books.reaction_work - wall_work, "the work of walls");
      test::check(options.moving ? books.reaction_work != 0.
                                 : std::abs(books.reaction_work) == 0.,
                  what + ": only a wall that moves does work");
      vanishes(wall_loss() - 0.5 * start.mass.matrix_norm_square(stopped()),
               "the wall loss is w.M~ w/2");
    }

    template <int dim>
    void
    OneStep<dim>::check_map() const
    {
      Vector left = misfit(is_free() ? v_mapped : start.velocity);
      if (options.wall_mapping == "constrained")
        active.constraints().condense(left);
      test::check_close(left.l2_norm(),
                        0.,
                        tolerance * start.momentum.l2_norm(),
                        what + ": the map leaves nothing");
      test::check_close((before.linear -
                         total(times(start.mass, start.velocity)) -
                         total(misfit(start.velocity)))
                          .norm(),
                        0.,
                        tolerance * start.momentum.l1_norm(),
                        what + ": linear momentum through the map (table 1)");
    }

    template <int dim>
    void
    OneStep<dim>::check_momenta()
    {
      // what acts is load plus residual; on fixed components the residual is
      // the reaction. iota is what the map leaves, the impulse what walls give
      // to the map, over M~
      const double alpha  = mapping.flip_fraction;
      Vector       acting = equation->load();
      acting += equation->unconstrained_residual();
      const Vector iota        = misfit(start.velocity),
                   iota_mapped = misfit(v_mapped);
      Vector impulse           = times(start.mass, stopped());
      impulse *= -1.;

      const auto force = active.to_local(acting);
      for (unsigned int node = 0; node < active.n_owned_nodes(); ++node)
        force_size += in_space<dim>(force, node).norm();
      force_size = sum_over_ranks(force_size);
      test::check_close((after.linear - before.linear - dt * total(acting) -
                         alpha * total(impulse) + (1. - alpha) * total(iota))
                          .norm(),
                        0.,
                        tolerance * (before.linear.norm() + dt * force_size +
                                     start.momentum.l1_norm()),
                        what + ": linear momentum");

      J_scale              = before.angular_size + after.angular_size;
      const Vector3 turned = dt * moment(x_mid, acting);
      const Vector3 J_grid_old =
                      moment(x_old, times(start.mass, start.velocity)),
                    J_grid_new  = moment(x_new, times(start.mass, v_new));
      const Vector3 flip_defect = moment(x_old, impulse) -
                                  moment(x_new, X_times(change())) +
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
    }

    template <int dim>
    Couplings<dim>
    OneStep<dim>::couplings() const
    {
      cloud.balance->classify(stencils, points, *cloud.grid, nullptr);
      return cloud.balance->couplings(stencils,
                                      *cloud.grid,
                                      *cloud.boundary_conditions,
                                      nullptr);
    }

    template <int dim>
    double
    OneStep<dim>::ghost_mass_loss() const
    {
      double loss = 0.;
      for (const EnergyEntry &entry : books.mass_losses)
        loss += entry.change;
      return loss;
    }

    template <int dim>
    double
    OneStep<dim>::wall_loss() const
    {
      return books.map_losses.empty() ? 0. : books.map_losses[0].change;
    }

    template <int dim>
    void
    OneStep<dim>::check_followers()
    {
      const Constraints            &constraints = active.constraints();
      std::map<std::string, double> found;
      for (const StepMeasure &measure :
           cloud.balance->measures(points, 0., *cloud.grid, nullptr))
        found[measure.name] = measure.value;
      test::check(found["followers"] > 0., what + ": nodes follow");
      test::check(constraints.has_followers(), what + ": by constraints");

      // what the map leaves and what holds followers has no sum and no moment
      const Vector  iota = misfit(start.velocity);
      const Vector3 seen = moment(x_old, iota);
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
                        tolerance * u.linfty_norm() * found["largest_weight"],
                        what + ": followers follow");
    }

    template <int dim>
    void
    OneStep<dim>::vanishes(const double value, const std::string &fact) const
    {
      test::check_close(value, 0., tolerance * scale, what + ": " + fact);
    }

    template <int dim>
    bool
    OneStep<dim>::is_free() const
    {
      return (options.fixed.empty() && options.roller.empty()) ||
             options.wall_mapping != "constrained";
    }

    template <int dim>
    Vector
    OneStep<dim>::X_times(const Vector &v) const
    {
      Vector result = times(start.mass, v);
      result -= times(M, v);
      return result;
    }

    template <int dim>
    Vector
    OneStep<dim>::misfit(const Vector &v) const
    {
      Vector result = start.momentum;
      result -= times(start.mass, v);
      return result;
    }

    template <int dim>
    Vector
    OneStep<dim>::stopped() const
    {
      Vector result = v_mapped;
      result -= start.velocity;
      return result;
    }

    template <int dim>
    Vector
    OneStep<dim>::change() const
    {
      Vector result = v_new;
      result -= v_mapped;
      return result;
    }

    template <int dim>
    double
    OneStep<dim>::unresolved() const
    {
      const auto local  = active.to_local(v_mapped);
      double     result = 0.;
      for (const auto &group : stencils.groups)
        for (unsigned int q = 0; q < group.n_points; ++q)
          for (unsigned int d = 0; d < dim; ++d)
            {
              const auto p = group.first_point + q;
              double     v = points.component(cloud.layout["velocity"] + d)[p];
              for (unsigned int a = 0; a < group.n_nodes; ++a)
                v -= stencils.value(group, a)[q] *
                     local[dim * active.nodes(group)[a] + d];
              result += 0.5 * points.component(cloud.layout["mass"])[p] * v * v;
            }
      return sum_over_ranks(result);
    }

    template <int dim>
    Vector3
    OneStep<dim>::total(const Vector &vector) const
    {
      const auto local = active.to_local(vector);
      Vector3    sum;
      for (unsigned int node = 0; node < active.n_owned_nodes(); ++node)
        sum += in_space<dim>(local, node);
      return sum_over_ranks(sum);
    }

    template <int dim>
    Vector3
    OneStep<dim>::moment(const std::vector<double> &x, const Vector &a)
    {
      const auto [sum, size] =
        cross<dim>(x, active.to_local(a), active.n_owned_nodes());
      J_scale += size;
      return sum;
    }

    template class OneStep<2>;
    template class OneStep<3>;
  } // namespace test
} // namespace emmy
