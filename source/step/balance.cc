#include <emmy/step/step_equation.h>

#include <algorithm>

namespace emmy
{
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
    , map_of_method(std::make_unique<VelocityMap<dim>>())
    , map(map_of_method.get())
  {
    for (const auto &term : this->effects.terms)
      if (VelocityMap<dim> *own = term->velocity_map())
        {
          Assert(map == map_of_method.get(),
                 dealii::ExcMessage("two effects map velocities"));
          map = own;
        }
  }

  template <int dim>
  VelocityMap<dim> &
  Balance<dim>::velocity_map() const
  {
    return *map;
  }

  template <int dim>
  bool
  Balance<dim>::has_own_map() const
  {
    return map != map_of_method.get();
  }

  template <int dim>
  bool
  Balance<dim>::gives_motion() const
  {
    return std::any_of(effects.terms.begin(),
                       effects.terms.end(),
                       [](const auto &term) { return term->given_motion(); });
  }

  template <int dim>
  Vector
  Balance<dim>::given_velocity(const ActiveGrid<dim> &active,
                               const double           time,
                               Phases                *phases) const
  {
    Vector velocity = active.make_vector();
    for_each(phases, &Effect<dim>::given_motion, [&](Effect<dim> &effect) {
      effect.given_motion()->add_velocity(active, time, velocity);
    });
    return velocity;
  }

  template <int dim>
  void
  Balance<dim>::add_given_displacement(const ActiveGrid<dim> &active,
                                       const double           time,
                                       const double           time_step,
                                       Vector                &displacement,
                                       Phases                *phases) const
  {
    for_each(phases, &Effect<dim>::given_motion, [&](Effect<dim> &effect) {
      effect.given_motion()->add_displacement(active,
                                              time,
                                              time_step,
                                              displacement);
    });
  }

  template <int dim>
  std::string
  Balance<dim>::reaction_work() const
  {
    for (const auto &term : effects.terms)
      if (const GivenMotion<dim> *motion = term->given_motion())
        return motion->work_column();
    return "";
  }

  template <int dim>
  void
  Balance<dim>::see_reactions(const ActiveGrid<dim> &active,
                              const Vector          &force) const
  {
    for (const auto &term : effects.terms)
      term->see_reactions(active, force);
  }

  template <int dim>
  std::string
  Balance<dim>::missing(const StepData<dim> &step,
                        const Vector        &displacement) const
  {
    std::string result;
    for_each(step.phases, &Effect<dim>::coupling, [&](Effect<dim> &effect) {
      if (result.empty())
        result = effect.coupling()->missing(step, displacement);
    });
    return result;
  }

  template <int dim>
  void
  Balance<dim>::check_step(const double       time,
                           const double       time_step,
                           const std::string &where) const
  {
    for (const auto &term : effects.terms)
      term->check_step(time, time_step, where);
  }

  template <int dim>
  void
  Balance<dim>::end_step(const double time, const double time_step) const
  {
    for (const auto &term : effects.terms)
      term->end_step(time, time_step);
  }

  template <int dim>
  std::unique_ptr<StepEquation<dim>>
  Balance<dim>::over(const StepData<dim> &step) const
  {
    return over(step, step.points);
  }

