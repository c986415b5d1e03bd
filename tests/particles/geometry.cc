// Bodies from formulas, surfaces and tables: volumes and centres against
// closed forms, pieces, velocities, and the exact words of refusals.

#include <deal.II/base/mpi.h>

#include <emmy/base/exceptions.h>
#include <emmy/particles/body_measures.h>
#include <emmy/particles/particle_table.h>
#include <emmy/particles/shape_formula.h>
#include <emmy/particles/surface_mesh.h>

#include <fstream>

#include "../check.h"

namespace
{
  using namespace emmy;
  using namespace emmy::test;
  using dealii::Point;
  constexpr double pi = dealii::numbers::PI;

  /** The volume that a formula samples, or knows, against a closed form. */
  template <int dim>
  void
  check_volume(const std::string &text, const double exact, const bool is_known)
  {
    const auto shape = read_shape<dim>(text, "Bodies/b");
    check((shape->volume() > 0.) == is_known, text + ": whether it is known");
    if (is_known)
      check_close(shape->volume(), exact, 1e-13 * exact, text);
    const double sampled = sampled_volume(*shape, MPI_COMM_WORLD);
    check_close(sampled,
                exact,
                1.5e-3 * shape->bounding_box().volume(),
                text + ", sampled");
  }

  void
  check_volumes()
  {
    check_volume<2>("box(0, 0; 4, 1)", 4., true);
    check_volume<2>("difference(box(0,0;4,1); ball(2, 0.5; 0.2))",
                    4. - pi * 0.04,
                    false);
    check_volume<2>("union(box(0,0;1,1), box(0.5,0.5;1.5,1.5))", 1.75, false);
    check_volume<2>("intersection(ball(0,0;1), half_space(0,0;0,2))",
                    pi / 2.,
                    false);
    check_volume<2>("polygon(0,0; 2,0; 2,2; 1,1; 0,2)", 3., true);
    check_volume<2>("turn(box(0,0;2/3,1); 30; 1,1)", 2. / 3., true);
    check_volume<2>("scale(ball(1,0;1); 2, 0.5)", pi, true);
    check_volume<2>("intersection(box(-1,-1;1,1); expression(max(x,y)-0.5))",
                    4. - 2.25,
                    false);
    check_volume<3>("cylinder(0,0,0; 1,1,0; 0.5)",
                    pi * 0.25 * std::sqrt(2.),
                    true);
    check_volume<3>("cone(0,0,0; 0,0,3; 1)", pi, true);
    check_volume<3>("cone(0,0,0; 0,0,3; 1; 0.5)", pi * 1.75, true);
    check_volume<3>("difference(box(0,0,0;4,1,1), "
                    "cylinder(2,0.5,-1; 2,0.5,2; 0.2))",
                    4. - pi * 0.04,
                    false);
    check_volume<3>("shift(scale(turn(cone(0,0,0;0,0,3;1); 40; 0,0,0; 1,2,3); "
                    "2); 5,6,7)",
                    8. * pi,
                    true);
  }

  /** A turn goes from x to y, and about its point. */
  void
  check_places()
  {
    const auto at = [](const std::string &text) {
      Point<2> center;
      read_shape<2>(text, "Bodies/b")->center(center);
      return center;
    };
    check_close(at("turn(ball(2,1;0.1); 90; 1,1)").distance(Point<2>(1., 2.)),
                0.,
                1e-14,
                "a quarter turn about (1, 1)");
    check_close(
      at("shift(scale(ball(2,1;0.1); 3); 1,1)").distance(Point<2>(7., 4.)),
      0.,
      1e-14,
      "scaled, then shifted");
    Point<3>   center;
    const auto cone =
      read_shape<3>("turn(cone(0,0,0;4,0,0;1); 90; 0,0,0; 0,0,1)", "Bodies/b");
    check(cone->center(center), "a turned cone knows its centre");
    check_close(center.distance(Point<3>(0., 1., 0.)),
                0.,
                1e-14,
                "the centre of a cone is at a quarter of its height");
    check(!cone->contains(Point<3>(0., 3., 0.5)) &&
            cone->contains(Point<3>(0., 3., 0.2)),
          "its tip is at its top");
  }

  void
  check_refusals()
  {
    const auto refuses = [](const std::string              &text,
                            const std::vector<std::string> &words) {
      check_throws_with([&] { read_shape<2>(text, "Bodies/b"); }, words);
    };
    refuses("boks(0,0;1,1)", {"Bodies/b", "did you mean <box>?"});
    refuses("box(0,0;1)", {"box(lower (x, y); upper (x, y))"});
    refuses("box(0,0;1,a)", {"A number is expected there"});
    refuses("box(0,0;-1,1)", {"upper corner must lie above"});
    refuses("union(box(0,0;1,1)", {"as many ) as ("});
    refuses("intersection(box(0,0;1,1);box(2,2;3,3))", {"do not meet"});
    refuses("polygon(0,0;1,1;1,0;0,1)", {"must not cross"});
    refuses("ball(0,0;0)", {"radius must be positive"});
    refuses("cylinder(0,0,0;1,0,0;1)", {"Shapes of a formula are ball, box"});
  }

