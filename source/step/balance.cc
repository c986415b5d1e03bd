#include <emmy/base/exceptions.h>
#include <emmy/effects/moving_places.h>
#include <emmy/step/balance.h>

#include <algorithm>

namespace emmy
{
  double
  absolute_product(const Vector &a, const Vector &b)
  {
    double sum = 0.;
    auto   j   = b.begin();
    for (auto i = a.begin(); i != a.end(); ++i, ++j)
      sum += std::abs(*i) * std::abs(*j);
    return dealii::Utilities::MPI::sum(sum, a.get_mpi_communicator());
  }

  namespace
  {
    template <int dim>
    Effects<dim>
    with_names(Effects<dim> effects)
    {
      effects.name_new("unnamed");
      return effects;
    }
  } // namespace

  template <int dim>
  Balance<dim>::Balance(Effects<dim> effects)
    : effects(with_names(std::move(effects)))
  {}

  template <int dim>
  std::unique_ptr<StepEquation<dim>>
  Balance<dim>::over(const StepData<dim> &step) const
  {
    return std::make_unique<StepEquation<dim>>(*this, step);
  }

  template <int dim>
  template <class Hook>
  void
  Balance<dim>::for_each(Phases *phases,
                         bool (Effect<dim>::*has)() const,
                         Hook hook) const
  {
    for (std::size_t i = 0; i < effects.terms.size(); ++i)
      {
        Effect<dim> &effect = *effects.terms[i];
        if (!(effect.*has)())
          continue;
        const auto timed = effect_scope(phases, effects.term_names[i]);
        hook(effect);
      }
  }

  template <int dim>
  bool
  Balance<dim>::has(const std::string &effect) const
  {
    const auto &names = effects.term_names;
    return std::find(names.begin(), names.end(), effect) != names.end();
  }

  template <int dim>
  std::vector<std::string>
  Balance<dim>::mark(const BackgroundGrid<dim>               &grid,
                     dealii::Particles::ParticleHandler<dim> &particles) const
  {
    std::vector<std::string> notes;
    for (const auto &term : effects.terms)
      if (std::string note = term->mark(grid, particles); !note.empty())
        notes.push_back(std::move(note));
    return notes;
  }

  template <int dim>
  void
  Balance<dim>::classify(const Stencils<dim>       &stencils,
                         const PointArrays<dim>    &points,
                         const BackgroundGrid<dim> &grid,
                         Phases                    *phases) const
  {
    for_each(phases, &Effect<dim>::couples, [&](Effect<dim> &effect) {
      effect.classify(stencils, points, grid);
    });
  }

  template <int dim>
  Couplings<dim>
  Balance<dim>::couplings(const Stencils<dim>           &stencils,
                          const BackgroundGrid<dim>     &grid,
                          const BoundaryConditions<dim> &boundary_conditions,
                          Phases                        *phases) const
  {
    Couplings<dim> result;
    for_each(phases, &Effect<dim>::couples, [&](Effect<dim> &effect) {
      effect.couple(stencils, grid, boundary_conditions, result);
    });
    if (!mass_loss_entries().empty())
      // whoever receives books the time: it is part of inertia, of walls
      result.hand_out_mass = [this](const ActiveGrid<dim> &active,
                                    const MassReceiver    &receive) {
        for (const auto &term : effects.terms)
          term->add_mass(active, receive);
      };
    return result;
  }

  template <int dim>
  std::vector<EnergyEntry>
  Balance<dim>::mass_losses(const ActiveGrid<dim> &active,
                            const Vector          &change,
                            Phases                *phases) const
  {
    std::vector<EnergyEntry> entries;
    for_each(phases, &Effect<dim>::couples, [&](Effect<dim> &effect) {
      if (const std::string name = effect.mass_loss(); !name.empty())
        entries.push_back(
          {name,
           EnergyEntry::Kind::dissipated,
           dealii::Utilities::MPI::sum(effect.kinetic_energy(active, change),
                                       active.communicator())});
    });
    return entries;
  }

