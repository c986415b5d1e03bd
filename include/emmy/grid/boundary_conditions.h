#ifndef emmy_grid_boundary_conditions_h
#define emmy_grid_boundary_conditions_h

#include <emmy/base/section.h>

#include <emmy/grid/background_grid.h>
#include <emmy/grid/held_part.h>

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
    /** Names of sides, and of parts. */
    std::vector<std::string> fixed, roller, held_parts;

    /** Declares the entries of the section. */
    explicit BoundaryParameters(
      const std::string &section = "Boundary conditions");
  };

  /**
   * Essential conditions on the sides of the grid and on held parts of space:
   * which components of the displacement are given at a node: zero, unless an
   * effect gives them a motion. What a side holds belongs to the side. Owned by
   * the scene; asked when active nodes are numbered.
   */
  template <int dim>
  class BoundaryConditions
  {
  public:
    /**
     * Throws ExcParameter for a side that the grid has not.
     */
    BoundaryConditions(const BoundaryParameters  &parameters,
                       const BackgroundGrid<dim> &grid,
                       std::vector<HeldPart<dim>> held_parts = {});

    /** The fixed components of a node at @p position. */
    std::bitset<dim>
    fixed_components(const dealii::Point<dim> &position) const;

    /** Whether the normal displacement of a side is given. */
    bool
    is_wall(const unsigned int side) const;

    /** Whether any side of the grid or part of space is fixed. */
    bool
    has_walls() const;

    /** All, in the order of their names. */
    const std::vector<HeldPart<dim>> &
    held_parts() const
    {
      return parts;
    }

    /**
     * The held part that gives a component at a position: the first one that
     * does. The number of parts: none, or a side holds it.
     */
    unsigned int
    part_that_holds(const dealii::Point<dim> &position,
                    const unsigned int        component) const;

    /** The fixed components on a side of the grid. */
    std::bitset<dim>
    fixed_components_of(const unsigned int side) const;

    /** The sides on which a position lies. */
    std::bitset<2 * dim>
    sides_at(const dealii::Point<dim> &position) const;

  private:
    const BackgroundGrid<dim>            &grid;
    std::array<std::bitset<dim>, 2 * dim> fixed_on_side;
    const std::vector<HeldPart<dim>>      parts;

    /** The components that sides fix at a position. */
    std::bitset<dim>
    fixed_by_sides(const dealii::Point<dim> &position) const;
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
