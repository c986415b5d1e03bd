#ifndef emmy_step_balance_h
#define emmy_step_balance_h

#include <emmy/base/phases.h>
#include <emmy/effects/effect.h>

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
    /** The same with trial states of an equation of the same points. */
    std::unique_ptr<StepEquation<dim>>
    over(const StepData<dim> &step, PointArrays<dim> trial_states) const;

    /**
     * Write the initial fields of the effects to particles that were just
     * filled. Collective; throws on all ranks.
     * @return what was chosen, in words, for the log
     */
    std::vector<std::string>
    mark(const BackgroundGrid<dim>               &grid,
         dealii::Particles::ParticleHandler<dim> &particles) const;

    /** The map from momentum to velocity, an effect's or that of the method. */
    VelocityMap<dim> &
    velocity_map() const;
    /** Whether an effect has brought it. */
    bool
    has_own_map() const;

    /** Whether fixed unknowns move. */
    bool
    gives_motion() const;
    /**
     * The velocity of fixed unknowns at a time, m/s; zero elsewhere.
     * Collective.
     */
    Vector
    given_velocity(const ActiveGrid<dim> &active,
                   const double           time,
                   Phases                *phases) const;
    /** Add their displacement over a step, m. Collective. */
    void
    add_given_displacement(const ActiveGrid<dim> &active,
                           const double           time,
                           const double           time_step,
                           Vector                &displacement,
                           Phases                *phases) const;
    /** The column of the work of what holds fixed unknowns; empty: none. */
    std::string
    reaction_work() const;

    /** See Effect::see_reactions(). */
    void
    see_reactions(const ActiveGrid<dim> &active, const Vector &force) const;

    /** The velocity fields of the bodies, one or as an effect chooses. */
    VelocityFields
    velocity_fields() const
    {
      return VelocityFields(effects.field_of_body);
    }

    /** What any effect misses in a solved step, see Effect::missing(). */
    std::string
    missing(const StepData<dim> &step, const Vector &displacement) const;

    /** See Effect::check_step() and end_step(). */
    void
    check_step(const double       time,
               const double       time_step,
               const std::string &where) const;
    /** Effects take note that a step is accepted. */
    void
    end_step(const double time, const double time_step) const;

    /** What effects measure. Collective. */
    std::vector<StepMeasure>
    measures(const PointArrays<dim>    &points,
             const double               time,
             const BackgroundGrid<dim> &grid,
             Phases                    *phases) const;

    /** What each effect remembers: see Effect::memory(). */
    std::vector<std::vector<double>>
    memory() const;

    /** @param parts as memory() gave them, in the order of Effect::recall() */
    void
    recall(const std::vector<std::vector<std::vector<double>>> &parts) const;

    /** Whether there is an effect of this name. */
    bool
    has(const std::string &effect) const;

    /** Whether there is a load in any step. */
    bool
    has_loads() const;

    /** Whether any effect does, see Effect::couples_by_weights(). */
    bool
    couples_by_weights() const;

    /**
     * Where points reach the nodes of before: see NodeCoupling::take_weights().
     * @return whether all couplings stay. Collective
     */
    bool
    take_weights(const Stencils<dim>       &stencils,
                 const BackgroundGrid<dim> &grid,
                 Phases                    *phases) const;

    /** States that effects keep: see Effect::follow(). */
    void
    follow(const Stencils<dim>       &stencils,
           const PointArrays<dim>    &points,
           const ActiveGrid<dim>     &active,
           const std::vector<double> &displacement,
           PointArrays<dim>          &trial) const;

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

    /** What effects show beside the particles, see Effect::surfaces(). */
    std::vector<Surface<dim>>
    surfaces(const double              time,
             const dealii::Point<dim> &lower,
             const dealii::Point<dim> &upper) const;

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

    /** Give entries what they are before the first step. Collective. */
    void
    set_energies_at_start(const PointArrays<dim>   &points,
                          const double              time,
                          const MPI_Comm            communicator,
                          std::vector<EnergyEntry> &entries) const;

    /** Entries of the ledger that terms and loads bring, all zero. */
    std::vector<EnergyEntry>
    energy_entries() const;

  private:
    friend class StepEquation<dim>;
    /**
     * Call a hook of each term that has it, its time booked to its effect.
     * @param has a member function of Effect
     */
    template <class Has, class Hook>
    void
    for_each(Phases *phases, const Has has, Hook hook) const;

    const Effects<dim>                effects;
    std::unique_ptr<VelocityMap<dim>> map_of_method;
    VelocityMap<dim>                 *map; ///< in use
  };

  template <int dim>
  template <class Has, class Hook>
  void
  Balance<dim>::for_each(Phases *phases, const Has has, Hook hook) const
  {
    for (std::size_t i = 0; i < effects.terms.size(); ++i)
      {
        Effect<dim> &effect = *effects.terms[i];
        if (!(effect.*has)())
          continue;
        const auto timed = effect_scope(phases, effects.term_names[i]);
        hook(effect);
      }
  }
} // namespace emmy

#endif