  template <int dim>
  std::vector<EnergyEntry>
  Balance<dim>::mass_loss_entries() const
  {
    std::vector<EnergyEntry> entries;
    for (const auto &term : effects.terms)
      if (const std::string name = term->mass_loss(); !name.empty())
        entries.push_back({name, EnergyEntry::Kind::dissipated, 0.});
    return entries;
  }

  template <int dim>
  std::vector<std::string>
  Balance<dim>::findings() const
  {
    std::vector<std::string> findings;
    for (const auto &term : effects.terms)
      if (std::string finding = term->finding(); !finding.empty())
        findings.push_back(std::move(finding));
    return findings;
  }

  template <int dim>
  std::vector<StepMeasure>
  Balance<dim>::measures(const PointArrays<dim>    &points,
                         const double               time,
                         const BackgroundGrid<dim> &grid,
                         Phases                    *phases) const
  {
    std::vector<StepMeasure> result;
    for_each(phases, &Effect<dim>::measures, [&](Effect<dim> &effect) {
      for (StepMeasure &measure : effect.measure(points, time, grid))
        result.push_back(std::move(measure));
    });
    return result;
  }

  template <int dim>
  bool
  Balance<dim>::has_loads() const
  {
    return std::any_of(effects.terms.begin(),
                       effects.terms.end(),
                       [](const auto &term) { return term->is_load(); });
  }

  template <int dim>
  std::vector<double>
  Balance<dim>::loads(const StepData<dim> &step) const
  {
    std::vector<double> local;
    if (has_loads())
      local.resize(dim * step.start.active->n_local_nodes());
    for_each(step.phases, &Effect<dim>::is_load, [&](Effect<dim> &effect) {
      effect.add_load(step, local);
    });
    return local;
  }

  template <int dim>
  std::vector<double>
  Balance<dim>::point_forces(const StepData<dim> &step) const
  {
    std::vector<double> forces;
    if (has_loads())
      forces.resize(dim * step.points.n_points());
    for_each(step.phases, &Effect<dim>::is_load, [&](Effect<dim> &effect) {
      effect.add_load_at_points(step, forces);
    });
    return forces;
  }

  template <int dim>
  std::vector<EnergyEntry>
  Balance<dim>::energy_entries() const
  {
    std::vector<EnergyEntry> entries;
    for (const auto &term : effects.terms)
      for (const auto &entry : term->energy_entries())
        entries.push_back(entry);
    if (has_loads())
      entries.push_back({"load_work", EnergyEntry::Kind::work, 0.});
    return entries;
  }

  template <int dim>
  StepEquation<dim>::StepEquation(const Balance<dim>  &balance,
                                  const StepData<dim> &step)
    : balance(balance)
    , step(step)
    , external_force(step.start.active->make_vector())
    , full_residual(step.start.active->make_vector())
    , free_residual(step.start.active->make_vector())
    , trial_states(step.points)
  {
    tangent.reinit(step.start.active->sparsity());
    if (balance.has_loads())
      step.start.active->add(balance.loads(step), external_force);
  }

  template <int dim>
  bool
  StepEquation<dim>::evaluate(const Vector &solution, const bool with_jacobian)
  {
    const ActiveGrid<dim> &active = *step.start.active;
    const auto             local  = active.to_local(solution);
    const Iterate<dim>     iterate{solution, local, trial_states};

    found.clear();
    full_residual = 0.;
    full_residual -= external_force;
    force_scale = std::max(external_force.l2_norm(),
                           2. / step.time_step * step.start.momentum.l2_norm());
    total_work =
      absolute_product(external_force, solution) +
      2. / step.time_step * absolute_product(step.start.momentum, solution);
    if (with_jacobian)
      tangent = 0.;
    if (step.moving)
      step.moving->begin(step, balance.point_forces(step));
    Vector force = active.make_vector();
    for (std::size_t i = 0; i < balance.effects.terms.size(); ++i)
      {
        if (!balance.effects.terms[i]->is_force())
          continue;
        force = 0.;
        std::string problem;
        {
          const std::string &effect = balance.effects.term_names[i];
          const auto         timed  = effect_scope(step.phases, effect);
          problem                   = balance.effects.terms[i]->add(
            step, iterate, force, with_jacobian ? &tangent : nullptr);
        }
        found = agree_on_problem(active.communicator(), problem);
        if (!found.empty())
          return false;
        full_residual += force;
        force_scale = std::max(force_scale, force.l2_norm());
        total_work += absolute_product(force, solution);
      }
    if (with_jacobian)
      tangent.compress(dealii::VectorOperation::add);

    free_residual = full_residual;
    active.constraints().condense(free_residual);
    if (step.moving)
      {
        with_places = active.make_vector();
        active.add(step.moving->residual_share(), with_places);
        active.constraints().condense(with_places);
        with_places += free_residual;
      }
    return true;
  }

