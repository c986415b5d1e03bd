#ifndef emmy_step_static_stepper_h
#define emmy_step_static_stepper_h

#include <emmy/solve/newton.h>
#include <emmy/step/step_equation.h>
#include <emmy/step/time_integrator.h>

namespace emmy
{
  /** What static steps cost, and their column. */
  EffectCard
  static_card(const bool is_present);

  /**
   * Static steps: where forces balance, without inertia. Loads are raised from
   * zero to what they are in `Time/Increments` equal increments of the end
   * time, which only counts them. In each, Newton finds the displacement with
   * which the stress at the end, in the places of the particles at the start,
   * balances the loads at the end.
   *
   * The grid then begins anew at the new places, and there the stress is a bit
   * out of balance again. The next increment takes that up; after the last one
   * the loads are held until the stress balances them in the new grid too,
   * which takes a few solves. So the state at the end is at rest for a run that
   * starts from it, whatever its Method/Geometry.
   *
   * Works are those of the mean of the forces at both ends of an increment:
   * load_work is the integral over the path to second order. What the stress
   * works so, less what is stored and dissipated, is stress_rule_loss, of third
   * order; what was out of balance at the start of an increment works
   * imbalance_work.
   *
   * An increment that fails is halved; later ones grow back. Owned by the
   * scene; borrows all it is given.
   */
  template <int dim>
  class StaticStepper : public TimeIntegrator<dim>
  {
  public:
    /** Of a scene and its state. */
    StaticStepper(const StepSetting<dim> &setting,
                  const SolverParameters &solver_parameters,
                  RunState<dim>          &state);

    /**
     * One increment; with the last one all that follows. Throws ExcRun on all
     * ranks, with the particles as they were, if nothing holds the bodies, if
     * they move, or if the increment converges at no allowed size. Collective.
     */
    StepReport
    advance() override;

    std::string
    solver_name() const override
    {
      return linear_solver ? linear_solver->name() : "none yet";
    }
    const GridStart<dim> &
    grid_start() const override
    {
      return *start;
    }
    /** Zero. */
    const Vector &
    grid_velocity() const override
    {
      return start->velocity;
    }
    std::vector<double>
    nodal_mass() const override;
    const StepDiagnosis<dim> *
    diagnosis() const override
    {
      return nullptr;
    }

  private:
    using Base = TimeIntegrator<dim>;
    using Base::failure;
    using Base::setting;
    using Base::state;
    using Base::where;

    /** An increment that is being solved, or was; its equation borrows. */
    struct Increment
    {
      Ground<dim>                        ground;
      std::unique_ptr<StepEquation<dim>> equation;
      double                             time      = 0.; ///< where it begins, s
      double                             time_step = 0.;
      LoadRamp                           ramp;
      Vector       load_before;     ///< that was balanced before, N
      Vector       residual_before; ///< of the state at its start, N
      Vector       displacement;
      NewtonResult newton;
      unsigned int halvings    = 0;
      bool         leaves_grid = false;
      bool         is_held     = false; ///< what is given does not move on
    };

    /** Stencils, states and grid where the particles are. */
    std::unique_ptr<Increment>
    begin();
    /**
     * The equation with the loads' factor going from @p from to @p to, and
     * what is out of balance before. False if it has no meaning.
     */
    bool
    prepare(Increment   &increment,
            const double from,
            const double to,
            const double time_step);
    void
    solve(Increment &increment);
    /** With halvings; the time step is that of the increment. */
    std::unique_ptr<Increment>
    raise_loads();
    /** Write to the particles. @param passed time that goes by, s */
    StepReport
    accept_increment(Increment &increment, const double passed);
    /** Hold the loads until all is in balance in the grid of the end. */
    void
    settle(StepReport &report);

    /** The part of the loads that acts at a time. */
    double
    factor_at(const double time) const;
    /** Throws ExcRun. Collective. */
    void
    refuse_what_moves(const Increment &increment) const;

    const ActiveGrid<dim> &
    renew_grid(const Ground<dim> &ground) override;
    std::vector<EnergyEntry>
    energy_entries() const override;

    const SolverParameters       &solver_parameters;
    ParticlesToGrid<dim>          particles_to_grid;
    std::unique_ptr<LinearSolver> linear_solver;
    GridStart<dim>               *start = nullptr;
  };
} // namespace emmy

#endif
