#ifndef emmy_step_time_integrator_h
#define emmy_step_time_integrator_h

#include <emmy/step/detector.h>
#include <emmy/step/run_state.h>
#include <emmy/step/step_size.h>

namespace emmy
{
  /** What a step works on and with; borrowed. */
  template <int dim>
  struct StepSetting
  {
    BackgroundGrid<dim>           &grid;                ///< of the scene
    const BoundaryConditions<dim> &boundary_conditions; ///< of the scene
    const FieldLayout             &layout; ///< what particles carry
    const StepMethod<dim>          method; ///< how a step is made
    const TimeParameters          &limits; ///< end time and halvings
    Phases                        &phases; ///< where the time goes
  };

  /** A try of a step that was not accepted. */
  struct FailedTry
  {
    double              time_step; ///< s
    std::vector<double> residuals; ///< |r| of Newton's iterations, N
    std::string         problem;   ///< in words
  };

  /** What is known of a step that could not be made; same on all ranks. */
  struct FailureRecord
  {
    std::vector<FailedTry> tries; ///< of this step
    /** Where its matrix is weakest, in words; empty: it was not examined. */
    std::string weakest;
  };

  /**
   * Advances a run step by step: implicit (Stepper) or explicit
   * (ExplicitStepper). What both share is here: how a step begins, and how it
   * is accepted. Owned by the scene; the run loop and the output know no more
   * of it than the public part. What one step hands to the next is in the
   * RunState; the rest is cache.
   */
  template <int dim>
  class TimeIntegrator
  {
  public:
    /** Borrows the state. */
    TimeIntegrator(const StepSetting<dim> &setting,
                   RunState<dim>          &state,
                   const RemediesInUse    &in_use);
    virtual ~TimeIntegrator() = default;

    /** The state before the first step, as row 0 of the ledger. Collective. */
    StepReport
    initial_report();

    /**
     * How far stresses and loads of now are from balance, see
     * start_imbalance(). Collective.
     */
    double
    imbalance();

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

    /** Of the step that advance() was last called for. */
    const FailureRecord &
    last_failure() const
    {
      return failure;
    }

  protected:
    /** Call @p stage and book its time under @p phase. */
    template <class Stage>
    decltype(auto)
    timed(const char *phase, Stage &&stage)
    {
      const auto scope = setting.phases.scope(phase);
      return stage();
    }

    /** For LU: contact couples many nodes that then do not meet. */
    EmptyPairs
    empty_pairs() const
    {
      return setting.method.balance.couples_by_weights() ? EmptyPairs::left_out
                                                         : EmptyPairs::kept;
    }
    /** "Step 3 from t = 0.2 s": the step that comes next. */
    std::string
    where() const;
    /** Stencils and states of the particles where they are. */
    Ground<dim>
    ground_at_start();
    /** The note of a size, the first time that there is one. */
    void
    note_limit(const StepSize &size, std::vector<std::string> &notes);
    /**
     * Write what effects keep and, where there are any, the domains at t + dt
     * to @p trial. Throws ExcRun on all ranks if one vanishes. Collective.
     *
     * @param displacement of the step at the local nodes, [dim * node + c], m
     */
    void
    follow_domains(const Ground<dim>         &ground,
                   const ActiveGrid<dim>     &active,
                   const std::vector<double> &displacement,
                   PointArrays<dim>          &trial,
                   std::vector<std::string>  &notes);
    /** The report of a step at whose end the particles are in trial states. */
    StepReport
    begin_report(const double time_step, const PointArrays<dim> &trial) const;
    /**
     * Add to a report what the detector finds, what is measured, and the size
     * of the active grid. Collective.
     * @param hidden kinetic energy that the grid does not see at t, J
     */
    void
    end_report(const Ground<dim>      &ground,
               const PointArrays<dim> &trial,
               const ActiveGrid<dim>  &active,
               const double            hidden,
               StepReport             &report);
    /** Grid to particles, and the next state of the run. Collective. */
    void
    accept(const Ground<dim>      &ground,
           const PointArrays<dim> &trial,
           const StepReport       &report);

    /** The active grid of the particles as they are. Collective. */
    virtual const ActiveGrid<dim> &
    renew_grid(const Ground<dim> &ground) = 0;
    /** All entries of a step, with no change. */
    virtual std::vector<EnergyEntry>
    energy_entries() const = 0;
    /** What effects measure; an integrator may add its own. Collective. */
    virtual void
    add_measures(const PointArrays<dim>   &points,
                 const double              time,
                 std::vector<StepMeasure> &measures);

    const StepSetting<dim> setting; ///< references to the scene
    RunState<dim>         &state;   ///< what steps change
    FailureRecord          failure; ///< of the last step

  private:
    static void
    add_size(const ActiveGrid<dim> &active, StepReport &report);

    Detector detector;
  };
} // namespace emmy

#endif
