// Bodies from meshes of cells: volumes and centres against closed forms, who is
// in which cell, regions, and the exact words of refusals.

#include <deal.II/base/mpi.h>

#include <emmy/base/exceptions.h>
#include <emmy/particles/body_measures.h>
#include <emmy/particles/shape_formula.h>
#include <emmy/particles/volume_mesh.h>

#include <fstream>

#include "../check.h"

namespace
{
  using namespace emmy;
  using namespace emmy::test;
  using dealii::Point;

  template <int dim>
  std::unique_ptr<Shape<dim>>
  read(const std::string &file,
       const std::string &region = "",
       const double       scale  = 1.)
  {
    return read_mesh<dim>({file, scale, region, "Bodies/b", "File"});
  }

  /** Gmsh, version 2. */
  std::string
  gmsh(const std::string &nodes,
       const std::string &elements,
       const std::string &names = "")
  {
    const auto lines = [](const std::string &text) {
      return std::to_string(std::count(text.begin(), text.end(), '\n'));
    };
    return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" +
           (names.empty() ? std::string()
                          : "$PhysicalNames\n" + lines(names) + "\n" + names +
                              "$EndPhysicalNames\n") +
           "$Nodes\n" + lines(nodes) + "\n" + nodes + "$EndNodes\n$Elements\n" +
           lines(elements) + "\n" + elements + "$EndElements\n";
  }

  std::string
  vtk(const std::string &points,
      const std::string &cells,
      const std::string &types,
      const std::string &header = "# vtk DataFile Version 2.0\nt\nASCII\n")
  {
    return header + "DATASET UNSTRUCTURED_GRID\nPOINTS " + points + "\nCELLS " +
           cells + "\nCELL_TYPES " + types + "\n";
  }

  constexpr const char *cube =
    "8 double\n0 0 0\n2 0 0\n2 2 0\n0 2 0\n0 0 2\n2 0 2\n2 2 2\n0 2 2";

  void
  write_files()
  {
    const auto write = [](const std::string &name, const std::string &text) {
      std::ofstream(name) << text;
    };
    // an L of a square and a triangle below the step, in two regions
    const std::string plane = "1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 3 0 0\n";
    const std::string names =
      "1 5 \"edge\"\n2 7 \"the square\"\n2 8 \"wedge\"\n";
    write("plane.msh",
          gmsh(plane,
               "1 1 2 5 1 1 2\n2 3 2 7 1 1 2 3 4\n3 2 2 8 2 2 5 3\n",
               names));
    write("edges.msh", gmsh(plane, "1 1 2 5 1 1 2\n"));
    write("folded.msh", gmsh(plane, "1 3 2 7 1 1 3 2 4\n"));
    write("flat.msh", gmsh(plane, "1 2 2 7 1 1 2 5\n"));
    write("twice.msh", gmsh(plane, "1 2 2 7 1 1 2 3\n2 2 2 7 1 1 2 3\n"));
    // a hexahedron and two tetrahedra over its top, beside a triangle
    write("cube.vtk",
          vtk(std::string(cube) + "\n",
              "2 13\n3 0 1 2\n8 0 1 2 3 4 5 6 7",
              "2\n5 12"));
    write("new.vtk",
          vtk("4 float\n0 0 0\n1 0 0\n0 1 0\n0 0 1",
              "2 4\nOFFSETS vtktypeint64\n0 4\nCONNECTIVITY vtktypeint64\n"
              "0 2 1 3",
              "1\n10",
              "# vtk DataFile Version 5.1\nt\nASCII\n"));
    // neighbours whose common face is not plane, from either side
    write("warped.vtk",
          vtk("12 double\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1.2 0 1\n0.9 1 1\n"
              "0 1 1\n2 0 0\n2 1 0\n2 0 1\n2 1 1",
              "2 18\n8 0 1 2 3 4 5 6 7\n8 2 9 11 6 1 8 10 5",
              "2\n12 12"));
    write("overlap.vtk",
          vtk(std::string("12 double\n") + (cube + 9) +
                "\n1.5 0.5 0.5\n4 0.5 0.5\n4 1.5 0.5\n4 1 1.5",
              "2 14\n8 0 1 2 3 4 5 6 7\n4 8 9 10 11",
              "2\n12 10"));
    write("binary.vtk", "# vtk DataFile Version 3.0\nt\nBINARY\n");
    write("quadratic.vtk",
          vtk(std::string(cube), "1 9\n8 0 1 2 3 4 5 6 7", "1\n24"));
    write("binary.msh", "$MeshFormat\n4.1 1 8\n");
    write("nothing.msh", "solid\n");
  }

