#ifndef emmy_material_static_stress_h
#define emmy_material_static_stress_h

#include <emmy/material/stress_rules.h>

namespace emmy
{
  /**
   * The stress that static steps balance with the loads: P = Delta F S_1 at
   * the end of the step, the true nominal stress there. It conserves neither
   * energy nor, but for a body at rest, angular momentum. Not among the names
   * of the rules: steps in time have no use for it.
   */
  template <int dim>
  StressRule<dim>
  static_stress_rule();
} // namespace emmy

#endif
