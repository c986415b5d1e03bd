#ifndef emmy_particles_particle_layout_h
#define emmy_particles_particle_layout_h

#include <emmy/grid/background_grid.h>
#include <emmy/particles/body.h>

#include <array>
#include <vector>

#include <map>

namespace emmy
{
  /**
   * Where the particles of a body stand at the start: the centres of boxes
   * that divide either the cells of the grid or, for a shape that is a box,
   * the body itself.
   *
   * The body's box is divided into N equal parts in each direction, with the
   * N for which their size is nearest to that of the cells' parts, h /
   * <Points per direction>; what lies beyond a side that cuts the body is
   * left out before. Particles that are listed (ParticleTable) stand where
   * they are; their boxes are cubes of the mean volume. A box whose faces lie
   * on the cells' lattice is filled by the cells' boxes, to the last bit.
   * Cheap: made whenever it is needed.
   */
  template <int dim>
  class ParticleLayout
  {
  public:
    /** Of a body in the cells of a grid. */
    ParticleLayout(const Body<dim> &body, const BackgroundGrid<dim> &grid);

    /** Whether the boxes divide the body and not the cells. */
    bool
    divides_body() const
    {
      return is_of_body;
    }

    /** The size of a particle's box, m. */
    const dealii::Tensor<1, dim> &
    spacing() const
    {
      return size;
    }

    /** Half of it, m. */
    const dealii::Tensor<1, dim> &
    half_length() const
    {
      return half;
    }

    /** The centres that lie in a cell and in the shape. */
    std::vector<dealii::Point<dim>>
    points_in(const CellKey<dim> &cell) const;

    /**
     * Of particles that are listed: the rows of the table that lie in a cell,
     * in the order of points_in().
     */
    const std::vector<unsigned int> &
    rows_in(const CellKey<dim> &cell) const;

  private:
    /** The range of box numbers that may have their centres in a cell. */
    std::array<std::array<long, 2>, dim>
    candidates(const CellKey<dim> &cell) const;
    std::vector<dealii::Point<dim>>
    points_of_cell(const CellKey<dim> &cell) const;
    std::vector<dealii::Point<dim>>
    points_of_body(const CellKey<dim> &cell) const;

    const Body<dim>           &body;
    const BackgroundGrid<dim> &grid;
    bool                       is_of_body;
    /** Of the body's box inside the grid; only if it is divided. */
    dealii::Point<dim>     lower;
    std::array<long, dim>  counts{};
    dealii::Tensor<1, dim> size, half;
    /** The rows of a table, cell by cell; made when they are asked for. */
    mutable std::map<CellKey<dim>, std::vector<unsigned int>> rows;
  };

  /**
   * The part of a body's box that lies inside the grid or beyond a side that
   * does not cut it.
   */
  template <int dim>
  dealii::BoundingBox<dim>
  uncut_box(const Body<dim> &body, const BackgroundGrid<dim> &grid);
} // namespace emmy

#endif
