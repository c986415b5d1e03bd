#ifndef emmy_effects_velocity_map_h
#define emmy_effects_velocity_map_h

#include <emmy/effects/step_accounts.h>
#include <emmy/transfer/particles_to_grid.h>

#include <functional>
#include <utility>

namespace emmy
{
  template <int dim>
  struct StepData;

  /**
   * How the momentum of the particles becomes the velocity of the grid,
   * M~ v = p (Pretti et al. 2023, eq. 26), and what this does to the energy.
   * This is the map of the method: it knows the essential conditions, and the
   * particles' change counts from its velocity. An effect may bring another,
   * see Effect::velocity_map(). Owned by the balance or an effect.
   */
  template <int dim>
  class VelocityMap
  {
  public:
    /** What is done with the grid's conditions. */
    using Conditions = typename NodalMatrix<dim>::Conditions;
    /**
     * Solves M~ v = p to round-off, from v on; false: it was not solved.
     * Collective.
     * @param conditions whether the essential ones, and those of followers,
     *   are in force
     */
    using Solve = std::function<bool(const Conditions conditions, Vector &v)>;

    virtual ~VelocityMap() = default;

    /**
     * Set start.velocity. Collective.
     * @param given the motion of fixed unknowns, m/s; zero elsewhere
     * @return whether it was solved
     */
    virtual bool
    find(const StepData<dim> &step,
         const Vector        &given,
         const Solve         &solve,
         GridStart<dim>      &start);

    /** The velocity from which the particles' change counts, m/s. */
    virtual const Vector &
    mapped(const GridStart<dim> &start) const;

    /**
     * Add to the accounts of a step what the map left and took. Collective.
     * @param misfit p - M~ v_mapped, kg m/s
     * @param change v_new - v_mapped, m/s
     */
    virtual void
    book(const GridStart<dim> &start,
         const Vector         &misfit,
         const Vector         &change,
         StepAccounts         &books) const;

    /** StepAccounts::map_losses, with no change. */
    virtual std::vector<EnergyEntry>
    loss_entries() const;
  };

  /** p - M~ v, kg m/s. */
  template <int dim>
  Vector
  momentum_misfit(const GridStart<dim> &start, const Vector &velocity);

  /**
   * A vector's part on free unknowns, and that on fixed ones; followers have
   * handed theirs over.
   */
  std::pair<Vector, Vector>
  free_and_fixed(const Constraints &constraints, Vector vector);
} // namespace emmy

#endif
