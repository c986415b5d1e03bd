#ifndef emmy_step_stepper_h
#define emmy_step_stepper_h

#include <emmy/assembly/balance.h>
#include <emmy/assembly/step_report.h>
#include <emmy/solve/newton.h>
#include <emmy/step/accounts.h>
#include <emmy/step/doctor.h>
#include <emmy/step/step_rule.h>
#include <emmy/transfer/domain_update.h>
#include <emmy/transfer/grid_to_particles.h>

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
    /** How far a particle may move in a step, in cells; 0: no limit. */
    const double               maximum_travel;
    const Balance<dim>        &balance;
    const DiagnosisParameters &diagnosis;
  };

  /**
   * Advances the particles by one step: particles -> grid -> solve ->
   * particles. Owned by the scene; borrows all it is given.
   */
  template <int dim>
  class Stepper
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

    /** The state before the first step, as row 0 of the ledger. Collective. */
    StepReport
    initial_report();

    /**
     * One step. A step that does not converge leaves no trace and is tried
     * again with half its size. Collective.
     *
     * Throws ExcRun on all ranks, with the particles as they were, if the
     * step converges at no allowed size, or a particle would leave the grid.
     */
    StepReport
    advance();

    /** The linear solver in use, for the log. */
    std::string
    solver_name() const;

    /** Active nodes, mass and momentum as the last step found them. */
    const GridStart<dim> &
    grid_start() const;

    /** Velocity of those nodes at the end of the last step, m/s. */
    const Vector &
    grid_velocity() const;

    /** What was found in the last step; null unless it was asked for. */
    const StepDiagnosis<dim> *
    diagnosis() const;

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
      std::unique_ptr<StepEquation<dim>> equation;
      NewtonResult                       newton;
      double                             time_step;
      unsigned int                       halvings = 0;
      Vector                             displacement, velocity;
      std::vector<std::string>           notes, findings;
    };

    /** For the rates in the table of phases. */
    void
    count_points(const std::size_t n_points, const std::size_t n_evaluations);
    /** @param note what shortens it, if worth a line; null: not wanted */
    double
    next_time_step(const Stencils<dim>    &stencils,
                   const PointArrays<dim> &points,
                   std::string            *note) const;
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
    /** Trial states of an accepted solution: positions, velocities, domains. */
    void
    move(const Stencils<dim>    &stencils,
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
    std::unique_ptr<LinearSolver> linear_solver;
    const GridStart<dim>         *start = nullptr;
    Vector                        velocity;
    /** Null unless asked for, and before the first step. */
    std::unique_ptr<StepDiagnosis<dim>> findings;
    std::uint64_t most_cut_domains = 0; ///< when last told
    /** Of all steps. */
    std::uint64_t most_free_starved  = 0;
    double        largest_weight     = 0.;
    bool          has_limited_travel = false;
    unsigned int  step_number        = 0;
    double        time               = 0.;
  };
} // namespace emmy

#endif
