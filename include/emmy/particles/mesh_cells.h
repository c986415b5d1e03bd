#ifndef emmy_particles_mesh_cells_h
#define emmy_particles_mesh_cells_h

#include <deal.II/base/point.h>

#include <string>
#include <utility>
#include <vector>

namespace emmy
{
  /** A mesh that is a shape: which file, and what of it. */
  struct MeshFile
  {
    std::string file;           ///< name; its ending says what it is
    double      scale = 1.;     ///< m per unit of the file
    std::string region;         ///< group of cells; empty: all
    std::string section, entry; ///< what messages name

    /** Whether the ending is that of a mesh of cells, .msh or .vtk. */
    bool
    has_cells() const;
  };

  /** A corner of a cell: where, in the file's unit, and its number. */
  template <int dim>
  using MeshCorner = std::pair<dealii::Point<dim>, unsigned int>;

  /**
   * The corners of each cell, in deal.II's order: dim + 1 of a simplex, 2^dim
   * of a quadrilateral or hexahedron.
   */
  template <int dim>
  using MeshCells = std::vector<std::vector<MeshCorner<dim>>>;

  /**
   * The cells of a mesh that fill space (in the plane: area); others, as those
   * of a surface round them, do not count. deal.II reads files of Gmsh. Of VTK
   * it takes only files of its own kind, so legacy files are read here.
   *
   * Throws ExcParameter: no such file or region, no cells of this dimension.
   */
  template <int dim>
  MeshCells<dim>
  read_mesh_cells(const MeshFile &mesh);
} // namespace emmy

#endif
