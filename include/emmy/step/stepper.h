#ifndef emmy_step_stepper_h
#define emmy_step_stepper_h

#include <emmy/solve/newton.h>
#include <emmy/step/accounts.h>
#include <emmy/step/detector.h>
#include <emmy/step/domains_of_step.h>
#include <emmy/step/middle_equation.h>
#include <emmy/step/step_size.h>
#include <emmy/transfer/grid_to_particles.h>

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
    Stepper(BackgroundGrid<dim>                     &grid,
            const BoundaryConditions<dim>           &boundary_conditions,
            const FieldLayout                       &layout,
            const StepMethod<dim>                   &method,
            const SolverParameters                  &solver_parameters,
            const TimeParameters                    &time_parameters,
            dealii::Particles::ParticleHandler<dim> &particles,
            Phases                                  &phases);

    StepReport
    initial_report() override;

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
    solver_name() const override;
    /** Mass and momentum too. */
    const GridStart<dim> &
    grid_start() const override;
    const Vector &
    grid_velocity() const override;
    std::vector<double>
    nodal_mass() const override;
    const StepDiagnosis<dim> *
    diagnosis() const override;

  private:
    /** Call @p stage and book its time under @p phase. */
    template <class Stage>
    decltype(auto)
    timed(const char *phase, Stage &&stage)
    {
      const auto scope = phases.scope(phase);
      return stage();
    }

    /** A solved step that is not yet written to the particles. */
    struct Solution
    {
      /** One of both: places of the start or of the middle. */
      std::unique_ptr<Ground<dim>>         at_start;
      std::unique_ptr<MiddleEquation<dim>> in_middle;
      std::unique_ptr<StepEquation<dim>>   of_start;

      NewtonResult                            newton;
      double                                  time_step;
      unsigned int                            halvings    = 0;
      bool                                    leaves_grid = false;
      Vector                                  displacement, velocity;
      typename BoundaryConditions<dim>::Sides wall_travel{};
      std::vector<std::string>                notes, findings;

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

    /** For the rates in the table of phases. */
    void
    count_points(const std::size_t n_points, const std::size_t n_evaluations);
    void
    velocity_from_momentum(const Stencils<dim>    &stencils,
                           const PointArrays<dim> &points,
                           GridStart<dim>         &start);
    Diagnosis<dim>
    diagnose_matrix(const Matrix           &matrix,
                    const Stencils<dim>    &stencils,
                    const PointArrays<dim> &points) const;
    /** Estimate the conditions of both matrices of a solved step. */
    void
    examine(Solution &solution);
    /**
     * What examine() found, zero before the first step; of followers; and what
     * probes find at points whose states are those at @p time. Collective.
     */
    void
    add_measures(const PointArrays<dim>   &points,
                 const double              time,
                 std::vector<StepMeasure> &measures) const;
    /** Whether the matrices are small enough to look for a small cut. */
    bool
    can_diagnose() const;
    /** Say why the step fails at its smallest size. Throws on all ranks. */
    void
    give_up(const StepData<dim> &step, Solution &solution) const;
    /** The size of a step whose grid is undeformed in its middle. */
    StepSize
    size_in_middle();
    /** Stencils and states of the particles where they are. */
    Ground<dim>
    ground_at_start();
    /** Solve the step, with halvings, as the method wants it. */
    Solution
    solve();
    /** One try with the geometry of the start, or of the middle. */
    void
    try_from_start(Solution &solution);
    void
    try_in_middle(Solution &solution);
    /** The size of the step by the method's rule; notes what limits it. */
    void
    choose_size(Solution &solution);
    /** The displacements of moving walls, with what is checked of them. */
    typename BoundaryConditions<dim>::Sides
    move_walls(Solution &solution) const;
    /** A short line for the screen, and a long one for the log. */
    void
    tell(Solution &solution, const std::string &what, const std::string &why);
    /** That places did not settle: once on the screen, always in the log. */
    void
    tell_of_held_places(Solution &solution);
    /** What helps most often where Newton struggles; if it is not used yet. */
    std::string
    remedy() const;
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
    /** What is left of the particles' angular momentum, and of the places. */
    void
    add_geometry_measures(const Solution           &solution,
                          std::vector<StepMeasure> &measures) const;
    /** Those accounts that the method can make differ from zero. */
    std::vector<EnergyEntry>
    account_entries(const StepAccounts &accounts) const;
    std::string
    where() const;

    BackgroundGrid<dim>                     &grid;
    const BoundaryConditions<dim>           &boundary_conditions;
    const FieldLayout                       &layout;
    const StepMethod<dim>                    method;
    const SolverParameters                  &solver_parameters;
    const TimeParameters                    &limits;
    dealii::Particles::ParticleHandler<dim> &particles;
    Phases                                  &phases;

    ParticlesToGrid<dim>          particles_to_grid;
    DomainsOfStep<dim>            domains;
    Detector                      detector;
    std::unique_ptr<LinearSolver> linear_solver;
    const GridStart<dim>         *start = nullptr;
    Vector                        velocity;
    /** Null unless asked for, and before the first step. */
    std::unique_ptr<StepDiagnosis<dim>> findings;
    bool has_limited_travel = false, has_struggled = false,
         has_held_places = false;
    /** How far walls have moved, m. */
    typename BoundaryConditions<dim>::Sides wall_travel{};
    unsigned int                            step_number = 0;
    double                                  time        = 0.;
  };
} // namespace emmy

#endif
