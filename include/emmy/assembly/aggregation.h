#ifndef emmy_assembly_aggregation_h
#define emmy_assembly_aggregation_h

#include <emmy/assembly/force_term.h>

namespace emmy
{
  /**
   * Section `Effects/Aggregation`. The effect has no force: it adds constraints
   * to the active grid, see Aggregation in transfer/aggregation.h.
   */
  template <int dim>
  class AggregationParameters : public EffectParameters<dim>
  {
  public:
    explicit AggregationParameters(const std::string &section);

    void
    add_to(Effects<dim> &effects, FieldLayout &layout) const override;

    static EffectCard
    card();

  private:
    double mass_threshold = dim == 2 ? 0.2 : 0.1; // theta
  };
} // namespace emmy

#endif
