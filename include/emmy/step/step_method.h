#ifndef emmy_step_step_method_h
#define emmy_step_step_method_h

#include <emmy/step/balance.h>
#include <emmy/step/small_cuts.h>
#include <emmy/step/step_rule.h>
#include <emmy/step/travel_limit.h>
#include <emmy/transfer/domain_update.h>
#include <emmy/transfer/middle_places.h>

namespace emmy
{
  /** What a step is made of, as the scene chose it; borrowed. */
  template <int dim>
  struct StepMethod
  {
    const ShapeFunctions<dim> &shape_functions; ///< of the scene
    const DomainUpdate<dim>   *domain_update;   ///< null: domains stay
    const PointMapping        &mapping;         ///< from particles to grid
    const StepRule<dim>       &step_rule;       ///< how large steps are
    const TravelLimit<dim>    *travel_limit;    ///< null: no limit
    const Balance<dim>        &balance;         ///< all forces
    const DiagnosisParameters &diagnosis;       ///< of small cuts
    /**
     * Where the grid is undeformed in the middle of a step; null: at its start.
     */
    const MiddlePlaces<dim> *middle = nullptr;
    /** How well places of the middle must hold, in cells. */
    double geometry_tolerance = 0.;
  };
} // namespace emmy

#endif
