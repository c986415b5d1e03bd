#ifndef emmy_transfer_middle_places_h
#define emmy_transfer_middle_places_h

#include <emmy/base/effect_card.h>
#include <emmy/particles/field_layout.h>
#include <emmy/transfer/domain_update.h>

namespace emmy
{
  /** The name of the geometry of the middle, in cards and tables of times. */
  constexpr const char *middle_effect = "middle geometry";

  /** What it costs. */
  template <int dim>
  EffectCard
  middle_card(const bool is_present);

  /**
   * Where the middle of a step is looked for first: at x_t + w dt/2, in boxes
   * of (I - L_w dt/2)^-1 F_t, with the velocity w = sum S v_A of the grid and
   * its gradient L_w that the particles found at the end of the step before.
   * (Their own velocity would bring back noise that the grid does not see.)
   * Both are fields of the particles. Owned by the scene.
   */
  template <int dim>
  class MiddlePlaces
  {
  public:
    /** @param layout asked for both fields */
    explicit MiddlePlaces(FieldLayout &layout);

    /** Before the first step: w is the velocity of the particles. */
    void
    begin(const FieldLayout                       &layout,
          dealii::Particles::ParticleHandler<dim> &particles) const;

    /**
     * Hand the particles to the cells and ranks of their first places, for a
     * step of this size; positions and fields stay. Collective.
     */
    void
    hand_over(const double                             time_step,
              BackgroundGrid<dim>                     &grid,
              dealii::Particles::ParticleHandler<dim> &particles) const;

    /**
     * The first places.
     * @param places of the particles as they are
     * @param states at t, in that order
     * @param update null: boxes stay
     */
    Places<dim>
    first(Places<dim>                places,
          const PointArrays<dim>    &states,
          const double               time_step,
          const DomainUpdate<dim>   *update,
          const BackgroundGrid<dim> &grid) const;

    /**
     * Write what the next step begins with to trial states.
     * @param velocity of the grid at t + dt at the local nodes, m/s
     */
    void
    leave(const Stencils<dim>       &stencils,
          const ActiveGrid<dim>     &active,
          const std::vector<double> &velocity,
          PointArrays<dim>          &trial) const;

  private:
    const unsigned int grid_velocity, grid_velocity_gradient;
  };
} // namespace emmy

#endif
