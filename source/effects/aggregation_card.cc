#include <emmy/effects/aggregation_card.h>
#include <emmy/transfer/aggregation.h>

namespace emmy
{
  EffectCard
  aggregation_card(const bool is_present)
  {
    EffectCard card;
    card.name       = aggregation_effect;
    card.setting    = "Method/Starved nodes = follow";
    card.is_present = is_present;
    card.enters     = "particles to grid: roots; constraints of all solves";
    card.couples    = "the roots' nodes with those that their followers reach";
    card.ledger_columns = {"followers",
                           "free_starved",
                           "farthest_root",
                           "largest_weight",
                           "class_changes"};
    return card;
  }
} // namespace emmy