  template <int dim>
  const Vector &
  StepEquation<dim>::reduced_residual() const
  {
    return step.moving ? with_places : free_residual;
  }

  template <int dim>
  void
  StepEquation<dim>::set_velocity_at_start()
  {
    Vector misfit = step.start.momentum; // p - M~ v_t
    step.start.mass.residual(misfit, step.start.velocity, step.start.momentum);
    full_residual.add(2. / step.time_step, misfit);
    free_residual = full_residual;
    step.start.active->constraints().condense(free_residual);
  }

  template <int dim>
  const StepData<dim> &
  StepEquation<dim>::data() const
  {
    return step;
  }

  template <int dim>
  const Vector &
  StepEquation<dim>::residual() const
  {
    return free_residual;
  }

  template <int dim>
  Matrix &
  StepEquation<dim>::jacobian()
  {
    return tangent;
  }

  template <int dim>
  void
  StepEquation<dim>::expand(Vector &increment) const
  {
    step.start.active->constraints().expand(increment);
  }

  template <int dim>
  double
  StepEquation<dim>::scale() const
  {
    return force_scale;
  }

  template <int dim>
  double
  StepEquation<dim>::work_scale() const
  {
    return total_work;
  }

  template <int dim>
  double
  StepEquation<dim>::size(const Vector &increment) const
  {
    // sum |dS/dx_j| is at most 2/h: most often this is enough
    const ActiveGrid<dim> &active = *step.start.active;
    const double           bound =
      2. * dim * increment.linfty_norm() / active.smallest_cell_size();
    if (bound < 0.1)
      return bound;

    const auto u       = active.to_local(increment);
    double     largest = 0.;
    for (const auto &group : step.stencils.groups)
      for (unsigned int q = 0; q < group.n_points; ++q)
        largest =
          std::max(largest,
                   step.stencils
                     .displacement_gradient(group, q, active.nodes(group), u)
                     .norm_square());
    return std::sqrt(
      dealii::Utilities::MPI::max(largest, active.communicator()));
  }

  template <int dim>
  const std::string &
  StepEquation<dim>::problem() const
  {
    return found;
  }

  template <int dim>
  const Vector &
  StepEquation<dim>::unconstrained_residual() const
  {
    return full_residual;
  }

  template <int dim>
  const Vector &
  StepEquation<dim>::load() const
  {
    return external_force;
  }

  template <int dim>
  PointArrays<dim> &
  StepEquation<dim>::trial()
  {
    return trial_states;
  }

  template <int dim>
  const PointArrays<dim> &
  StepEquation<dim>::trial() const
  {
    return trial_states;
  }

  template <int dim>
  std::vector<EnergyEntry>
  StepEquation<dim>::energies(const Vector &solution) const
  {
    std::vector<EnergyEntry> entries;
    balance.for_each(
      step.phases, &Effect<dim>::is_force, [&](Effect<dim> &effect) {
        for (auto entry : effect.energies(step, solution, trial_states))
          {
            entry.change =
              dealii::Utilities::MPI::sum(entry.change,
                                          step.start.active->communicator());
            entries.push_back(entry);
          }
      });
    if (balance.has_loads())
      entries.push_back(
        {"load_work", EnergyEntry::Kind::work, external_force * solution});
    return entries;
  }

  template class Balance<2>;
  template class Balance<3>;
  template class StepEquation<2>;
  template class StepEquation<3>;
} // namespace emmy
