#ifndef emmy_effects_held_parts_h
#define emmy_effects_held_parts_h

#include <emmy/effects/reactions.h>

namespace emmy
{
  /**
   * Parts of space whose nodes move as they are told: they give their motion
   * to the nodes, and say as columns of the ledger what holds them:
   * held_NAME_force_x, in N, and the moment about the origin,
   * held_NAME_moment_z, in N m; in the plane per metre. As with Reactions these
   * are the forces that the accepted step acted with. Their work is in
   * reaction_work. Owned by the effects. Cost: a pass over the owned nodes for
   * each velocity, displacement and account.
   */
  template <int dim>
  class HeldParts : public Effect<dim>,
                    public GivenMotion<dim>,
                    public StepMeasures<dim>
  {
  public:
    /** Borrows the conditions. */
    explicit HeldParts(const BoundaryConditions<dim> &boundary_conditions);

    /** @param boundary_conditions null: of a scene without parts */
    static EffectCard
    card(const BoundaryConditions<dim> *boundary_conditions);

    const GivenMotion<dim> *
    given_motion() const override;
    void
    add_velocity(const ActiveGrid<dim> &active,
                 const double           time,
                 Vector                &velocity) const override;
    void
    add_displacement(const ActiveGrid<dim> &active,
                     const double           time,
                     const double           time_step,
                     Vector                &displacement) const override;
    std::string
    work_column() const override;

    void
    see_reactions(const ActiveGrid<dim> &active, const Vector &force) override;
    StepMeasures<dim> *
    measures() override
    {
      return this;
    }
    std::vector<StepMeasure>
    measure(const PointArrays<dim>    &points,
            const double               time,
            const BackgroundGrid<dim> &grid) override;
    /** Which part held no node in the step before; each is told once. */
    std::string
    finding() override;

  private:
    /** Call function(part, component, position, entry) for what is held. */
    template <class Function>
    void
    for_each_held(const ActiveGrid<dim> &active,
                  const Function        &function) const;

    /** Add a vector of each part to the components that it holds. */
    void
    add_of_parts(const std::vector<dealii::Tensor<1, dim>> &of_part,
                 const ActiveGrid<dim>                     &active,
                 Vector                                    &vector) const;

    const BoundaryConditions<dim> &boundary_conditions;
    std::vector<ReactionSum<dim>>  sums;
    std::vector<unsigned int> n_held; ///< components of nodes, of all ranks
    std::vector<bool>         is_told;
  };
} // namespace emmy

#endif
