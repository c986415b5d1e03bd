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
  ExplicitStepper<dim>::ExplicitStepper(const StepSetting<dim>   &setting,
                                        const ExplicitForce<dim> &force,
                                        RunState<dim>            &state)
    : Base(setting,
           state,
           {setting.layout.has("half_length"),
            /*middle=*/true,
            /*followers=*/true,
            setting.method.mapping.flip_fraction < 1.})
    , force(force)
  {}

  template <int dim>
  StepReport
  ExplicitStepper<dim>::advance()
  {
    std::vector<std::string> notes;

    // particles -> grid
    const Ground<dim> ground = this->ground_at_start();
    timed("particles to grid", [&] { renew_grid(ground); });

    // forces with the stress at t
    const StepSize chosen = timed("step size", [&] {
      return choose_step_size(setting.method,
                              setting.limits,
                              setting.layout,
                              ground.stencils,
                              ground.points,
                              *start.active,
                              state.time);
    });
    this->note_limit(chosen, notes);
    setting.method.balance.check_step(state.time, chosen.time_step, where());
    const StepData<dim> step{ground.stencils,
                             ground.points,
                             start,
                             state.time,
                             chosen.time_step,
                             &setting.phases};
    const Motion        motion =
      timed("forces and velocities", [&] { return accelerate(step); });

    // grid -> particles, the stress last; a step that fails leaves no trace
    const PointArrays<dim> trial = timed("motion and stress", [&] {
      return move(ground, step, motion, notes);
    });
    StepReport             result =
      timed("accounts", [&] { return report(ground, step, motion, trial); });
    result.notes.insert(result.notes.begin(), notes.begin(), notes.end());
    accept(ground, trial, result);
    for (const char *phase :
         {"forces and velocities", "motion and stress", "accounts"})
      setting.phases.add_count(phase, ground.points.n_points());
    start.velocity = start.active->to_vector(motion.velocity_old);
    velocity       = start.active->to_vector(motion.velocity_new);
    return result;
  }

  template <int dim>
  const ActiveGrid<dim> &
  ExplicitStepper<dim>::renew_grid(const Ground<dim> &ground)
  {
    if (!start.active || !start.active->fits(ground.stencils, {}))
      start.active = std::make_unique<const ActiveGrid<dim>>(
        ground.stencils,
        Couplings<dim>(),
        setting.grid,
        setting.boundary_conditions,
        ActiveGrid<dim>::Matrices::none);
    lumped = particles_to_lumped_grid(ground.stencils,
                                      ground.points,
                                      setting.layout,
                                      *start.active);
    return *start.active;
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
    std::vector<double> load =
      setting.method.balance.loads(half_a_step_earlier);
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
    motion.reaction.resize(internal.size());
    if (setting.boundary_conditions.has_walls())
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
          {
            motion.reaction[i] = m * dv / dt - given;
            // through the forces of the step, and through the map
            motion.reaction_work +=
              motion.reaction[i] * u + (lumped.momentum[i] - m * v_old) * dv;
          }
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
    const ActiveGrid<dim> &active  = *step.start.active;
    const Balance<dim>    &balance = setting.method.balance;
    const bool             moves   = balance.gives_motion();
    std::vector<double>    at_start, at_end;
    if (moves)
      {
        const auto given_at = [&](const double time) {
          return active.to_local(
            balance.given_velocity(active, time, step.phases));
        };
        at_start = given_at(step.time);
        at_end   = given_at(step.time + step.time_step);
      }
    for (unsigned int node = 0; node < active.n_local_nodes(); ++node)
      {
        const auto fixed =
          setting.boundary_conditions.fixed_components(active.position(node));
        for (unsigned int c = 0; c < dim; ++c)
          if (fixed[c])
            {
              const unsigned int i   = unknown<dim>(node, c);
              motion.is_fixed[i]     = true;
              motion.velocity_old[i] = moves ? at_start[i] : 0.;
              motion.velocity_new[i] = moves ? at_end[i] : 0.;
            }
      }
  }

  template <int dim>
  PointArrays<dim>
  ExplicitStepper<dim>::move(const Ground<dim>        &ground,
                             const StepData<dim>      &step,
                             const Motion             &motion,
                             std::vector<std::string> &notes)
  {
    const ActiveGrid<dim> &active = *step.start.active;
    const std::string      remedy =
      "the last accepted state was kept. Explicit steps are stable only if "
      "they are small: take a smaller Time/Factor (below 1) or Step size. "
      "Time/Stress update = modified and Method/Shape functions = GIMP are "
      "more robust. Or set Time/Integrator = implicit.";

    // v_p <- alpha v_p + sum S (v_new - alpha v_old)
    const double        alpha  = setting.method.mapping.flip_fraction;
    std::vector<double> change = motion.velocity_new;
    for (unsigned int i = 0; i < change.size(); ++i)
      change[i] -= alpha * motion.velocity_old[i];
    PointArrays<dim> trial = step.points;
    throw_together(setting.grid.communicator(),
                   where(),
                   move_points(step.stencils,
                               step.points,
                               active,
                               setting.grid,
                               setting.layout,
                               alpha,
                               motion.displacement,
                               change,
                               trial),
                   remedy + " If it should leave, enlarge the grid.");

    const std::vector<double> straining =
      straining_displacement(step, motion, trial);
    throw_together(setting.grid.communicator(),
                   where(),
                   force.update(step, straining, trial),
                   remedy);
    this->follow_domains(ground, active, straining, trial, notes);
    return trial;
  }

  template <int dim>
  std::vector<double>
  ExplicitStepper<dim>::straining_displacement(
    const StepData<dim>    &step,
    const Motion           &motion,
    const PointArrays<dim> &trial) const
  {
    if (setting.limits.stress_update == "plain")
      return motion.displacement;
    std::vector<double> result = particles_to_lumped_grid(step.stencils,
                                                          trial,
                                                          setting.layout,
                                                          *step.start.active)
                                   .velocity;
    for (unsigned int i = 0; i < result.size(); ++i)
      result[i] = motion.is_fixed[i] ? motion.displacement[i]
                                     : step.time_step * result[i];
    return result;
  }

  template <int dim>
  StepReport
  ExplicitStepper<dim>::report(const Ground<dim>      &ground,
                               const StepData<dim>    &step,
                               const Motion           &motion,
                               const PointArrays<dim> &trial)
  {
    StepReport result = this->begin_report(step.time_step, trial);
    result.kinetic_energy_change =
      result.totals.kinetic_energy - state.kinetic_energy;

    // the sums over this rank first, in one exchange
    result.energies = force.energies(step.points, trial, motion.stress_work);
    for (const EnergyEntry &entry : setting.method.balance.energy_entries())
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
    dealii::Utilities::MPI::sum(sums, setting.grid.communicator(), sums);
    for (std::size_t i = 0; i < result.energies.size(); ++i)
      result.energies[i].change = sums[n + i];

    result.kinetic_energy_grid_old = sums[0];
    result.kinetic_energy_grid_new = sums[1];
    result.residual_work           = sums[4];
    StepAccounts books;
    books.reaction_work = sums[3];
    add_mapping_losses(step,
                       setting.layout,
                       setting.method.mapping,
                       motion.velocity_old,
                       motion.velocity_new,
                       books);
    for (const EnergyEntry &entry : account_entries(books, sums[2]))
      result.energies.push_back(entry);
    if (setting.boundary_conditions.has_walls())
      setting.method.balance.see_reactions(
        *start.active, start.active->to_vector(motion.reaction));
    this->end_report(
      ground, trial, *start.active, books.hidden_kinetic_energy, result);
    return result;
  }

  template <int dim>
  std::vector<EnergyEntry>
  ExplicitStepper<dim>::account_entries(const StepAccounts &accounts,
                                        const double        loss) const
  {
    std::vector<EnergyEntry> entries =
      emmy::account_entries(accounts, setting.method);
    entries.push_back(
      {"velocity_update_loss", EnergyEntry::Kind::dissipated, loss});
    return entries;
  }

  template <int dim>
  std::vector<EnergyEntry>
  ExplicitStepper<dim>::energy_entries() const
  {
    std::vector<EnergyEntry> entries = force.energy_entries();
    for (const EnergyEntry &entry : setting.method.balance.energy_entries())
      entries.push_back(entry);
    for (const EnergyEntry &entry : account_entries(StepAccounts(), 0.))
      entries.push_back(entry);
    return entries;
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
