#ifndef emmy_particles_body_h
#define emmy_particles_body_h

#include <deal.II/base/function_parser.h>

#include <deal.II/particles/particle_handler.h>

#include <emmy/grid/background_grid.h>
#include <emmy/particles/field_layout.h>
#include <emmy/particles/initial_stress.h>
#include <emmy/particles/shape.h>

#include <bitset>
#include <memory>
#include <string>
#include <vector>

namespace emmy
{
  /** Section `Bodies/NAME`. */
  template <int dim>
  class BodyParameters : public Section
  {
  public:
    std::string  material;                 ///< its name
    unsigned int points_per_direction = 0; ///< in a cell
    /** `body` or `cells`. */
    std::string         particle_layout = "body";
    std::string         initial_velocity;   ///< m/s, components separated by ;
    std::vector<double> angular_velocity;   ///< rad/s; empty: none
    std::vector<double> center_of_rotation; ///< m; empty: not given
    std::vector<std::string> cut_by;        ///< sides of the grid
    /** None, level ground or formulas. */
    InitialStressParameters initial_stress;

    /** @param shape name of a shape in the library, read beforehand. */
    BodyParameters(const std::string &section, const std::string &shape);

    /** Throws ExcParameter. */
    void
    validate() const;

    /** Throws ExcParameter. */
    std::unique_ptr<Shape<dim>>
    make_shape() const;

  private:
    std::string                           shape_name;
    std::unique_ptr<ShapeParameters<dim>> shape_parameters;
  };

  /** A body as it is at the start. Owned by the scene. */
  template <int dim>
  struct Body
  {
    std::string  name;                 ///< as in `Bodies/Names`
    unsigned int material;             ///< index in the scene's materials
    double       density;              ///< kg/m^3
    unsigned int points_per_direction; ///< in a cell
    bool         divides_box = true; ///< of a box; false: the cells are divided
    std::unique_ptr<Shape<dim>> shape; ///< what it fills at the start
    /** Sides of the grid that the shape may reach beyond. */
    std::bitset<2 * dim>                         cut_by;
    std::unique_ptr<dealii::FunctionParser<dim>> initial_velocity; ///< m/s
    /** On top of it: rad/s, in plane strain (0, 0, omega), and about where. */
    dealii::Tensor<1, 3> angular_velocity   = {};
    dealii::Point<dim>   center_of_rotation = {}; ///< A point of the axis, m
    /** Null: none. */
    std::unique_ptr<InitialStress<dim>> initial_stress = nullptr;

    /** Both velocities together, m/s. */
    dealii::Tensor<1, dim>
    velocity_at(const dealii::Point<dim> &position) const;
  };

  /**
   * Build a body; throws ExcParameter.
   * @param material index of the material that parameters.material names.
   */
  template <int dim>
  Body<dim>
  make_body(const std::string         &name,
            const BodyParameters<dim> &parameters,
            const unsigned int         material,
            const double               density);

  /**
   * The cells of the grid that hold points of bodies, and how many; each rank
   * finds its share, whatever window is open. Cost: that of the cells in the
   * bodies' bounding boxes, of all of the grid for a shape that has none.
   */
  template <int dim>
  std::vector<typename BackgroundGrid<dim>::Occupied>
  occupied_cells(const std::vector<Body<dim>> &bodies,
                 const BackgroundGrid<dim>    &grid);

  /** Half the size of the box that a particle starts with, m. */
  template <int dim>
  dealii::Tensor<1, dim>
  initial_half_length(const Body<dim> &body, const BackgroundGrid<dim> &grid);

  /** Which row of its table each particle of this rank is. */
  struct FilledRows
  {
    dealii::types::particle_index first_id = 0; ///< of this rank
    /** By id from there on; of bodies without a table: nothing that counts. */
    std::vector<unsigned int> rows;
  };

  /**
   * Fill the bodies with particles. Collective. A particle's volume is that of
   * its box, its mass the body's density times that; its half-length, if there
   * is such a field, half its box; its other fields have the layout's initial
   * values. Ids count from 0 over the ranks.
   *
   * Throws ExcRun on all ranks for a body that reaches outside the grid beyond
   * a side that does not cut it, holds no particle, or overlaps another body.
   */
  template <int dim>
  FilledRows
  fill(const std::vector<Body<dim>>            &bodies,
       const BackgroundGrid<dim>               &grid,
       const FieldLayout                       &layout,
       dealii::Particles::ParticleHandler<dim> &particles);
} // namespace emmy

#endif
