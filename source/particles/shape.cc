#include <emmy/particles/basic_shapes.h>
#include <emmy/particles/particle_table.h>
#include <emmy/particles/shape.h>
#include <emmy/particles/volume_mesh.h>

#include <limits>

namespace emmy
{
  using dealii::BoundingBox;
  using dealii::Point;

  namespace
  {
    /** Radius of balls and cylinders. */
    void
    require_positive(const Section     &section,
                     const std::string &entry,
                     const double       value)
    {
      AssertThrow(value > 0.,
                  ExcParameter(section.path(),
                               entry,
                               shortest(value),
                               "it is required and must be positive (m)."));
    }

    /** List of coordinates in the words of a parameter file. */
    template <int dim>
    class Coordinates
    {
    public:
      /** Empty unless given, which ParameterHandler can print. */
      std::vector<double> values;

      void
      add_to(Section           &section,
             const std::string &name,
             const std::string &doc,
             const std::string &when = "Required")
      {
        section.add_parameter(name,
                              values,
                              doc + " Unit: m. " + when + ": " +
                                std::to_string(dim) + " coordinates.",
                              section.prm,
                              dealii::Patterns::List(dealii::Patterns::Double(),
                                                     0,
                                                     dim));
      }

      Point<dim>
      point(const Section &section, const std::string &name) const
      {
        AssertThrow(values.size() == dim,
                    ExcParameter(section.path(),
                                 name,
                                 dealii::Patterns::Tools::to_string(values),
                                 "it is required: " + std::to_string(dim) +
                                   " coordinates in m, separated by , or ;."));
        Point<dim> result;
        for (unsigned int d = 0; d < dim; ++d)
          result[d] = values[d];
        return result;
      }
    };

    template <int dim>
    void
    require_above(const Section    &section,
                  const Point<dim> &lower,
                  const Point<dim> &upper)
    {
      for (unsigned int d = 0; d < dim; ++d)
        AssertThrow(upper[d] > lower[d],
                    ExcParameter(section.path(),
                                 "Upper corner",
                                 dealii::Patterns::Tools::to_string(upper),
                                 "must lie above the lower corner in each "
                                 "direction."));
    }

    template <int dim>
    class BoxParameters : public ShapeParameters<dim>
    {
    public:
      explicit BoxParameters(const std::string &section)
        : ShapeParameters<dim>(section)
      {
        lower.add_to(*this, "Lower corner", "Lower corner of the box.");
        upper.add_to(*this, "Upper corner", "Upper corner of the box.");
      }

      std::unique_ptr<Shape<dim>>
      make() const override
      {
        const auto from = lower.point(*this, "Lower corner");
        const auto to   = upper.point(*this, "Upper corner");
        require_above(*this, from, to);
        return make_box(from, to);
      }

    private:
      Coordinates<dim> lower, upper;
    };

    template <int dim>
    class BallParameters : public ShapeParameters<dim>
    {
    public:
      explicit BallParameters(const std::string &section)
        : ShapeParameters<dim>(section)
      {
        center.add_to(*this, "Center", "Center of the ball.");
        this->add_parameter("Radius",
                            radius,
                            "Radius of the ball. Unit: m. Required, positive.",
                            this->prm,
                            dealii::Patterns::Double(0.));
      }

      std::unique_ptr<Shape<dim>>
      make() const override
      {
        require_positive(*this, "Radius", radius);
        return make_ball(center.point(*this, "Center"), radius);
      }

    private:
      Coordinates<dim> center;
      double           radius = 0.;
    };

    class CylinderParameters : public ShapeParameters<3>
    {
    public:
      explicit CylinderParameters(const std::string &section)
        : ShapeParameters<3>(section)
      {
        base.add_to(*this, "Base", "Center of one end disc.");
        top.add_to(*this, "Top", "Center of the other end disc.");
        this->add_parameter("Radius",
                            radius,
                            "Radius of the cylinder. Unit: m. Required, "
                            "positive.",
                            this->prm,
                            dealii::Patterns::Double(0.));
      }

      std::unique_ptr<Shape<3>>
      make() const override
      {
        require_positive(*this, "Radius", radius);
        const auto from = base.point(*this, "Base");
        const auto to   = top.point(*this, "Top");
        AssertThrow(from.distance(to) > 0.,
                    ExcParameter(this->path(),
                                 "Top",
                                 dealii::Patterns::Tools::to_string(to),
                                 "must differ from <Base>."));
        return make_cone(from, to, radius, radius);
      }

    private:
      Coordinates<3> base, top;
      double         radius = 0.;
    };

    template <int dim>
    class ExpressionParameters : public ShapeParameters<dim>
    {
    public:
      explicit ExpressionParameters(const std::string &section)
        : ShapeParameters<dim>(section)
      {
        this->add_parameter("Expression",
                            text,
                            "A formula in x, y (and z), in m, that is positive "
                            "inside the body. Required.");
        const std::string both = "Optional, but then both corners";
        lower.add_to(*this,
                     "Lower corner",
                     "Lower corner of a box; the body is what lies in it. "
                     "Without one the formula is tried all over the grid, "
                     "which takes long where the grid is large.",
                     both);
        upper.add_to(*this, "Upper corner", "Upper corner of that box.", both);
      }

