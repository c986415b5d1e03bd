#ifndef emmy_step_stepper_h
#define emmy_step_stepper_h

#include <emmy/solve/newton.h>
#include <emmy/step/accounts.h>
#include <emmy/step/domains_of_step.h>
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
      std::unique_ptr<StepEquation<dim>>      equation;
      NewtonResult                            newton;
      double                                  time_step;
      unsigned int                            halvings    = 0;
      bool                                    leaves_grid = false;
      Vector                                  displacement, velocity;
      typename BoundaryConditions<dim>::Sides wall_travel{};
      std::vector<std::string>                notes, findings;
    };

    /** For the rates in the table of phases. */
    void
    count_points(const std::size_t n_points, const std::size_t n_evaluations);
    StepSize
    next_step_size(const Stencils<dim>    &stencils,
                   const PointArrays<dim> &points) const;
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
    examine(const Stencils<dim>    &stencils,
            const PointArrays<dim> &points,
            Solution               &solution);
    /** A line for the log if starved nodes are worse off than ever before. */
    void
    tell_of_followers(Solution &solution);
    /**
     * What examine() found, zero before the first step; of followers; and what
     * probes find at points whose states are those at @p time. Collective.
     */
    std::vector<StepMeasure>
    measures(const PointArrays<dim> &points, const double time) const;
    /** Whether the matrices are small enough to look for a small cut. */
    bool
    can_diagnose() const;
    /** Say why the step fails at its smallest size. Throws on all ranks. */
    void
    give_up(const StepData<dim> &step, Solution &solution) const;
    Solution
    solve(const Stencils<dim> &stencils, const PointArrays<dim> &points);
    /** A short line for the screen, and a long one for the log. */
    void
    tell(Solution &solution, const std::string &what, const std::string &why);
    /** What helps most often where Newton struggles; if it is not used yet. */
    std::string
    remedy() const;
    /**
     * Positions and velocities at the end of a solved step, in its trial
     * states. Where a particle leaves the grid the step has not converged.
     */
    void
    move(const Stencils<dim>    &stencils,
         const PointArrays<dim> &points,
         Solution               &solution);
    /** Trial states of an accepted solution: domains. */
    void
    follow(const Stencils<dim>    &stencils,
           const PointArrays<dim> &points,
           Solution               &solution);
    StepReport
    report(const Solution         &solution,
           const Stencils<dim>    &stencils,
           const PointArrays<dim> &points) const;
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
    std::unique_ptr<LinearSolver> linear_solver;
    const GridStart<dim>         *start = nullptr;
    Vector                        velocity;
    /** Null unless asked for, and before the first step. */
    std::unique_ptr<StepDiagnosis<dim>> findings;
    /** Of all steps. */
    std::uint64_t most_free_starved  = 0;
    double        largest_weight     = 0.;
    bool          has_limited_travel = false, has_struggled = false;
    /** How far walls have moved, m. */
    typename BoundaryConditions<dim>::Sides wall_travel{};
    unsigned int                            step_number = 0;
    double                                  time        = 0.;
  };
} // namespace emmy

#endif