  /** An octahedron with corners at distance 1, volume 4/3. */
  void
  write_octahedron(const std::string &file, const bool is_open)
  {
    std::ofstream out(file);
    out << "solid s\n";
    for (const double x : {-1., 1.})
      for (const double y : {-1., 1.})
        for (const double z : {-1., 1.})
          if (!(is_open && x > 0. && y > 0. && z > 0.))
            {
              const bool is_right = x * y * z > 0.;
              out << "facet normal 0 0 0\nouter loop\nvertex " << x
                  << " 0 0\nvertex "
                  << (is_right ? "0 " + std::to_string(y) + " 0\nvertex 0 0 " +
                                   std::to_string(z)
                               : "0 0 " + std::to_string(z) + "\nvertex 0 " +
                                   std::to_string(y) + " 0")
                  << "\nendloop\nendfacet\n";
            }
    out << "endsolid s\n";
  }

  void
  check_surfaces()
  {
    const bool is_first =
      dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0;
    if (is_first)
      {
        write_octahedron("closed.stl", false);
        write_octahedron("open.stl", true);
        std::ofstream("empty.stl") << "solid s\nendsolid s\n"; // as Gmsh may
        std::ofstream("cube.obj")
          << "v 1 1 1\nv 3 1 1\nv 3 3 1\nv 1 3 1\nv 1 1 3\nv 3 1 3\nv 3 3 3\n"
             "v 1 3 3\nf 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\n"
             "f 3 4 8 7\nf 4 1 5 8\n";
      }
    MPI_Barrier(MPI_COMM_WORLD);
    const auto closed = read_surface_mesh("closed.stl", 2., "Bodies/b", "File");
    check_close(closed->volume(), 4. / 3. * 8., 1e-13, "octahedron");
    Point<3> center;
    check(closed->center(center) && center.norm() < 1e-14, "its centre");
    check(closed->contains(Point<3>(0., 0., 2.)) &&
            closed->contains(Point<3>(0.6, 0.6, 0.6)) &&
            !closed->contains(Point<3>(0.7, 0.7, 0.7)),
          "who is in it; corners are");
    check_volume<3>("mesh(closed.stl)", 4. / 3., true);
    check_volume<3>("mesh(cube.obj; 0.5)", 1., true);
    const auto cube = read_surface_mesh("cube.obj", 1., "Bodies/b", "File");
    check(cube->center(center) && center.distance(Point<3>(2., 2., 2.)) < 1e-14,
          "the centre of the cube");
    // on edges and diagonals of the surface, where rays meet many triangles
    for (const double x : {1., 1.5, 2., 2.5, 3.})
      for (const double y : {0.999, 1., 2., 3., 3.001})
        check(cube->contains(Point<3>(x, y, x)) == (y >= 1. && y <= 3.),
              "a point of the cube");
    check_throws_with(
      [] { read_surface_mesh("open.stl", 1., "Bodies/b", "File"); },
      {"not closed: 3 edges with one triangle"});
    check_throws_with(
      [] { read_surface_mesh("empty.stl", 1., "Bodies/b", "File"); },
      {"holds no triangles"});
    check_throws_with(
      [] { read_surface_mesh("none.stl", 1., "Bodies/b", "File"); },
      {"no such file"});
  }

  /** One body in 8 x 8 (x 8) cells of size 0.5. */
  template <int dim>
  struct Filled
  {
    GridParameters<dim>                     grid_parameters;
    std::unique_ptr<BackgroundGrid<dim>>    grid;
    std::vector<Body<dim>>                  bodies;
    FieldLayout                             layout = basic_fields(dim);
    dealii::Particles::ParticleHandler<dim> particles;

    Filled(const std::string                                      &shape,
           const std::vector<std::pair<std::string, std::string>> &entries)
    {
      dealii::ParameterAcceptor::clear();
      grid_parameters.cells = std::vector<unsigned int>(dim, 8);
      for (unsigned int d = 0; d < dim; ++d)
        grid_parameters.upper_corner[d] = 4.;
      grid =
        std::make_unique<BackgroundGrid<dim>>(grid_parameters, MPI_COMM_WORLD);
      BodyParameters<dim>       parameters("Bodies/b", shape);
      dealii::ParameterHandler &prm = dealii::ParameterAcceptor::prm;
      dealii::ParameterAcceptor::declare_all_parameters();
      prm.enter_subsection("Bodies");
      prm.enter_subsection("b");
      prm.set("Points per direction", "2");
      for (const auto &[name, value] : entries)
        if (name == "File")
          {
            prm.enter_subsection(shape);
            prm.set(name, value);
            prm.leave_subsection();
          }
        else
          prm.set(name, value);
      prm.leave_subsection();
      prm.leave_subsection();
      dealii::ParameterAcceptor::parse_all_parameters();
      bodies.push_back(make_body<dim>("b", parameters, 0, 7.));
      layout.add({"half_length", Field::Kind::vector, "m", "half", {}});
      particles.initialize(grid->triangulation(),
                           grid->mapping(),
                           layout.n_components());
      fill(bodies, *grid, layout, particles);
    }

