#include <emmy/base/exceptions.h>
#include <emmy/step/explicit_stepper.h>
#include <emmy/transfer/grid_to_particles.h>

namespace emmy
{
  EffectCard
  explicit_card(const bool is_present)
  {
    EffectCard card;
    card.name           = explicit_effect;
    card.setting        = "Time/Integrator = explicit";
    card.enters         = "instead of Newton: forces over lumped masses, with "
                          "no matrix";
    card.ledger_columns = {"velocity_update_loss"};
    card.phases         = {"forces and velocities"};
    card.is_present     = is_present;
    return card;
  }

  template <int dim>
  ExplicitStepper<dim>::ExplicitStepper(
    BackgroundGrid<dim>                     &grid,
    const BoundaryConditions<dim>           &boundary_conditions,
    const FieldLayout                       &layout,
    const StepMethod<dim>                   &method,
    const ExplicitForce<dim>                &force,
    const TimeParameters                    &time_parameters,
    dealii::Particles::ParticleHandler<dim> &particles,
    Phases                                  &phases)
    : grid(grid)
    , boundary_conditions(boundary_conditions)
    , layout(layout)
    , method(method)
    , force(force)
    , limits(time_parameters)
    , particles(particles)
    , phases(phases)
    , domains(method.domain_update, grid, layout, phases)
    , detector({layout.has("half_length"),
                /*middle=*/true,
                /*followers=*/true,
                method.mapping.flip_fraction < 1.})
  {}

  template <int dim>
  StepReport
  ExplicitStepper<dim>::advance()
  {
    StepReport result;

    // particles -> grid
    const Stencils<dim>    stencils = timed("stencils", [&] {
      return method.shape_functions.evaluate(particles, grid);
    });
    const PointArrays<dim> points =
      timed("gather", [&] { return gather(stencils, layout); });
    timed("particles to grid", [&] { particles_to_grid(stencils, points); });

    // forces with the stress at t
    const StepSize chosen = timed("step size", [&] {
      return choose_step_size(
        method, limits, layout, stencils, points, *start.active, time);
    });
    if (!chosen.note.empty() && !has_limited_travel)
      {
        has_limited_travel = true;
        result.notes.push_back(where() + ": " + chosen.note);
      }
    auto travel = wall_travel;
    if (boundary_conditions.has_moving_walls())
      {
        const auto moved =
          boundary_conditions.wall_displacements(time, chosen.time_step);
        for (unsigned int side = 0; side < 2 * dim; ++side)
          travel[side] += moved[side];
        boundary_conditions.check_travel(travel, where());
      }
    const StepData<dim> step{
      stencils, points, start, time, chosen.time_step, &phases};
    const Motion motion =
      timed("forces and velocities", [&] { return accelerate(step); });

    // grid -> particles, the stress last; a step that fails leaves no trace
    const PointArrays<dim> trial =
      timed("motion and stress", [&] { return move(step, motion, result); });
    timed("accounts", [&] { report(step, motion, trial, result); });
    timed("grid to particles",
          [&] { grid_to_particles(stencils, trial, layout, grid, particles); });

    for (const char *phase : {"stencils",
                              "gather",
                              "particles to grid",
                              "forces and velocities",
                              "motion and stress",
                              "accounts",
                              "grid to particles"})
      phases.add_count(phase, points.n_points());
    start.velocity = start.active->to_vector(motion.velocity_old);
    velocity       = start.active->to_vector(motion.velocity_new);
    kinetic_energy = result.totals.kinetic_energy;
    time           = result.time;
    step_number    = result.step;
    wall_travel    = travel;
    return result;
  }

  template <int dim>
  void
  ExplicitStepper<dim>::particles_to_grid(const Stencils<dim>    &stencils,
                                          const PointArrays<dim> &points)
  {
    if (!start.active || !start.active->fits(stencils, {}))
      start.active = std::make_unique<const ActiveGrid<dim>>(
        stencils,
        Couplings<dim>(),
        grid,
        boundary_conditions,
        ActiveGrid<dim>::Matrices::none);
    lumped = particles_to_lumped_grid(stencils, points, layout, *start.active);
  }

