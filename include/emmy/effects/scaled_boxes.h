#ifndef emmy_effects_scaled_boxes_h
#define emmy_effects_scaled_boxes_h

#include <emmy/transfer/domain_update.h>

namespace emmy
{
  /**
   * The boxes of GIMP with mean dilatation: those of @p inner, scaled by
   * (theta/j)^(1/dim) at the end of a step. The own volume of a particle is
   * free within its cell and drifts; that of its box must not.
   * @param inner null: null
   */
  template <int dim>
  std::unique_ptr<DomainUpdate<dim>>
  with_mean_dilatation(std::unique_ptr<DomainUpdate<dim>> inner,
                       const std::string                 &name,
                       const FieldLayout                 &layout);
} // namespace emmy

#endif