      std::unique_ptr<Shape<dim>>
      make() const override
      {
        Point<dim> from, to;
        for (unsigned int d = 0; d < dim; ++d)
          {
            from[d] = std::numeric_limits<double>::lowest();
            to[d]   = std::numeric_limits<double>::max();
          }
        if (!lower.values.empty() || !upper.values.empty())
          {
            from = lower.point(*this, "Lower corner");
            to   = upper.point(*this, "Upper corner");
            require_above(*this, from, to);
          }
        return make_expression(this->path(),
                               "Expression",
                               text,
                               BoundingBox<dim>({from, to}));
      }

    private:
      std::string      text;
      Coordinates<dim> lower, upper;
    };

    template <int dim>
    class MeshParameters : public ShapeParameters<dim>
    {
    public:
      explicit MeshParameters(const std::string &section)
        : ShapeParameters<dim>(section)
      {
        mesh.section = this->path();
        mesh.entry   = "File";
        this->add_parameter(
          "File",
          mesh.file,
          "A mesh of cells, which may be triangles or quadrilaterals in the "
          "plane, tetrahedra or hexahedra in space: Gmsh (.msh) or legacy VTK "
          "(.vtk), as text. In space also a closed surface: STL, OBJ, PLY or "
          "OFF. The ending of its name says which. Required.");
        this->add_parameter("Scale",
                            mesh.scale,
                            "Length of the file's unit, e.g. 1e-3 for "
                            "millimetres. Unit: m. Positive.");
        this->add_parameter("Region",
                            mesh.region,
                            "The cells of this physical group of Gmsh, by its "
                            "name or number. Empty: all cells.");
      }

      std::unique_ptr<Shape<dim>>
      make() const override
      {
        return read_mesh<dim>(mesh);
      }

    private:
      MeshFile mesh;
    };

    template <int dim>
    class TableParameters : public ShapeParameters<dim>
    {
    public:
      explicit TableParameters(const std::string &section)
        : ShapeParameters<dim>(section)
      {
        this->add_parameter(
          "File",
          table.file,
          "A table (CSV, or points of a .vtu) with the "
          "columns x, y (and z) in m, volume in m^3 (in plane "
          "strain m^2) and, if wanted, vx, vy (and vz) in "
          "m/s, which add to the body's; mass or density; and "
          "what particles have suffered, as cauchy_stress_xx, "
          "... <Points per direction> is not used. Required.");
        this->add_parameter("Rows of body",
                            table.body,
                            "Of a file with a column <body>: the number of the "
                            "body whose rows count, from 0. -1: all do.",
                            this->prm,
                            dealii::Patterns::Integer(-1));
        this->add_parameter("Leave out",
                            table.left_out,
                            "Columns of the file that do not count. Those that "
                            "a body has no use for are refused.");
      }

      std::unique_ptr<Shape<dim>>
      make() const override
      {
        TableFile from = table;
        from.section   = this->path();
        return read_particle_table<dim>(from);
      }

    private:
      TableFile table;
    };

    template <int dim>
    Library<ShapeParameters<dim>>
    built_in_shapes()
    {
      Library<ShapeParameters<dim>> shapes;
      shapes.add({"box", "axis-parallel box", [](const std::string &section) {
                    return std::make_unique<BoxParameters<dim>>(section);
                  }});
      shapes.add({"ball",
                  "ball; in plane strain a cylinder seen from its end",
                  [](const std::string &section) {
                    return std::make_unique<BallParameters<dim>>(section);
                  }});
      if constexpr (dim == 3)
        {
          shapes.add({"cylinder",
                      "circular cylinder between two points",
                      [](const std::string &section) {
                        return std::make_unique<CylinderParameters>(section);
                      }});
        }
      shapes.add({"mesh",
                  dim == 2 ? "the cells of a mesh in a file"
                           : "the cells of a mesh, or the inside of a closed "
                             "surface of triangles, in a file",
                  [](const std::string &section) {
                    return std::make_unique<MeshParameters<dim>>(section);
                  }});
      shapes.add({"expression",
                  "where a formula is positive",
                  [](const std::string &section) {
                    return std::make_unique<ExpressionParameters<dim>>(section);
                  }});
      shapes.add({"particles",
                  "particles one by one, from a table",
                  [](const std::string &section) {
                    return std::make_unique<TableParameters<dim>>(section);
                  }});
      return shapes;
    }
  } // namespace

  template <int dim>
  Library<ShapeParameters<dim>> &
  shape_library()
  {
    static Library<ShapeParameters<dim>> library = built_in_shapes<dim>();
    return library;
  }

  template Library<ShapeParameters<2>> &
  shape_library<2>();
  template Library<ShapeParameters<3>> &
  shape_library<3>();
} // namespace emmy
