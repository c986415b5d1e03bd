#include <emmy/effects/explicit_force.h>
#include <emmy/effects/point_sums.h>

namespace emmy
{
  template <int dim>
  ExplicitForce<dim>::ExplicitForce(
    std::vector<const Material<dim> *> material_of_body,
    FieldLayout                       &layout,
    std::vector<std::string>           names)
    : states(std::move(material_of_body), std::move(names), layout)
  {}

  template <int dim>
  EffectCard
  ExplicitForce<dim>::card()
  {
    EffectCard card = StressStates<dim>::card();
    card.enters =
      "forces and velocities: stress at the start; motion and stress: that at the end";
    card.ledger_columns.push_back("stress_update_loss");
    return card;
  }

  template <int dim>
  void
  ExplicitForce<dim>::add(const StepData<dim> &step,
                          std::vector<double> &local_force) const
  {
    const auto timed = effect_scope(step.phases, internal_force_effect);
    const auto batch = std::make_unique<Batch>();
    for (PointBatch<dim> points(step.stencils); points.next();)
      {
        for (unsigned int q = 0; q < points.n_points; ++q)
          batch->nominal_stress[q] = mandel::block<dim>(
            states.stress(step.points, points.first_point + q));
        add_forces(points,
                   *step.start.active,
                   states.reference_volumes(step.points),
                   *batch,
                   local_force);
      }
  }

  template <int dim>
  std::string
  ExplicitForce<dim>::update(const StepData<dim>       &step,
                             const std::vector<double> &displacement,
                             PointArrays<dim>          &trial) const
  {
    const auto timed    = effect_scope(step.phases, internal_force_effect);
    const auto batch    = std::make_unique<Batch>();
    batch->with_tangent = false;
    return states.for_each_batch(
      step.stencils,
      step.phases,
      [&](const PointBatch<dim> &points) -> std::string {
        displacement_gradients(points,
                               *step.start.active,
                               displacement,
                               *batch);
        states.read(step.points, points.body, points.first_point, *batch);
        const unsigned int inverted =
          update_states(states.material(points.body), *batch);
        if (inverted < points.n_points)
          return inverted_particle(step.stencils,
                                   points.first_point + inverted);
        states.write(
          *batch, step.points, points.body, points.first_point, trial);
        return {};
      });
  }

  template <int dim>
  std::vector<EnergyEntry>
  ExplicitForce<dim>::energies(const PointArrays<dim> &points,
                               const PointArrays<dim> &accepted,
                               const double            work) const
  {
    std::vector<EnergyEntry> entries = states.energies(points, accepted);
    double                   known   = 0.;
    for (const EnergyEntry &entry : entries)
      known += entry.change;
    entries.push_back(
      {"stress_update_loss", EnergyEntry::Kind::dissipated, work - known});
    return entries;
  }

  template <int dim>
  std::vector<EnergyEntry>
  ExplicitForce<dim>::energy_entries() const
  {
    std::vector<EnergyEntry> entries = states.energy_entries();
    entries.push_back(
      {"stress_update_loss", EnergyEntry::Kind::dissipated, 0.});
    return entries;
  }

  template class ExplicitForce<2>;
  template class ExplicitForce<3>;
} // namespace emmy
