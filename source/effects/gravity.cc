#include <emmy/effects/gravity.h>

namespace emmy
{
  template <int dim>
  GravityParameters<dim>::GravityParameters(const std::string &section)
    : EffectParameters<dim>(section)
  {
    this->add_parameter("Acceleration",
                        acceleration,
                        "Components of the acceleration, separated by , or ;: "
                        "0, -9.81. Unit: m/s^2. "
                        "Required if gravity is named.",
                        this->prm,
                        dealii::Patterns::List(dealii::Patterns::Double(),
                                               0,
                                               dim));
    amplitude.declare(*this);
  }

  template <int dim>
  void
  GravityParameters<dim>::add_to(Effects<dim> &effects,
                                 FieldLayout  &layout) const
  {
    AssertThrow(acceleration.size() == dim,
                ExcParameter(this->path(),
                             "Acceleration",
                             dealii::Patterns::Tools::to_string(acceleration),
                             "it is required: " + std::to_string(dim) +
                               " components in m/s^2, separated by , or ;, "
                               "e.g. " +
                               (dim == 2 ? "0, -9.81." : "0, 0, -9.81.")));
    effects.terms.push_back(std::make_unique<Gravity<dim>>(
      vector(), layout["mass"], Amplitude(amplitude, this->path())));
  }

  template <int dim>
  dealii::Tensor<1, dim>
  GravityParameters<dim>::vector() const
  {
    dealii::Tensor<1, dim> g;
    for (unsigned int d = 0; d < dim && d < acceleration.size(); ++d)
      g[d] = acceleration[d];
    return g;
  }

  template <int dim>
  std::vector<TimeHistory>
  GravityParameters<dim>::histories() const
  {
    return {amplitude.history("gravity", this->path())};
  }

  template <int dim>
  EffectCard
  GravityParameters<dim>::card()
  {
    EffectCard card;
    card.enters         = "loads of the step, before Newton";
    card.ledger_columns = {"load_work"};
    return card;
  }

  template class GravityParameters<2>;
  template class GravityParameters<3>;
} // namespace emmy