  template <int dim>
  typename ExplicitStepper<dim>::Motion
  ExplicitStepper<dim>::accelerate(const StepData<dim> &step) const
  {
    const ActiveGrid<dim> &active = *step.start.active;
    const double           dt     = step.time_step;
    std::vector<double>    internal(dim * active.n_local_nodes());
    force.add(step, internal);
    active.share(internal);
    // what acts in the middle of an implicit step acts at t here, as the stress
    const StepData<dim> half_a_step_earlier{step.stencils,
                                            step.points,
                                            step.start,
                                            step.time - 0.5 * dt,
                                            dt,
                                            step.phases};
    std::vector<double> load = method.balance.loads(half_a_step_earlier);
    if (!load.empty()) // a rank without nodes shares none
      active.share(load);
    load.resize(internal.size()); // zero, if there is none

    Motion motion;
    motion.velocity_old = lumped.velocity;
    motion.velocity_new = lumped.velocity;
    motion.displacement.resize(internal.size());
    for (unsigned int i = 0; i < internal.size(); ++i)
      if (!lumped.is_massless[i / dim])
        motion.velocity_new[i] +=
          dt * (load[i] - internal[i]) / lumped.mass[i / dim];
    motion.is_fixed.resize(internal.size());
    if (boundary_conditions.has_walls())
      set_walls(step, motion);
    for (unsigned int i = 0; i < internal.size(); ++i)
      motion.displacement[i] = dt * motion.velocity_new[i];

    for (unsigned int i = 0; i < dim * active.n_owned_nodes(); ++i)
      {
        const double m = lumped.mass[i / dim], v_old = motion.velocity_old[i],
                     v_new = motion.velocity_new[i], dv = v_new - v_old,
                     u     = motion.displacement[i];
        const double given = load[i] - internal[i];
        motion.kinetic_energy_old += 0.5 * m * v_old * v_old;
        motion.kinetic_energy_new += 0.5 * m * v_new * v_new;
        motion.velocity_update_loss += 0.5 * m * dv * dv;
        motion.stress_work += internal[i] * u;
        motion.load_work += load[i] * u;
        if (motion.is_fixed[i])
          // through the forces of the step, and through the map
          motion.reaction_work +=
            (m * dv / dt - given) * u + (lumped.momentum[i] - m * v_old) * dv;
        else if (lumped.is_massless[i / dim])
          motion.residual_work -= given * u;
      }
    return motion;
  }

  template <int dim>
  void
  ExplicitStepper<dim>::set_walls(const StepData<dim> &step,
                                  Motion              &motion) const
  {
    const ActiveGrid<dim> &active     = *step.start.active;
    const bool             has_moving = boundary_conditions.has_moving_walls();
    typename BoundaryConditions<dim>::Sides at_start{}, at_end{};
    if (has_moving)
      {
        at_start = boundary_conditions.wall_velocities(step.time);
        at_end =
          boundary_conditions.wall_velocities(step.time + step.time_step);
      }
    for (unsigned int node = 0; node < active.n_local_nodes(); ++node)
      {
        const auto &position = active.position(node);
        const auto  fixed    = boundary_conditions.fixed_components(position);
        for (unsigned int c = 0; c < dim; ++c)
          if (fixed[c])
            {
              const unsigned int i = dim * node + c;
              motion.is_fixed[i]   = true;
              motion.velocity_old[i] =
                has_moving ? boundary_conditions.value(at_start, position, c)
                           : 0.;
              motion.velocity_new[i] =
                has_moving ? boundary_conditions.value(at_end, position, c)
                           : 0.;
            }
      }
  }

  template <int dim>
  PointArrays<dim>
  ExplicitStepper<dim>::move(const StepData<dim> &step,
                             const Motion        &motion,
                             StepReport          &result)
  {
    const ActiveGrid<dim> &active = *step.start.active;
    const std::string      remedy =
      "the last accepted state was kept. Explicit steps are stable only if "
      "they are small: take a smaller Time/Factor (below 1) or Step size. "
      "Time/Stress update = modified and Method/Shape functions = GIMP are "
      "more robust. Or set Time/Integrator = implicit.";

    // v_p <- alpha v_p + sum S (v_new - alpha v_old)
    const double        alpha  = method.mapping.flip_fraction;
    std::vector<double> change = motion.velocity_new;
    for (unsigned int i = 0; i < change.size(); ++i)
      change[i] -= alpha * motion.velocity_old[i];
    PointArrays<dim> trial = step.points;
    throw_together(grid.communicator(),
                   where(),
                   move_points(step.stencils,
                               step.points,
                               active,
                               grid,
                               layout,
                               alpha,
                               motion.displacement,
                               change,
                               trial),
                   remedy + " If it should leave, enlarge the grid.");

    const std::vector<double> straining =
      straining_displacement(step, motion, trial);
    throw_together(grid.communicator(),
                   where(),
                   force.update(step, straining, trial),
                   remedy);
    const std::string note = domains.follow(
      step.stencils, step.points, active, straining, where(), trial);
    if (!note.empty())
      result.notes.push_back(note);
    return trial;
  }

  template <int dim>
  std::vector<double>
  ExplicitStepper<dim>::straining_displacement(
    const StepData<dim>    &step,
    const Motion           &motion,
    const PointArrays<dim> &trial) const
  {
    if (limits.stress_update == "plain")
      return motion.displacement;
    std::vector<double> result =
      particles_to_lumped_grid(step.stencils, trial, layout, *step.start.active)
        .velocity;
    for (unsigned int i = 0; i < result.size(); ++i)
      result[i] = motion.is_fixed[i] ? motion.displacement[i]
                                     : step.time_step * result[i];
    return result;
  }

