#include <emmy/assembly/aggregation.h>

namespace emmy
{
  template <int dim>
  AggregationParameters<dim>::AggregationParameters(const std::string &section)
    : EffectParameters<dim>(section)
  {
    this->add_parameter(
      "Mass threshold",
      mass_threshold,
      "theta: a node with less than this part of the mass "
      "that a full body would give it follows a cell whose "
      "nodes all have more. Below 2^-dim corners of a block of "
      "full cells are fed. Default: 0.2 in 2D, 0.1 in 3D. "
      "Dimensionless, between 0 and 1.",
      this->prm,
      dealii::Patterns::Double());
  }

  template <int dim>
  void
  AggregationParameters<dim>::add_to(Effects<dim> &effects,
                                     FieldLayout  &layout) const
  {
    AssertThrow(mass_threshold > 0. && mass_threshold < 1.,
                ExcParameter(this->path(),
                             "Mass threshold",
                             shortest(mass_threshold),
                             "must lie between 0 and 1, both excluded. 0.1 to "
                             "0.3 is good."));
    effects.aggregation =
      std::make_unique<const Aggregation<dim>>(mass_threshold,
                                               layout["mass"],
                                               layout["reference_volume"]);
  }

  template <int dim>
  EffectCard
  AggregationParameters<dim>::card()
  {
    EffectCard card;
    card.enters  = "particles to grid: roots; constraints of all solves";
    card.couples = "the roots' nodes with those that their followers reach";
    card.ledger_columns = {"followers",
                           "free_starved",
                           "farthest_root",
                           "largest_weight"};
    return card;
  }

  template class AggregationParameters<2>;
  template class AggregationParameters<3>;
} // namespace emmy
