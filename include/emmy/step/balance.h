#ifndef emmy_step_balance_h
#define emmy_step_balance_h

#include <emmy/effects/effect.h>
#include <emmy/solve/nonlinear_equation.h>

namespace emmy
{
  template <int dim>
  class StepEquation;

  /**
   * The balance of momentum: the sum of the terms that are present, minus the
   * loads. Owned by the scene; over() makes the equation of one step.
   */
  template <int dim>
  class Balance
  {
  public:
    /** @param effects inertia and internal force among its terms */
    explicit Balance(Effects<dim> effects);

    /** The equation of a step; borrows both. Collective. */
    std::unique_ptr<StepEquation<dim>>
    over(const StepData<dim> &step) const;

    /**
     * Write the initial fields of the effects to particles that were just
     * filled. Collective; throws on all ranks.
     * @return what was chosen, in words, for the log
     */
    std::vector<std::string>
    mark(const BackgroundGrid<dim>               &grid,
         dealii::Particles::ParticleHandler<dim> &particles) const;

    /** What effects measure. Collective. */
    std::vector<StepMeasure>
    measures(const PointArrays<dim>    &points,
             const double               time,
             const BackgroundGrid<dim> &grid,
             Phases                    *phases) const;

    /** Whether there is an effect of this name. */
    bool
    has(const std::string &effect) const;

    /** Whether there is a load in any step. */
    bool
    has_loads() const;

    /** Once in a step: see Effect::classify(). Collective. */
    void
    classify(const Stencils<dim>       &stencils,
             const PointArrays<dim>    &points,
             const BackgroundGrid<dim> &grid,
             Phases                    *phases) const;

    /** What effects add to the grid of these stencils. Collective. */
    Couplings<dim>
    couplings(const Stencils<dim>           &stencils,
              const BackgroundGrid<dim>     &grid,
              const BoundaryConditions<dim> &boundary_conditions,
              Phases                        *phases) const;

    /**
     * Delta v . G Delta v / 2 for each effect that has a mass G of its own, J.
     * Collective.
     * @param change Delta v, m/s
     */
    std::vector<EnergyEntry>
    mass_losses(const ActiveGrid<dim> &active,
                const Vector          &change,
                Phases                *phases) const;
    /** The same entries with no change. */
    std::vector<EnergyEntry>
    mass_loss_entries() const;

    /** Lines for the log, of an accepted step. Collective. */
    std::vector<std::string>
    findings() const;

    /**
     * This rank's share of the loads of a step at the local nodes, [dim * node
     * + c], N; empty if there are no loads.
     */
    std::vector<double>
    loads(const StepData<dim> &step) const;

    /**
     * The same loads on the points, [dim * p + c], N; empty if there are none.
     */
    std::vector<double>
    point_forces(const StepData<dim> &step) const;

    /** Entries of the ledger that terms and loads bring, all zero. */
    std::vector<EnergyEntry>
    energy_entries() const;

  private:
    friend class StepEquation<dim>;
    /** Call a hook of each term, its time booked to its effect. */
    template <class Hook>
    void
    for_each(Phases *phases, bool (Effect<dim>::*has)() const, Hook hook) const;

    const Effects<dim> effects;
  };

  /** r(u) of one step. Keeps the trial states that belong to the last u. */
  template <int dim>
  class StepEquation : public NonlinearEquation
  {
  public:
    StepEquation(const Balance<dim> &balance, const StepData<dim> &step);

    bool
    evaluate(const Vector &solution, const bool with_jacobian) override;
    const Vector &
    residual() const override;
    /** With the share of places that follow. */
    const Vector &
    reduced_residual() const override;
    Matrix &
    jacobian() override;
    void
    expand(Vector &increment) const override;
    double
    scale() const override;
    double
    work_scale() const override;
    /**
     * The largest norm of a displacement gradient at a particle; where it is
     * surely below 0.1, an upper bound.
     */
    double
    size(const Vector &increment) const override;
    const std::string &
    problem() const override;

    /**
     * In the middle of the step the residual is found from the momentum, and
     * the velocity v_t is found once Newton has ended: make the residual, with
     * what it leaves on fixed unknowns, that of v_t.
     */
    void
    set_velocity_at_start();

    /** What this equation was made over. */
    const StepData<dim> &
    data() const;

    /** The residual before constraints: the reactions on fixed unknowns. */
    const Vector &
    unconstrained_residual() const;

    /** The loads of the step, N. */
    const Vector &
    load() const;

    /** Particle states that belong to the last evaluation. */
    PointArrays<dim> &
    trial();
    const PointArrays<dim> &
    trial() const;

    /** The entries of the accepted step, summed over the ranks. Collective. */
    std::vector<EnergyEntry>
    energies(const Vector &solution) const;

  private:
    const Balance<dim> &balance;
    const StepData<dim> step;
    Vector           external_force, full_residual, free_residual, with_places;
    Matrix           tangent;
    PointArrays<dim> trial_states;
    double           force_scale = 0., total_work = 0.;
    std::string      found;
  };
} // namespace emmy

#endif
