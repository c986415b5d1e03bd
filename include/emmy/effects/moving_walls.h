#ifndef emmy_effects_moving_walls_h
#define emmy_effects_moving_walls_h

#include <emmy/base/effect_card.h>
#include <emmy/base/formula.h>
#include <emmy/effects/effect.h>

#include <array>

namespace emmy
{
  /** The entries of section `Boundary conditions` on walls that move. */
  class MovingWallParameters : public Section
  {
  public:
    /** Of each side; empty: it rests. Formulas in t, m/s. */
    std::vector<std::string> velocities;

    /** Declares the velocities of sides. */
    explicit MovingWallParameters(
      const unsigned int dim,
      const std::string &section = "Boundary conditions");

    /** Whether any wall moves. */
    bool
    are_present() const;
  };

  /**
   * Walls that move: they give their motion to the fixed components of the
   * nodes on their sides. The grid itself stays: a wall carries along what
   * touches its side. It would therefore act where the grid ends and not where
   * it is, if it moved far along its normal; that is refused beyond a hundredth
   * of a cell. Where two sides give the same component, the one that stands
   * first in side_names() wins. Owned by the effects. Cost: a pass over the
   * owned nodes for each velocity and displacement.
   */
  template <int dim>
  class MovingWalls : public Effect<dim>,
                      public GivenMotion<dim>,
                      public StepMemory
  {
  public:
    /**
     * Borrows the conditions. Throws ExcParameter for a velocity that cannot be
     * read or is given for a side that is free.
     */
    MovingWalls(const MovingWallParameters    &parameters,
                const BoundaryConditions<dim> &boundary_conditions,
                const BackgroundGrid<dim>     &grid);

    /** What `emmy --check` says of it. */
    static EffectCard
    card(const bool is_present);

    /**
     * Refuse walls that move too far along their normals from t = 0 to an end
     * time, s, as far as their velocities are finite. Throws ExcParameter.
     */
    void
    check_run(const double end_time) const;

    /** How far walls have moved, m. */
    StepMemory *
    memory() override
    {
      return this;
    }
    std::vector<double>
    contents() const override;
    void
    recall(const std::vector<std::vector<double>> &parts) override;
    const GivenMotion<dim> *
    given_motion() const override;
    /** Throws ExcRun on all ranks if a velocity is not finite. */
    void
    add_velocity(const ActiveGrid<dim> &active,
                 const double           time,
                 Vector                &velocity) const override;
    /** The integral of the velocities, by a Gauss rule with four points. */
    void
    add_displacement(const ActiveGrid<dim> &active,
                     const double           time,
                     const double           time_step,
                     Vector                &displacement) const override;
    /** Throws ExcRun if walls would have moved too far along a normal. */
    void
    check_step(const double       time,
               const double       time_step,
               const std::string &where) const override;
    void
    end_step(const double time, const double time_step) override;
    std::string
    work_column() const override;

  private:
    /** A vector for each side of the grid. */
    using Sides = std::array<dealii::Tensor<1, dim>, 2 * dim>;

    Sides
    velocities(const double time) const;
    Sides
    displacements(const double time, const double time_step) const;
    /** How far sides will have moved at the end of a step, m. */
    Sides
    travel_after(const double time, const double time_step) const;
    /** How far a side may move along its normal in all, m. */
    double
    allowed_travel(const unsigned int side) const;
    /** Add what the sides give to the fixed components of the owned nodes. */
    void
    add_sides(const Sides           &sides,
              const ActiveGrid<dim> &active,
              Vector                &vector) const;

    const BoundaryConditions<dim> &boundary_conditions;
    const BackgroundGrid<dim>     &grid;
    const std::string              section;
    /** Null: the side rests. Components: those that are fixed. */
    std::array<std::unique_ptr<dealii::FunctionParser<1>>, 2 * dim> motion;
    Sides travel; ///< so far, m
  };
} // namespace emmy

#endif
