#ifndef emmy_grid_boundary_conditions_h
#define emmy_grid_boundary_conditions_h

#include <emmy/base/formula.h>
#include <emmy/base/section.h>

#include <emmy/grid/background_grid.h>

#include <array>
#include <bitset>
#include <string>
#include <vector>

namespace emmy
{
  /** Section `Boundary conditions`. */
  class BoundaryParameters : public Section
  {
  public:
    std::vector<std::string> fixed, roller;
    /** Of each side; empty: it rests. Formulas in t, m/s. */
    std::vector<std::string> velocities;

    explicit BoundaryParameters(
      const unsigned int dim,
      const std::string &section = "Boundary conditions");
  };

  /**
   * Essential conditions on the sides of the grid: which components of the
   * displacement are given at a node, and what they are: zero, or the motion
   * of a wall. The grid itself stays: a wall that moves carries along what
   * touches its side. It would therefore act where the grid ends and not where
   * it is, if it moved far along its normal; that is refused beyond a
   * hundredth of a cell. Where two sides give the same component, a moving one
   * wins, then the one that stands first in side_names(). Owned by the scene;
   * asked when active nodes are numbered and, if walls move, in each step.
   */
  template <int dim>
  class BoundaryConditions
  {
  public:
    /** A vector for each side of the grid. */
    using Sides = std::array<dealii::Tensor<1, dim>, 2 * dim>;

    /**
     * Throws ExcParameter for a side that the grid has not, or a velocity that
     * cannot be read or is given for a side that is free.
     */
    BoundaryConditions(const BoundaryParameters  &parameters,
                       const BackgroundGrid<dim> &grid);

    /** The fixed components of a node at @p position. */
    std::bitset<dim>
    fixed_components(const dealii::Point<dim> &position) const;

    /** Whether the normal displacement of a side is given. */
    bool
    is_wall(const unsigned int side) const;

    /** Whether any side of the grid is fixed. */
    bool
    has_walls() const;

    /** Whether any wall moves. If not, do not ask the rest. */
    bool
    has_moving_walls() const;

    /**
     * Velocities of the walls at a time, m/s. Throws ExcRun on all ranks if
     * one is not finite.
     */
    Sides
    wall_velocities(const double time) const;

    /**
     * Displacements of the walls over a step, m: the integral of the
     * velocities, by a Gauss rule with four points.
     */
    Sides
    wall_displacements(const double time, const double time_step) const;

    /**
     * Refuse walls that move too far along their normals from t = 0 to an end
     * time, s, as far as their velocities are finite. Throws ExcParameter.
     */
    void
    check_run(const double end_time) const;

    /**
     * The same of what walls have moved so far: throws ExcRun if
     * @p travel, m since the start, is too far along a normal.
     * @param where "Step 3 from t = 0.2 s"
     */
    void
    check_travel(const Sides &travel, const std::string &where) const;

    /** What the sides at @p position give for a fixed component. */
    double
    value(const Sides              &sides,
          const dealii::Point<dim> &position,
          const unsigned int        component) const;

  private:
    /** How far a side may move along its normal in all, m. */
    double
    allowed_travel(const unsigned int side) const;

    /** The sides on which a position lies. */
    std::bitset<2 * dim>
    sides_at(const dealii::Point<dim> &position) const;

    const BackgroundGrid<dim>            &grid;
    const std::string                     section;
    std::array<std::bitset<dim>, 2 * dim> fixed_on_side;
    /** Null: the side rests. Components: those that are fixed. */
    std::array<std::unique_ptr<dealii::FunctionParser<1>>, 2 * dim> motion;
  };

  /** "x-min", "x-max", "y-min", ...: side 2d is the lower one in direction d.
   */
  std::vector<std::string>
  side_names(const unsigned int dim);

  /**
   * The place of a side in side_names().
   * @param section,entry where the name was read, for the message
   * Throws ExcParameter if there is no such side.
   */
  unsigned int
  side_number(const std::string &name,
              const unsigned int dim,
              const std::string &section,
              const std::string &entry);
} // namespace emmy

#endif
