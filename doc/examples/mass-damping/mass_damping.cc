#include "mass_damping.h"

template <int dim>
MassDampingParameters<dim>::MassDampingParameters(const std::string &section)
  : emmy::EffectParameters<dim>(section)
{
  this->add_parameter("Rate",
                      rate,
                      "alpha of the force alpha M v. Unit: 1/s. Required if "
                      "mass damping is named, positive.",
                      this->prm,
                      dealii::Patterns::Double());
}

template <int dim>
emmy::EffectCard
MassDampingParameters<dim>::card()
{
  emmy::EffectCard card;
  card.enters         = "Newton: mass times velocity";
  card.ledger_columns = {"damping_loss"};
  return card;
}

template <int dim>
void
MassDampingParameters<dim>::add_to(emmy::Effects<dim> &effects,
                                   emmy::FieldLayout &) const
{
  AssertThrow(rate > 0.,
              emmy::ExcParameter(this->path(),
                                 "Rate",
                                 emmy::shortest(rate),
                                 "it is required and must be positive (1/s). A "
                                 "velocity halves in about 0.7/rate."));
  effects.terms.push_back(std::make_unique<MassDamping<dim>>(rate));
}

template <int dim>
MassDamping<dim>::MassDamping(const double rate)
  : rate(rate)
{}

template <int dim>
std::string
MassDamping<dim>::add(const emmy::StepData<dim> &step,
                      const emmy::Iterate<dim>  &iterate,
                      emmy::Vector              &force,
                      emmy::Matrix              *jacobian) const
{
  emmy::Vector momentum = step.start.active->make_vector(); // times dt
  step.start.mass.vmult(momentum, iterate.displacement);
  force.add(rate / step.time_step, momentum);
  if (jacobian)
    step.start.add_mass_to(*jacobian, rate / step.time_step);
  return "";
}

template <int dim>
std::vector<emmy::EnergyEntry>
MassDamping<dim>::energies(const emmy::StepData<dim> &step,
                           const emmy::Vector        &displacement,
                           const emmy::PointArrays<dim> &) const
{
  emmy::Vector momentum = step.start.active->make_vector(); // times dt
  step.start.mass.vmult(momentum, displacement);
  auto entries = energy_entries();
  for (const auto i : step.start.active->dofs()) // those of this rank
    entries[0].change += rate / step.time_step * momentum(i) * displacement(i);
  return entries;
}

template <int dim>
std::vector<emmy::EnergyEntry>
MassDamping<dim>::energy_entries() const
{
  return {{"damping_loss", emmy::EnergyEntry::Kind::dissipated, 0.}};
}

namespace
{
  /** The line of the library. */
  template <int dim>
  void
  add_line()
  {
    emmy::effect_library<dim>().add(
      {"mass damping",
       "a force proportional to mass and velocity",
       [](const std::string &section) {
         return std::make_unique<MassDampingParameters<dim>>(section);
       },
       MassDampingParameters<dim>::card()});
  }
} // namespace

void
add_mass_damping()
{
  add_line<2>();
  add_line<3>();
}
