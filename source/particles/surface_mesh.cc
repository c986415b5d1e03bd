#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/particles/surface_mesh.h>

#ifdef EMMY_WITH_CGAL
#  include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#  include <CGAL/Polygon_mesh_processing/IO/polygon_mesh_io.h>
#  include <CGAL/Polygon_mesh_processing/bbox.h>
#  include <CGAL/Polygon_mesh_processing/orientation.h>
#  include <CGAL/Polygon_mesh_processing/self_intersections.h>
#  include <CGAL/Polygon_mesh_processing/triangulate_faces.h>
#  include <CGAL/Side_of_triangle_mesh.h>
#  include <CGAL/Surface_mesh.h>
#endif

#include <fstream>

namespace emmy
{
  using dealii::Point;

  namespace
  {
#ifdef EMMY_WITH_CGAL
    using Kernel  = CGAL::Exact_predicates_inexact_constructions_kernel;
    using Surface = CGAL::Surface_mesh<Kernel::Point_3>;
    namespace PMP = CGAL::Polygon_mesh_processing;

    Point<3>
    to_point(const Kernel::Point_3 &point)
    {
      return Point<3>(point.x(), point.y(), point.z());
    }

    class SurfaceMesh : public Shape<3>
    {
    public:
      explicit SurfaceMesh(Surface triangles)
        : surface(std::move(triangles))
        , side(surface)
      {
        // of the tetrahedra between the triangles and a corner of the box
        const auto     box = PMP::bbox(surface);
        const Point<3> origin(box.xmin(), box.ymin(), box.zmin());
        for (const auto face : surface.faces())
          {
            std::array<dealii::Tensor<1, 3>, 3> arm;
            unsigned int                        n = 0;
            for (const auto corner :
                 surface.vertices_around_face(surface.halfedge(face)))
              arm[n++] = to_point(surface.point(corner)) - origin;
            const double part =
              arm[0] * dealii::cross_product_3d(arm[1], arm[2]) / 6.;
            content += part;
            middle += part / 4. * (arm[0] + arm[1] + arm[2]);
          }
        middle = origin + middle / content;
      }

      bool
      contains(const Point<3> &position) const override
      {
        return side(Kernel::Point_3(position[0], position[1], position[2])) !=
               CGAL::ON_UNBOUNDED_SIDE;
      }

      double
      volume() const override
      {
        return content;
      }

      bool
      center(Point<3> &center) const override
      {
        center = middle;
        return true;
      }

      dealii::BoundingBox<3>
      bounding_box() const override
      {
        const auto box = PMP::bbox(surface);
        return dealii::BoundingBox<3>(
          {Point<3>(box.xmin(), box.ymin(), box.zmin()),
           Point<3>(box.xmax(), box.ymax(), box.zmax())});
      }

    private:
      const Surface                                      surface;
      const CGAL::Side_of_triangle_mesh<Surface, Kernel> side;
      double                                             content = 0.;
      Point<3>                                           middle;
    };

    /** How many edges have one triangle, and where one of them is. */
    std::string
    holes_of(const Surface &surface)
    {
      unsigned int n = 0;
      std::string  place;
      for (const auto edge : surface.edges())
        if (surface.is_border(edge))
          {
            if (n++ == 0)
              place = dealii::Patterns::Tools::to_string(
                to_point(surface.point(surface.vertex(edge, 0))));
          }
      return n == 0 ? ""
                    : std::to_string(n) +
                        " edges with one triangle, e.g. at (" + place + ") m";
    }

    /** Read, closed and with its faces outwards; see read_surface_mesh(). */
    template <class Require>
    Surface
    read(const std::string &file, const double scale, const Require &require)
    {
      Surface surface;
      // joins equal corners, splits polygons' edges where many meet, orients
      const bool is_read = PMP::IO::read_polygon_mesh(file, surface);
      require(is_read,
              "no surface could be read from it. STL, OBJ, PLY and OFF are "
              "known, by their endings .stl, .obj, .ply and .off");
      require(surface.number_of_faces() > 0,
              "it holds no triangles. Programs leave out what was not chosen: "
              "Gmsh writes the physical groups alone, if there are any, unless "
              "Mesh.SaveAll = 1");
      for (const auto vertex : surface.vertices())
        {
          const auto &x         = surface.point(vertex);
          surface.point(vertex) = {scale * x.x(), scale * x.y(), scale * x.z()};
        }
      PMP::triangulate_faces(surface);
      const std::string holes = holes_of(surface);
      require(holes.empty(),
              "its surface is not closed: " + holes +
                ". Close it, e.g. with MeshLab or Blender");
      require(!PMP::does_self_intersect(surface),
              "its surface cuts itself. Repair it, e.g. with MeshLab or "
              "Blender; or write bodies that overlap to files of their own, "
              "and take the union(mesh(...); mesh(...))");
      PMP::orient_to_bound_a_volume(surface);
      return surface;
    }
#endif

    /** Call @p use with the surface. */
    template <class Use>
    auto
    with_surface(const std::string &file,
                 const double       scale,
                 const std::string &section,
                 const std::string &entry,
                 const Use         &use)
    {
      const auto require = [&](const bool condition, const std::string &what) {
        AssertThrow(condition, ExcParameter(section, entry, file, what + "."));
      };
      require(scale > 0.,
              "its scale is " + shortest(scale) +
                " and must be positive (m per unit of the file)");
      require(std::ifstream(file).good(),
              "there is no such file to read; a name without / in front counts "
              "from the folder in which emmy is started");
#ifndef EMMY_WITH_CGAL
      require(false,
              "this emmy was built without CGAL, which reads surfaces. Install "
              "the package libcgal-dev and build anew");
      return use();
#else
      return use(read(file, scale, require));
#endif
    }
  } // namespace

  std::unique_ptr<Shape<3>>
  read_surface_mesh(const std::string &file,
                    const double       scale,
                    const std::string &section,
                    const std::string &entry)
  {
#ifdef EMMY_WITH_CGAL
    const auto use = [](Surface surface) -> std::unique_ptr<Shape<3>> {
      return std::make_unique<SurfaceMesh>(std::move(surface));
    };
#else
    const auto use = [] { return std::unique_ptr<Shape<3>>(); };
#endif
    return with_surface(file, scale, section, entry, use);
  }

  TriangleSurface
  read_triangles(const std::string &file,
                 const double       scale,
                 const std::string &section,
                 const std::string &entry)
  {
#ifdef EMMY_WITH_CGAL
    const auto use = [](const Surface &surface) {
      TriangleSurface result;
      for (const auto vertex : surface.vertices())
        result.corners.push_back(to_point(surface.point(vertex)));
      for (const auto face : surface.faces())
        {
          auto        &corners = result.faces.emplace_back();
          unsigned int n       = 0;
          for (const auto vertex :
               surface.vertices_around_face(surface.halfedge(face)))
            corners[n++] = vertex.idx();
        }
      return result;
    };
#else
    const auto use = [] { return TriangleSurface(); };
#endif
    return with_surface(file, scale, section, entry, use);
  }
} // namespace emmy
