#ifndef emmy_effects_aggregation_card_h
#define emmy_effects_aggregation_card_h

#include <emmy/base/effect_card.h>

namespace emmy
{
  /**
   * What `Method/Starved nodes` = follow costs. It has no force: it adds
   * constraints to the active grid, see Aggregation in transfer/aggregation.h.
   */
  EffectCard
  aggregation_card(const bool is_present);
} // namespace emmy

#endif
