#include <emmy/base/exceptions.h>
#include <emmy/effects/moving_places.h>
#include <emmy/step/step_equation.h>

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

  template <int dim>
  StepEquation<dim>::StepEquation(const Balance<dim>  &balance,
                                  const StepData<dim> &step,
                                  PointArrays<dim>     trial_states)
    : balance(balance)
    , step(step)
    , external_force(step.start.active->make_vector())
    , full_residual(step.start.active->make_vector())
    , free_residual(step.start.active->make_vector())
    , trial_states(std::move(trial_states))
  {
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
      {
        if (has_tangent)
          active.graph().clear(tangent);
        else
          active.graph().reinit(tangent);
        has_tangent = true;
        rank_ones.clear();
      }
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
        if (const auto *source = dynamic_cast<const RankOneSource *>(
              balance.effects.terms[i].get());
            source && with_jacobian)
          rank_ones.insert(rank_ones.end(),
                           source->rank_ones().begin(),
                           source->rank_ones().end());
        full_residual += force;
        force_scale = std::max(force_scale, force.l2_norm());
        total_work += absolute_product(force, solution);
      }
    if (with_jacobian)
      active.graph().finish(tangent);

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
  NewtonSystem
  StepEquation<dim>::system()
  {
    return {free_residual,
            step.moving ? with_places : free_residual,
            tangent,
            rank_ones,
            force_scale,
            total_work,
            &step.start.active->places()};
  }

  template <int dim>
  void
  StepEquation<dim>::drop_jacobian()
  {
    tangent.clear();
    has_tangent = false;
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
  void
  StepEquation<dim>::expand(Vector &increment) const
  {
    step.start.active->constraints().expand(increment);
  }

  template <int dim>
  double
  StepEquation<dim>::size(const Vector &increment) const
  {
    // sum |dS/dx_j| is at most 2/h: most often this is enough
    const ActiveGrid<dim> &active = *step.start.active;
    const double           bound =
      2. * dim * increment.linfty_norm() / active.shortest_side();
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
  bool
  StepEquation<dim>::has_kinks() const
  {
    const auto &terms = balance.effects.terms;
    return std::any_of(terms.begin(), terms.end(), [](const auto &term) {
      return term->has_kinks();
    });
  }

  template <int dim>
  const std::string &
  StepEquation<dim>::problem() const
  {
    return found;
  }

  template <int dim>
  const Vector &
  StepEquation<dim>::residual() const
  {
    return free_residual;
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
        for (const auto &entry : effect.energies(step, solution, trial_states))
          add_entry(entry, entries);
      });
    std::vector<double> changes;
    for (const EnergyEntry &entry : entries)
      changes.push_back(entry.change);
    dealii::Utilities::MPI::sum(changes,
                                step.start.active->communicator(),
                                changes);
    for (std::size_t i = 0; i < entries.size(); ++i)
      entries[i].change = changes[i];
    if (balance.has_loads())
      entries.push_back(
        {"load_work", EnergyEntry::Kind::work, external_force * solution});
    return entries;
  }

  template class StepEquation<2>;
  template class StepEquation<3>;
} // namespace emmy
