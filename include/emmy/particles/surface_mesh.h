#ifndef emmy_particles_surface_mesh_h
#define emmy_particles_surface_mesh_h

#include <emmy/particles/shape.h>

#include <array>
#include <string>
#include <vector>

namespace emmy
{
  /** A surface of triangles. */
  struct TriangleSurface
  {
    std::vector<dealii::Point<3>>            corners; ///< m
    std::vector<std::array<unsigned int, 3>> faces;   ///< numbers of corners
  };

  /**
   * The triangles of a closed surface, counter-clockwise from outside. Corners
   * at the same place are one. Throws as read_surface_mesh().
   */
  TriangleSurface
  read_triangles(const std::string &file,
                 const double       scale,
                 const std::string &section,
                 const std::string &entry);

  /**
   * The inside of a closed surface of triangles. CGAL reads the file, STL,
   * OBJ, PLY or OFF, joins corners at the same place, and answers where a
   * point lies with exact predicates, at the cost of the logarithm of the
   * number of triangles. Volume and centre are the exact ones of the surface.
   *
   * Throws ExcParameter for @p section and @p entry: no such file, no
   * triangles, a surface with holes (with the number of open edges and where
   * one is) or that cuts itself.
   *
   * @param scale m per unit of the file, e.g. 1e-3 for millimetres
   */
  std::unique_ptr<Shape<3>>
  read_surface_mesh(const std::string &file,
                    const double       scale,
                    const std::string &section,
                    const std::string &entry);
} // namespace emmy

#endif
