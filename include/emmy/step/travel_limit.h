#ifndef emmy_step_travel_limit_h
#define emmy_step_travel_limit_h

#include <emmy/grid/boundary_conditions.h>
#include <emmy/particles/point_arrays.h>

#include <array>
#include <vector>

namespace emmy
{
  /**
   * How long a step may be so that no two parts of the material, and no part
   * and a wall, pass through one another unnoticed. Parts feel each other
   * through the nodes that they share, and share none before they are about a
   * cell apart; a step that is longer than their meeting would miss it.
   *
   * A part is what lies in a cell: the mean position x and velocity v of its
   * particles, whichever bodies they belong to. All lengths are counted in
   * cells of their direction. For two parts with e = x_b - x_a and
   * w = v_a - v_b:
   * - nearer than two cells, they may approach by the
   *   limit: dt <= travel / (w . e/|e|). Rigid motion has no such rate;
   * - farther apart, they may come to two cells, or the limit if that is
   *   longer; if they pass one another at a larger distance, there is none.
   *
   * A particle may come to a cell from a wall, or travel by the limit.
   *
   * Owned by the scene, asked once a step. Cost: a sweep over the particles
   * and one sum over the ranks. Only where velocities differ by more than the
   * limit over the step, pairs of cells are compared, with a tree that leaves
   * out those that cannot meet; ranks tell each other the bounds of their
   * parts, and those that could come near another's.
   */
  template <int dim>
  class TravelLimit
  {
  public:
    /** Mean position and velocity of a part, in cells and cells/s. */
    struct Part
    {
      /** m and m/s. */
      dealii::Tensor<1, dim> x, v;
    };

    /** @param travel in cells, positive */
    TravelLimit(const double                   travel,
                const BackgroundGrid<dim>     &grid,
                const BoundaryConditions<dim> &boundary_conditions);

    /**
     * The step that is asked for, or the longest that is allowed, s.
     * Collective.
     * @param velocity_component,mass_component of the fields
     */
    double
    operator()(const double            time_step,
               const PointArrays<dim> &points,
               const unsigned int      velocity_component,
               const unsigned int      mass_component) const;

    /** Cells per step. */
    double
    travel() const
    {
      return limit;
    }

  private:
    double
    time_to_wall(const dealii::Tensor<1, dim> &x,
                 const dealii::Tensor<1, dim> &v) const;
    dealii::Tensor<1, dim>
    in_cells(const dealii::Point<dim> &position) const;
    /** Those of this rank, in the order of their cells. */
    std::vector<Part>
    parts(const PointArrays<dim> &points,
          const unsigned int      velocity_component,
          const unsigned int      mass_component) const;

    const double                   limit;
    const BackgroundGrid<dim>     &grid;
    const BoundaryConditions<dim> &boundary_conditions;
  };

  /**
   * The longest step up to @p time_step in which no part of @p own passes
   * through one of @p all. Not collective.
   */
  template <int dim>
  double
  time_to_meeting(const std::vector<typename TravelLimit<dim>::Part> &own,
                  const std::vector<typename TravelLimit<dim>::Part> &all,
                  const double                                        travel,
                  const double time_step);
} // namespace emmy

#endif
