#ifndef emmy_step_stepper_h
#define emmy_step_stepper_h

#include <emmy/solve/newton.h>
#include <emmy/step/accounts.h>
#include <emmy/step/middle_equation.h>
#include <emmy/step/time_integrator.h>

namespace emmy
{
  /**
   * The implicit step: particles -> grid -> solve -> particles. Owned by the
   * scene; borrows all it is given.
   */
  template <int dim>
  class Stepper : public TimeIntegrator<dim>
  {
  public:
    /** Of a scene and its state. */
    Stepper(const StepSetting<dim> &setting,
            const SolverParameters &solver_parameters,
            RunState<dim>          &state);

    /**
     * One step. A step that does not converge leaves no trace and is tried
     * again with half its size; so is one in which a particle would leave the
     * grid. Collective.
     *
     * Throws ExcRun on all ranks, with the particles as they were, if the
     * step converges at no allowed size, or a particle leaves the grid in all
     * of them.
     */
    StepReport
    advance() override;

    std::string
    solver_name() const override
    {
      return linear_solver ? linear_solver->name() : "none yet";
    }
    /** Mass and momentum too. */
    const GridStart<dim> &
    grid_start() const override
    {
      return *start;
    }
    const Vector &
    grid_velocity() const override
    {
      return velocity;
    }
    std::vector<double>
    nodal_mass() const override;
    const StepDiagnosis<dim> *
    diagnosis() const override
    {
      return findings.get();
    }

  private:
    using Base = TimeIntegrator<dim>;
    using Base::accept;
    using Base::failure;
    using Base::setting;
    using Base::state;
    using Base::timed;
    using Base::where;

    /** A solved step that is not yet written to the particles. */
    struct Solution
    {
      /** One of both: places of the start or of the middle. */
      std::unique_ptr<Ground<dim>>         at_start;
      std::unique_ptr<MiddleEquation<dim>> in_middle;
      std::unique_ptr<StepEquation<dim>>   of_start;

      NewtonResult             newton;
      double                   time_step   = 0.;
      unsigned int             halvings    = 0;
      bool                     leaves_grid = false;
      Vector                   displacement, velocity;
      std::vector<std::string> notes, findings;

      const Ground<dim> &
      ground() const
      {
        return in_middle ? in_middle->ground() : *at_start;
      }
      StepEquation<dim> &
      equation() const
      {
        return in_middle ? in_middle->equation() : *of_start;
      }
    };

    /** Solve the step, with halvings, as the method wants it. */
    Solution
    solve();
    /** The size of the step by the method's rule; notes what limits it. */
    void
    choose_size(Solution &solution);
    /** The size of a step whose grid is undeformed in its middle. */
    StepSize
    size_in_middle();
    /** What is fixed while a step from a ground is solved. */
    StepData<dim>
    data_of(const Ground<dim>    &ground,
            const GridStart<dim> &start,
            const double          time_step) const;
    /** Solve the step of a size; again where an effect has missed something. */
    void
    try_size(Solution &solution);
    /** One try with the geometry of the start, or of the middle. */
    void
    try_from_start(Solution &solution);
    void
    try_in_middle(Solution &solution);
    void
    velocity_from_momentum(const Ground<dim> &ground, GridStart<dim> &start);
    /**
     * Positions and velocities at the end of a solved step, in its trial
     * states. Where a particle leaves the grid the step has not converged.
     */
    void
    move(Solution &solution);
    /** Trial states of an accepted solution: domains, and the next middle. */
    void
    follow(Solution &solution);
    /** What was done, and what the detector finds in it. Collective. */
    StepReport
    report(const Solution &solution);

    const ActiveGrid<dim> &
    renew_grid(const Ground<dim> &ground) override;
    std::vector<EnergyEntry>
    energy_entries() const override;
    /** Conditions of matrices, and what the middle leaves, too. */
    void
    add_measures(const PointArrays<dim>   &points,
                 const double              time,
                 std::vector<StepMeasure> &measures) override;

    /** Estimate the conditions of both matrices of a solved step. */
    void
    examine(Solution &solution);
    /** A short line for the screen, and a long one for the log. */
    void
    tell(Solution &solution, const std::string &what, const std::string &why);
    /** That places did not settle: once on the screen, always in the log. */
    void
    tell_of_held_places(Solution &solution);

    // what can be made again
    const SolverParameters       &solver_parameters;
    ParticlesToGrid<dim>          particles_to_grid;
    std::unique_ptr<LinearSolver> linear_solver;
    const GridStart<dim>         *start = nullptr;
    Vector                        velocity;
    /** Null unless asked for, and before the first step. */
    std::unique_ptr<StepDiagnosis<dim>> findings;
    /** Of the last step's middle: see MiddleEquation. */
    dealii::Tensor<1, 3> angular_momentum_left;
    double               place_defect = 0.;
  };
} // namespace emmy

#endif
