#ifndef emmy_particles_volume_mesh_h
#define emmy_particles_volume_mesh_h

#include <emmy/particles/mesh_cells.h>
#include <emmy/particles/shape.h>

namespace emmy
{
  /**
   * What the cells of a mesh fill: triangles and quadrilaterals in the plane,
   * tetrahedra and hexahedra in space. deal.II reads the file, of Gmsh (.msh)
   * or VTK (.vtk, legacy, as text). Hexahedra and quadrilaterals are cut into
   * simplices about their centre; faces that are not plane are cut along the
   * diagonal of their first corner, the same for both neighbours. Volume and
   * centre are the exact ones of these simplices.
   *
   * A point is sought in a tree of boxes: the logarithm of the number of
   * cells. Memory: some 200 bytes a simplex, on each rank.
   *
   * Throws ExcParameter for the section and entry as read_mesh_cells(), and for
   * cells without volume or folded (with the number and a place), and cells
   * that overlap (as points in each of them tell).
   */
  template <int dim>
  std::unique_ptr<Shape<dim>>
  read_volume_mesh(const MeshFile &mesh);

  /** What a file is by its ending: this, or in space a closed surface. */
  template <int dim>
  std::unique_ptr<Shape<dim>>
  read_mesh(const MeshFile &mesh);
} // namespace emmy

#endif
