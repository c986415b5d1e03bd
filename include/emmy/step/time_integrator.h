#ifndef emmy_step_time_integrator_h
#define emmy_step_time_integrator_h

#include <emmy/effects/step_report.h>
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
    const ShapeFunctions<dim> &shape_functions;
    const DomainUpdate<dim>   *domain_update; ///< null: domains stay
    const PointMapping        &mapping;
    const StepRule<dim>       &step_rule;
    const TravelLimit<dim>    *travel_limit; ///< null: no limit
    const Balance<dim>        &balance;
    const DiagnosisParameters &diagnosis;
    /**
     * Where the grid is undeformed in the middle of a step; null: at its start.
     */
    const MiddlePlaces<dim> *middle = nullptr;
    /** How well places of the middle must hold, in cells. */
    double geometry_tolerance = 0.;
  };

  /**
   * Advances the particles step by step: implicit (Stepper) or explicit
   * (ExplicitStepper). Owned by the scene; the run loop and the output know no
   * more of it than this.
   */
  template <int dim>
  class TimeIntegrator
  {
  public:
    virtual ~TimeIntegrator() = default;

    /** The state before the first step, as row 0 of the ledger. Collective. */
    virtual StepReport
    initial_report() = 0;

    /**
     * One step. Throws ExcRun on all ranks, with the particles as they were,
     * if it cannot be done. Collective.
     */
    virtual StepReport
    advance() = 0;

    /** The linear solver in use, for the log. */
    virtual std::string
    solver_name() const = 0;

    /** Active nodes and their velocity as the last step found them. */
    virtual const GridStart<dim> &
    grid_start() const = 0;

    /** Velocity of those nodes at the end of the last step, m/s. */
    virtual const Vector &
    grid_velocity() const = 0;

    /** Lumped mass of the local nodes in the last step, kg. Collective. */
    virtual std::vector<double>
    nodal_mass() const = 0;

    /** What was found in the last step; null unless it was asked for. */
    virtual const StepDiagnosis<dim> *
    diagnosis() const = 0;
  };
} // namespace emmy

#endif
