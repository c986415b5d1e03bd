#ifndef emmy_effects_wall_mapping_h
#define emmy_effects_wall_mapping_h

#include <emmy/base/effect_card.h>
#include <emmy/effects/effect.h>

namespace emmy
{
  /**
   * `Method/Wall mapping` = unconstrained or inelastic: a map from momentum to
   * velocity that knows no essential conditions. With "unconstrained" the step
   * starts from it: fixed nodes bounce, v_new = -v_t. With "inelastic" the step
   * starts from the map with walls, but the particles take the change from the
   * one without: they lose what the walls stop, w.M~ w / 2 with w what they
   * take from the grid's velocity.
   *
   * Owned by the effects. Keeps a velocity. Cost in a step: a solve; with
   * "unconstrained" in place of the other.
   */
  template <int dim>
  class WallMapping : public Effect<dim>, private VelocityMap<dim>
  {
  public:
    /** @param kind "unconstrained" or "inelastic" */
    explicit WallMapping(const std::string &kind);

    /** "inelastic walls", in the card of a scene and the table of times. */
    static std::string
    name(const std::string &kind);

    /** What `emmy --check` says of it. */
    static EffectCard
    card(const std::string &kind, const bool is_present);

    VelocityMap<dim> *
    velocity_map() override;

  private:
    bool
    find(const StepData<dim>                    &step,
         const Vector                           &given,
         const typename VelocityMap<dim>::Solve &solve,
         GridStart<dim>                         &start) override;
    const Vector &
    mapped(const GridStart<dim> &start) const override;
    void
    book(const GridStart<dim> &start,
         const Vector         &misfit,
         const Vector         &change,
         StepAccounts         &books) const override;
    std::vector<EnergyEntry>
    loss_entries() const override;

    const bool is_inelastic;
    Vector     mapped_velocity; ///< m/s
  };
} // namespace emmy

#endif
