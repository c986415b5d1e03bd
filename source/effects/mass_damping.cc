#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/effects/mass_damping.h>
#include <emmy/transfer/mass_blocks.h>

#include <cmath>
#include <numeric>

namespace emmy
{
  template <int dim>
  MassDampingParameters<dim>::MassDampingParameters(const std::string &section)
    : EffectParameters<dim>(section)
  {
    this->add_parameter(
      "Rate",
      rate,
      "The force on a mass m with velocity v is -rate m v. A vibration of f "
      "cycles a second is damped by rate/(4 pi f) of the critical value. "
      "Unit: 1/s. Required if mass damping is named.");
  }

  template <int dim>
  void
  MassDampingParameters<dim>::add_to(Effects<dim> &effects,
                                     FieldLayout  &layout) const
  {
    AssertThrow(rate > 0. && std::isfinite(rate),
                ExcParameter(this->path(),
                             "Rate",
                             shortest(rate),
                             "it must be positive, e.g. 0.5. For 5 % of "
                             "critical at f cycles a second take 0.2 pi f."));
    effects.terms.push_back(
      std::make_unique<MassDamping<dim>>(rate, layout["mass"]));
  }

  template <int dim>
  EffectCard
  MassDampingParameters<dim>::card()
  {
    EffectCard card;
    card.enters         = "Newton: a force against the velocity";
    card.ledger_columns = {"damping_loss"};
    return card;
  }

  template <int dim>
  MassDamping<dim>::MassDamping(const double rate, const unsigned int mass)
    : rate(rate)
    , mass(mass)
  {}

  template <int dim>
  std::vector<double>
  MassDamping<dim>::force_on_nodes(
    const StepData<dim>       &step,
    const std::vector<double> &displacement) const
  {
    std::vector<double> force(displacement.size());
    add_mass_times(displacement,
                   step.stencils,
                   step.points.component(mass),
                   step.start,
                   force);
    for (double &f : force)
      f *= rate / step.time_step;
    return force;
  }

  template <int dim>
  std::string
  MassDamping<dim>::add(const StepData<dim> &step,
                        const Iterate<dim>  &iterate,
                        Vector              &force,
                        Matrix              *jacobian) const
  {
    const ActiveGrid<dim> &active = *step.start.active;
    active.add(force_on_nodes(step, iterate.local_displacement), force);
    // where places follow the nodes, the small part by which they move the
    // force is left out of the derivative
    if (jacobian)
      for_each_mass_block<dim>(step.stencils,
                               step.points.component(mass),
                               step.start,
                               step.phases,
                               [&](MassBlock &block) {
                                 block.mass *= rate / step.time_step;
                                 active.graph().add_components(block.nodes,
                                                               block.mass,
                                                               *jacobian);
                               });
    return "";
  }

  template <int dim>
  std::vector<EnergyEntry>
  MassDamping<dim>::energies(const StepData<dim> &step,
                             const Vector        &displacement,
                             const PointArrays<dim> &) const
  {
    const auto u       = step.start.active->to_local(displacement);
    const auto force   = force_on_nodes(step, u);
    auto       entries = energy_entries();
    entries[0].change =
      std::inner_product(u.begin(), u.end(), force.begin(), 0.);
    return entries;
  }

  template <int dim>
  std::vector<EnergyEntry>
  MassDamping<dim>::energy_entries() const
  {
    return {{"damping_loss", EnergyEntry::Kind::dissipated, 0.}};
  }

  template class MassDampingParameters<2>;
  template class MassDampingParameters<3>;
  template class MassDamping<2>;
  template class MassDamping<3>;
} // namespace emmy