  void
  check_plane()
  {
    const auto whole = read<2>("plane.msh");
    check_close(whole->volume(), 2., 1e-15, "square and triangle");
    Point<2> center;
    check(whole->center(center), "a mesh knows its centre");
    check_close(center.distance(
                  Point<2>((0.5 + 5. / 3.) / 2., (0.5 + 1. / 3.) / 2.)),
                0.,
                1e-15,
                "that of both");
    check_close(sampled_volume(*whole, MPI_COMM_WORLD),
                2.,
                1.5e-3 * 3.,
                "who is in it");
    check(whole->contains({1., 0.5}) && whole->contains({3., 0.}) &&
            whole->contains({0., 1.}) && !whole->contains({2., 0.51}) &&
            whole->contains({2., 0.5}),
          "faces and corners belong to it");
    check_close(read<2>("plane.msh", "the square")->volume(),
                1.,
                1e-15,
                "a region by its name");
    check_close(read<2>("plane.msh", "8")->volume(),
                1.,
                1e-15,
                "a region by its number");
    check_close(read<2>("plane.msh", "8", 1e-3)->volume(),
                1e-6,
                1e-20,
                "in millimetres");
    check_close(
      read_shape<2>("shift(mesh(plane.msh; 2); 1,1)", "Bodies/b")->volume(),
      8.,
      1e-14,
      "in a formula");
  }

  void
  check_space()
  {
    Point<3>   center;
    const auto hexahedron = read<3>("cube.vtk");
    check_close(hexahedron->volume(), 8., 1e-14, "hexahedron");
    check(hexahedron->center(center) &&
            center.distance(Point<3>(1., 1., 1.)) < 1e-14,
          "its centre");
    for (const double x : {0., 0.5, 1., 2.})
      for (const double y : {-1e-6, 0., 1., 2., 2.000001})
        check(hexahedron->contains(Point<3>(x, y, x)) == (y >= 0. && y <= 2.),
              "a point of the hexahedron");
    const auto tetrahedron = read<3>("new.vtk");
    check_close(tetrahedron->volume(), 1. / 6., 1e-16, "tetrahedron");
    check(tetrahedron->center(center) &&
            center.distance(Point<3>(0.25, 0.25, 0.25)) < 1e-15,
          "the centre of a tetrahedron");
    // what one cell has more, the other has less
    const auto warped = read<3>("warped.vtk");
    check_close(warped->volume(), 2., 1e-14, "cells with a warped face");
    check_close(sampled_volume(*warped, MPI_COMM_WORLD),
                2.,
                1e-3,
                "and no gap between them");
  }

  void
  check_refusals()
  {
    const auto refuses = [](const auto &shape, const auto &...words) {
      check_throws_with(shape, {"Bodies/b/File", words...});
    };
    refuses([] { read<2>("none.msh"); }, "there is no such file");
    refuses([] { read<3>("plane.msh"); },
            "its cells have 2 dimensions, and the scene has 3");
    refuses([] { read<2>("new.vtk"); },
            "its cells have 3 dimensions, and the scene has 2");
    refuses([] { read<2>("edges.msh"); }, "it cannot be read");
    refuses([] { read<2>("nothing.msh"); }, "it cannot be read");
    refuses([] { read<3>("binary.vtk"); }, "it is binary");
    refuses([] { read<3>("binary.msh"); }, "it is binary");
    refuses([] { read<3>("quadratic.vtk"); },
            "VTK's type 24",
            "straight edges");
    refuses([] { read<2>("plane.msh", "edge"); },
            "no cells of a physical group <edge>",
            "the square, wedge");
    refuses([] { read<2>("plane.msh", "", -1.); }, "must be positive");
    refuses([] { read<2>("folded.msh"); }, "1 of its 1 cells", "folded");
    refuses([] { read<2>("flat.msh"); }, "1 of its 1 cells", "no volume");
    refuses([] { read<2>("twice.msh"); }, "its cells overlap");
    refuses([] { read<3>("overlap.vtk"); }, "its cells overlap");
    refuses([] { read<2>("body.stl"); }, "a closed surface fills nothing");
    refuses([] { read<3>("body.stl", "7"); }, "a surface has no regions");
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
    write_files();
  MPI_Barrier(MPI_COMM_WORLD);
  check_plane();
  check_space();
  check_refusals();
  return report();
}