  template <int dim>
  void
  ExplicitStepper<dim>::report(const StepData<dim>    &step,
                               const Motion           &motion,
                               const PointArrays<dim> &trial,
                               StepReport             &result)
  {
    result.step      = step_number + 1;
    result.time_step = step.time_step;
    result.time      = time + step.time_step;
    result.totals    = measure(trial, layout, grid.communicator());
    result.kinetic_energy_change =
      result.totals.kinetic_energy - kinetic_energy;

    // the sums over this rank first, in one exchange
    result.energies = force.energies(step.points, trial, motion.stress_work);
    for (const EnergyEntry &entry : method.balance.energy_entries())
      result.energies.push_back(
        {entry.name, entry.kind, motion.load_work}); // there is no other
    std::vector<double> sums{motion.kinetic_energy_old,
                             motion.kinetic_energy_new,
                             motion.velocity_update_loss,
                             motion.reaction_work,
                             motion.residual_work};
    const std::size_t   n = sums.size();
    for (const EnergyEntry &entry : result.energies)
      sums.push_back(entry.change);
    dealii::Utilities::MPI::sum(sums, grid.communicator(), sums);
    for (std::size_t i = 0; i < result.energies.size(); ++i)
      result.energies[i].change = sums[n + i];

    result.kinetic_energy_grid_old = sums[0];
    result.kinetic_energy_grid_new = sums[1];
    result.residual_work           = sums[4];
    StepAccounts books;
    books.reaction_work = sums[3];
    add_mapping_losses(step,
                       layout,
                       method.mapping,
                       motion.velocity_old,
                       motion.velocity_new,
                       books);
    for (const EnergyEntry &entry : account_entries(books, sums[2]))
      result.energies.push_back(entry);
    detector.look(
      books.hidden_kinetic_energy,
      overfill(step.stencils, step.points, trial, layout, *start.active, grid),
      where(),
      result);
    for (StepMeasure &measure :
         method.balance.measures(trial, result.time, grid, &phases))
      result.measures.push_back(std::move(measure));
    result.active_cells =
      dealii::Utilities::MPI::sum(static_cast<std::uint64_t>(
                                    start.active->cells().size()),
                                  grid.communicator());
    result.active_dofs = start.active->n_dofs();
  }

  template <int dim>
  std::vector<EnergyEntry>
  ExplicitStepper<dim>::account_entries(const StepAccounts &accounts,
                                        const double        loss) const
  {
    std::vector<EnergyEntry> entries =
      emmy::account_entries(accounts,
                            method.mapping,
                            boundary_conditions.has_moving_walls());
    entries.push_back(
      {"velocity_update_loss", EnergyEntry::Kind::dissipated, loss});
    return entries;
  }

  template <int dim>
  StepReport
  ExplicitStepper<dim>::initial_report()
  {
    const Stencils<dim> stencils =
      method.shape_functions.evaluate(particles, grid);
    const PointArrays<dim> points = gather(stencils, layout);
    particles_to_grid(stencils, points);

    StepReport result;
    result.time_step =
      choose_step_size(
        method, limits, layout, stencils, points, *start.active, time)
        .time_step;
    result.totals = measure(points, layout, grid.communicator());
    detector.begin(
      overfill(stencils, points, points, layout, *start.active, grid), result);
    for (StepMeasure &measure :
         method.balance.measures(points, time, grid, &phases))
      result.measures.push_back(std::move(measure));
    kinetic_energy  = result.totals.kinetic_energy;
    result.energies = force.energy_entries();
    for (const EnergyEntry &entry : method.balance.energy_entries())
      result.energies.push_back(entry);
    for (const EnergyEntry &entry : account_entries(StepAccounts(), 0.))
      result.energies.push_back(entry);
    result.active_cells =
      dealii::Utilities::MPI::sum(static_cast<std::uint64_t>(
                                    start.active->cells().size()),
                                  grid.communicator());
    result.active_dofs = start.active->n_dofs();
    return result;
  }

  template <int dim>
  std::string
  ExplicitStepper<dim>::where() const
  {
    return step_name(step_number + 1, time);
  }

  template <int dim>
  std::string
  ExplicitStepper<dim>::solver_name() const
  {
    return "none: explicit steps";
  }

  template <int dim>
  const GridStart<dim> &
  ExplicitStepper<dim>::grid_start() const
  {
    return start;
  }

  template <int dim>
  const Vector &
  ExplicitStepper<dim>::grid_velocity() const
  {
    return velocity;
  }

  template <int dim>
  std::vector<double>
  ExplicitStepper<dim>::nodal_mass() const
  {
    return lumped.mass;
  }

  template <int dim>
  const StepDiagnosis<dim> *
  ExplicitStepper<dim>::diagnosis() const
  {
    return nullptr;
  }

  template class ExplicitStepper<2>;
  template class ExplicitStepper<3>;
} // namespace emmy
