#ifndef emmy_effects_reactions_h
#define emmy_effects_reactions_h

#include <emmy/base/effect_card.h>
#include <emmy/effects/effect.h>

#include <array>

namespace emmy
{
  /** The entry of section `Boundary conditions` on forces on sides. */
  class ReactionParameters : public Section
  {
  public:
    bool are_present = false; ///< whether sides and held parts are asked for

    /** Declares the entry `Reactions`. */
    explicit ReactionParameters(
      const std::string &section = "Boundary conditions");
  };

  /**
   * What some of the nodes are held by, as columns of the ledger: the force, N,
   * and the moment about the origin, N m; in the plane per metre.
   */
  template <int dim>
  class ReactionSum
  {
  public:
    /** BEGINNING_force_x, ..., BEGINNING_moment_z. */
    static std::vector<std::string>
    columns_of(const std::string &beginning);

    /** A component of the force on what holds a node at a place. */
    void
    add(const dealii::Point<dim> &place,
        const unsigned int        component,
        const double              force);

    /** Append the columns, summed over the ranks. Collective. */
    void
    append_to(std::vector<StepMeasure> &measures,
              const std::string        &beginning,
              const MPI_Comm            communicator) const;

  private:
    static constexpr unsigned int n_moments = dim == 2 ? 1 : 3;

    std::array<double, dim + n_moments> values{}; // this rank's share
  };

  /**
   * Forces and moments on the sides of the grid that hold something, as columns
   * of the ledger: wall_SIDE_force_x, in N, and the moment about the origin,
   * wall_SIDE_moment_z, in N m; in the plane per metre. They are those that the
   * accepted step acted with, so that
   * @f[ \sum_p m_p (v_p^{n+1} - v_p^n) = \Delta t\,(\text{loads} - \sum_s
   * f_s) @f]
   * to round-off, with M~ = M. A fixed component of a node on several sides
   * counts for the side that it is normal to, if that holds it, else for the
   * first that does. Owned by the effects. Cost: a pass over the owned nodes.
   */
  template <int dim>
  class Reactions : public Effect<dim>, public StepMeasures<dim>
  {
  public:
    /** Borrows the conditions. */
    explicit Reactions(const BoundaryConditions<dim> &boundary_conditions);

    /** What `emmy --check` says of it. */
    static EffectCard
    card(const BoundaryConditions<dim> *boundary_conditions);

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

  private:
    static std::string
    beginning_of(const unsigned int side);

    const BoundaryConditions<dim>        &boundary_conditions;
    std::array<ReactionSum<dim>, 2 * dim> sums;
  };
} // namespace emmy

#endif