  template <int dim>
  std::unique_ptr<StepEquation<dim>>
  Balance<dim>::over(const StepData<dim> &step,
                     PointArrays<dim>     trial_states) const
  {
    return std::make_unique<StepEquation<dim>>(*this,
                                               step,
                                               std::move(trial_states));
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
    for_each(phases, &Effect<dim>::coupling, [&](Effect<dim> &effect) {
      effect.coupling()->classify(stencils, points, grid);
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
    for_each(phases, &Effect<dim>::coupling, [&](Effect<dim> &effect) {
      effect.coupling()->couple(stencils, grid, boundary_conditions, result);
    });
    if (!mass_loss_entries().empty())
      // whoever receives books the time: it is part of inertia, of walls
      result.hand_out_mass = [this](const ActiveGrid<dim> &active,
                                    const MassReceiver    &receive) {
        for (const auto &term : effects.terms)
          if (const AddedMass<dim> *mass = term->added_mass())
            mass->hand_out(active, receive);
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
    for_each(phases, &Effect<dim>::added_mass, [&](Effect<dim> &effect) {
      const AddedMass<dim> &mass = *effect.added_mass();
      entries.push_back(
        {mass.loss_column(),
         EnergyEntry::Kind::dissipated,
         dealii::Utilities::MPI::sum(mass.kinetic_energy(active, change),
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
      if (const AddedMass<dim> *mass = term->added_mass())
        entries.push_back(
          {mass->loss_column(), EnergyEntry::Kind::dissipated, 0.});
    return entries;
  }

  template <int dim>
  std::vector<Surface<dim>>
  Balance<dim>::surfaces(const double              time,
                         const dealii::Point<dim> &lower,
                         const dealii::Point<dim> &upper) const
  {
    std::vector<Surface<dim>> result;
    for (const auto &term : effects.terms)
      for (auto &surface : term->surfaces(time, lower, upper))
        result.push_back(std::move(surface));
    return result;
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
      for (StepMeasure &measure :
           effect.measures()->measure(points, time, grid))
        result.push_back(std::move(measure));
    });
    return result;
  }

  template <int dim>
  std::vector<std::vector<double>>
  Balance<dim>::memory() const
  {
    std::vector<std::vector<double>> result;
    for (const auto &term : effects.terms)
      {
        const StepMemory *memory = term->memory();
        result.push_back(memory ? memory->contents() : std::vector<double>());
      }
    return result;
  }

  template <int dim>
  void
  Balance<dim>::recall(
    const std::vector<std::vector<std::vector<double>>> &parts) const
  {
    for (unsigned int i = 0; i < effects.terms.size(); ++i)
      if (StepMemory *memory = effects.terms[i]->memory())
        {
          std::vector<std::vector<double>> of_term;
          for (const auto &part : parts)
            of_term.push_back(part[i]);
          memory->recall(of_term);
        }
  }

  template <int dim>
  bool
  Balance<dim>::couples_by_weights() const
  {
    return std::any_of(effects.terms.begin(),
                       effects.terms.end(),
                       [](const auto &term) {
                         const auto *coupling = term->coupling();
                         return coupling && coupling->couples_by_weights();
                       });
  }

  template <int dim>
  bool
  Balance<dim>::take_weights(const Stencils<dim>       &stencils,
                             const BackgroundGrid<dim> &grid,
                             Phases                    *phases) const
  {
    bool result = true;
    for (std::size_t i = 0; i < effects.terms.size(); ++i)
      {
        NodeCoupling<dim> *coupling = effects.terms[i]->coupling();
        if (!coupling || !coupling->couples_by_weights())
          continue;
        const auto timed = effect_scope(phases, effects.term_names[i]);
        result           = coupling->take_weights(stencils, grid) && result;
      }
    return result;
  }

  template <int dim>
  void
  Balance<dim>::follow(const Stencils<dim>       &stencils,
                       const PointArrays<dim>    &points,
                       const ActiveGrid<dim>     &active,
                       const std::vector<double> &displacement,
                       PointArrays<dim>          &trial) const
  {
    for (const auto &term : effects.terms)
      term->follow(stencils, points, active, displacement, trial);
  }

  template <int dim>
  bool
  Balance<dim>::has_loads() const
  {
    return std::any_of(effects.terms.begin(),
                       effects.terms.end(),
                       [](const auto &term) { return term->load(); });
  }

  template <int dim>
  std::vector<double>
  Balance<dim>::loads(const StepData<dim> &step) const
  {
    std::vector<double> local;
    if (has_loads())
      local.resize(dim * step.start.active->n_local_nodes());
    for (std::size_t i = 0; i < effects.terms.size(); ++i)
      {
        const Load<dim> *load = effects.terms[i]->load();
        if (!load)
          continue;
        const std::string &name   = effects.term_names[i];
        const auto         timed  = effect_scope(step.phases, name);
        const double       factor = step.ramp ? step.ramp->factor_of(name) : 1.;
        if (factor == 1.)
          {
            load->add_load(step, local);
            continue;
          }
        std::vector<double> whole(local.size());
        load->add_load(step, whole);
        for (std::size_t c = 0; c < local.size(); ++c)
          local[c] += factor * whole[c];
      }
    return local;
  }

  template <int dim>
  std::vector<double>
  Balance<dim>::point_forces(const StepData<dim> &step) const
  {
    std::vector<double> forces;
    if (has_loads())
      forces.resize(dim * step.points.n_points());
    for_each(step.phases, &Effect<dim>::load, [&](Effect<dim> &effect) {
      effect.load()->add_load_at_points(step, forces);
    });
    return forces;
  }

  template <int dim>
  void
  Balance<dim>::set_energies_at_start(const PointArrays<dim>   &points,
                                      const double              time,
                                      const MPI_Comm            communicator,
                                      std::vector<EnergyEntry> &entries) const
  {
    for (const auto &term : effects.terms)
      for (const EnergyEntry &given : term->energies_at_start(points, time))
        for (EnergyEntry &entry : entries)
          if (entry.name == given.name)
            entry.change +=
              dealii::Utilities::MPI::sum(given.change, communicator);
  }

  template <int dim>
  std::vector<EnergyEntry>
  Balance<dim>::energy_entries() const
  {
    std::vector<EnergyEntry> entries;
    for (const auto &term : effects.terms)
      for (const auto &entry : term->energy_entries())
        add_entry(entry, entries);
    if (has_loads())
      entries.push_back({"load_work", EnergyEntry::Kind::work, 0.});
    return entries;
  }

  template class Balance<2>;
  template class Balance<3>;
} // namespace emmy
