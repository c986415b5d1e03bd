#include <emmy/effects/internal_force.h>
#include <emmy/effects/point_sums.h>

namespace emmy
{
  template <int dim>
  InternalForce<dim>::InternalForce(
    std::vector<const Material<dim> *> material_of_body,
    FieldLayout                       &layout,
    const StressRule<dim>             &rule,
    std::vector<std::string>           names)
    : rule(rule)
    , states(std::move(material_of_body), std::move(names), layout)
  {}

  template <int dim>
  EffectCard
  InternalForce<dim>::card()
  {
    EffectCard card = StressStates<dim>::card();
    card.enters     = "Newton: stress of the particles";
    return card;
  }

  template <int dim>
  std::string
  InternalForce<dim>::add(const StepData<dim> &step,
                          const Iterate<dim>  &iterate,
                          Vector              &force,
                          Matrix              *jacobian) const
  {
    // too large for the stack of a thread
    const auto work          = std::make_unique<Assembly>();
    work->batch.with_tangent = jacobian != nullptr;
    work->nodal_force.resize(dim * step.start.active->n_local_nodes());
    if (jacobian)
      work->tangent.emplace(step, iterate, *jacobian);

    const std::string problem =
      states.for_each_batch(step.stencils,
                            step.phases,
                            [&](const PointBatch<dim> &points) {
                              return add_batch(step, iterate, points, *work);
                            });
    if (jacobian)
      work->tangent->finish();
    step.start.active->add(work->nodal_force,
                           force); // collective: also after a problem
    return problem;
  }

  template <int dim>
  std::string
  InternalForce<dim>::add_batch(const StepData<dim>   &step,
                                const Iterate<dim>    &iterate,
                                const PointBatch<dim> &points,
                                Assembly              &work) const
  {
    const std::size_t  first    = points.first_point;
    const unsigned int inverted = evaluate(
      step, points, iterate.local_displacement, work.batch, work.middle);
    if (inverted < points.n_points)
      return inverted_particle(step.stencils, first + inverted);
    states.write(work.batch, step.points, points.body, first, iterate.trial);
    const double *volumes = states.reference_volumes(step.points);
    add_forces(
      points, *step.start.active, volumes, work.batch, work.nodal_force);
    if (work.tangent)
      work.tangent->add(points, {work.batch, work.middle, volumes + first});
    return {};
  }

  template <int dim>
  unsigned int
  InternalForce<dim>::evaluate(const StepData<dim>       &step,
                               const PointBatch<dim>     &points,
                               const std::vector<double> &local_displacement,
                               StressBatch<dim>          &batch,
                               MiddleStep<dim>           &middle) const
  {
    displacement_gradients(points,
                           *step.start.active,
                           local_displacement,
                           batch);
    states.read(step.points, points.body, points.first_point, batch);
    const Material<dim> &material = states.material(points.body);
    if (!step.stencils.at_middle)
      return rule.evaluate(material, batch);
    unsigned int inverted = middle.to_start(batch);
    if (inverted == batch.n_points)
      inverted = rule.evaluate(material, batch);
    if (inverted == batch.n_points)
      middle.to_middle(batch);
    return inverted;
  }

  template <int dim>
  double
  InternalForce<dim>::work(const StepData<dim> &step,
                           const Vector        &displacement) const
  {
    const auto    local  = step.start.active->to_local(displacement);
    const double *volume = states.reference_volumes(step.points);
    const auto    batch  = std::make_unique<StressBatch<dim>>();
    batch->with_tangent  = false;
    MiddleStep<dim> middle;
    double          result = 0.;
    for (PointBatch<dim> points(step.stencils); points.next();)
      {
        evaluate(step, points, local, *batch, middle);
        for (unsigned int q = 0; q < points.n_points; ++q)
          result += volume[points.first_point + q] *
                    scalar_product(batch->nominal_stress[q],
                                   batch->displacement_gradient[q]);
      }
    return result;
  }

  template <int dim>
  std::vector<EnergyEntry>
  InternalForce<dim>::energies(const StepData<dim>    &step,
                               const Vector           &displacement,
                               const PointArrays<dim> &accepted) const
  {
    std::vector<EnergyEntry> entries = states.energies(step.points, accepted);
    if (!rule.is_conserving)
      {
        const auto timed = effect_scope(step.phases, stress_rule_effect);
        double     known = 0.;
        for (const EnergyEntry &entry : entries)
          known += entry.change;
        entries.push_back({"stress_rule_loss",
                           EnergyEntry::Kind::dissipated,
                           work(step, displacement) - known});
      }
    return entries;
  }

  template <int dim>
  std::vector<EnergyEntry>
  InternalForce<dim>::energy_entries() const
  {
    std::vector<EnergyEntry> entries = states.energy_entries();
    if (!rule.is_conserving)
      entries.push_back(
        {"stress_rule_loss", EnergyEntry::Kind::dissipated, 0.});
    return entries;
  }

  template class InternalForce<2>;
  template class InternalForce<3>;
} // namespace emmy
