#ifndef emmy_particles_shape_h
#define emmy_particles_shape_h

#include <deal.II/base/bounding_box.h>

#include <emmy/base/library.h>
#include <emmy/base/section.h>

#include <memory>

namespace emmy
{
  template <int dim>
  struct ParticleTable;

  /** A region of space that a body fills at the start. */
  template <int dim>
  class Shape
  {
  public:
    virtual ~Shape() = default;

    /** Whether a point, m, is in it or on its surface. */
    virtual bool
    contains(const dealii::Point<dim> &position) const = 0;

    /** Volume, m^3 (m^2 in plane strain); 0 if the shape does not know it. */
    virtual double
    volume() const
    {
      return 0.;
    }

    /** Its centre, m; false and no value if the shape does not know it. */
    virtual bool
    center(dealii::Point<dim> &) const
    {
      return false;
    }

    /** Whether the shape is its bounding box. */
    virtual bool
    is_box() const
    {
      return false;
    }

    /** Whether the shape reaches all sides of its bounding box. */
    virtual bool
    has_tight_box() const
    {
      return true;
    }

    /** The particles that it lists; null: they are made from the shape. */
    virtual const ParticleTable<dim> *
    table() const
    {
      return nullptr;
    }

    /**
     * A box around the shape. It must be finite unless the shape does not
     * know its extent (expression).
     */
    virtual dealii::BoundingBox<dim>
    bounding_box() const = 0;
  };

  /** The section of a shape, e.g. "Bodies/left/ball". */
  template <int dim>
  class ShapeParameters : public Section
  {
  public:
    using Section::Section;

    /** Check and build. Throws ExcParameter. */
    virtual std::unique_ptr<Shape<dim>>
    make() const = 0;
  };

  /**
   * All shapes that have a section: box, ball, cylinder (3D), expression,
   * mesh (3D), particles.
   */
  template <int dim>
  Library<ShapeParameters<dim>> &
  shape_library();
} // namespace emmy

#endif