    BodyMeasures<dim>
    measures() const
    {
      return measure_bodies(bodies, *grid, layout, particles)[0];
    }
  };

  void
  check_pieces()
  {
    const auto pieces = [](const std::string &shape) {
      return Filled<2>(shape, {}).measures().pieces;
    };
    check(pieces("box(0,0;4,4)") == 1, "one box, one piece");
    check(pieces("union(box(0,0;1,4),box(2,0;4,4))") == 2, "two boxes");
    check(pieces("union(box(0,0;1,4),box(1,0;4,4))") == 1, "boxes that touch");
    check(pieces("union(box(0,0;2,2),box(2,2;4,4))") == 1,
          "cells that share one node are one piece");
    check(pieces("difference(box(0,0;4,4);box(1.5,-1;2.5,5))") == 2,
          "a bar that is cut");
    check(pieces("difference(box(0,0;4,4);box(1,1;3,3))") == 1, "a frame");
    const auto rings = [&pieces](const std::string &hole) {
      return pieces("difference(union(difference(box(0,0;4,4);box(" + hole +
                    "));box(1,1;3,3));box(1.5,1.5;2.5,2.5))");
    };
    check(rings("0.5,0.5;3.5,3.5") == 2, "rings with a cell between them");
    check(rings("0.75,0.75;3.25,3.25") == 1, "rings half a cell apart");
    check(Filled<3>("union(box(0,0,0;1,1,1),box(3,3,3;4,4,4),box(0,3,0;1,4,4))",
                    {})
              .measures()
              .pieces == 3,
          "three boxes in space");
  }

  /** Momentum and spin of a body that turns, in closed form. */
  void
  check_rotation()
  {
    const Filled<2> plane("box(1,1;3,2)",
                          {{"Initial velocity", "1; y"},
                           {"Angular velocity", "2"},
                           {"Center of rotation", "1, 1"}});
    const auto      v = plane.bodies[0].velocity_at(Point<2>(2., 3.));
    check_close(v[0], 1. - 2. * 2., 1e-15, "v_x of a rotation");
    check_close(v[1], 3. + 2. * 1., 1e-15, "v_y of a rotation");
    for (const auto &particle : plane.particles)
      check_close(particle.get_properties()[plane.layout["velocity"] + 1],
                  particle.get_location()[1] +
                    2. * (particle.get_location()[0] - 1.),
                  1e-14,
                  "particles have it");
    const Filled<3> space("box(1,1,1;3,2,2)",
                          {{"Angular velocity", "1, 2, 3"},
                           {"Center of rotation", "0, 0, 0"}});
    const auto      w = space.bodies[0].velocity_at(Point<3>(0., 0., 1.));
    check(w[0] == 2. && w[1] == -1. && w[2] == 0., "omega x e_z");
    check_throws_with(
      [] {
        Filled<2>("box(1,1;3,2)", {{"Angular velocity", "2"}});
      },
      {"Center of rotation"});
  }

  void
  check_table()
  {
    if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
      {
        std::ofstream("points.csv")
          << "# a comment\nvolume, x, y, vx, vy\n0.25,1.1,1.2,3,4\n"
             "0.75;3.3;0.4;5;6\n";
        std::ofstream("wrong.csv") << "x y volume\n1 1 0.5\n1 b 0.5\n";
        std::ofstream("column.csv") << "x volume\n1 0.5\n";
      }
    MPI_Barrier(MPI_COMM_WORLD);
    const Filled<2> filled("particles",
                           {{"File", "points.csv"},
                            {"Initial velocity", "0; x"}});
    const auto      found = filled.measures();
    check_close(found.volume, 1., 1e-15, "volume of the table");
    check_close(found.mass, 7., 1e-15, "mass of the table");
    check(found.pieces == 2, "its particles are far from each other");
    for (const auto &particle : filled.particles)
      {
        const auto values   = particle.get_properties();
        const bool is_first = particle.get_location()[0] < 2.;
        const auto v        = filled.layout["velocity"];
        check_close(values[filled.layout["reference_volume"]],
                    is_first ? 0.25 : 0.75,
                    0.,
                    "volume of a row");
        check_close(values[v], is_first ? 3. : 5., 0., "vx of a row");
        check_close(values[v + 1],
                    is_first ? 4. + 1.1 : 6. + 3.3,
                    1e-15,
                    "vy of a row, on top of the body's");
      }
    const auto refuses = [](const std::string              &file,
                            const std::vector<std::string> &words) {
      check_throws_with(
        [&] {
          read_particle_table<2>({file, -1, {}, "Bodies/b"});
        },
        words);
    };
    refuses("wrong.csv", {"line 3", "3 finite numbers"});
    refuses("column.csv", {"no column <y>"});
    refuses("none.csv", {"no such file"});
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_volumes();
  check_places();
  check_refusals();
  check_surfaces();
  check_pieces();
  check_rotation();
  check_table();
  return report();
}
