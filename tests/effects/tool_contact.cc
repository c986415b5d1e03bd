// Facts about how a tool acts on a corner. Random states: its force does
// exactly the work that is stored or lost, for each shape; distances and forces
// have the derivatives that they say, with the order of a centred difference; a
// tool that turns sees in its frame what moves.

#include <emmy/base/parameter_file.h>
#include <emmy/effects/tool_contact.h>
#include <emmy/effects/tool_mesh.h>
#include <emmy/effects/tool_motion.h>
#include <emmy/effects/tool_surface.h>

#include <iostream>
#include <random>

#include "../check.h"

using namespace emmy;
using dealii::Tensor;
using test::check;

namespace
{
  void
  at_most(const std::string &what, const double value, const double limit)
  {
    std::cout << what << ' ' << value << " (at most " << limit << ")\n";
    check(value <= limit, what);
  }

  std::mt19937 random_numbers(7);

  double
  random(const double from, const double to)
  {
    return std::uniform_real_distribution<double>(from, to)(random_numbers);
  }

  template <int dim>
  Tensor<1, dim>
  random_vector(const double size)
  {
    Tensor<1, dim> result;
    for (unsigned int d = 0; d < dim; ++d)
      result[d] = random(-size, size);
    return result;
  }

  /** A shape from statements of its section. */
  template <int dim>
  std::unique_ptr<ToolShape<dim>>
  shape_of(const std::string &name, const std::string &statements)
  {
    dealii::ParameterAcceptor::clear();
    const auto parameters =
      tool_shape_library<dim>().find(name, "", "").make("tool");
    ParameterFile::from_text("subsection tool\n" + statements + "end\n", "test")
      .parse(dealii::ParameterAcceptor::prm);
    dealii::ParameterAcceptor::parse_all_parameters();
    return parameters->make();
  }

  /** Any direction, in the words of a file. */
  template <int dim>
  std::string
  list(const std::vector<double> &values)
  {
    return dealii::Patterns::Tools::to_string(
      std::vector<double>(values.begin(), values.begin() + dim));
  }

  /** The surface of a box, of two triangles a side. */
  TriangleSurface
  box_surface(const Tensor<1, 3> &half_size)
  {
    TriangleSurface result;
    for (unsigned int i = 0; i < 8; ++i)
      {
        auto &corner = result.corners.emplace_back();
        for (unsigned int d = 0; d < 3; ++d)
          corner[d] = i >> d & 1 ? half_size[d] : -half_size[d];
      }
    result.faces = {{{0, 2, 1}},
                    {{1, 2, 3}},
                    {{4, 5, 6}},
                    {{5, 7, 6}},
                    {{0, 1, 4}},
                    {{1, 5, 4}},
                    {{2, 6, 3}},
                    {{3, 6, 7}},
                    {{0, 4, 2}},
                    {{4, 6, 2}},
                    {{1, 3, 5}},
                    {{3, 7, 5}}};
    return result;
  }

  /** A box that a corner is drawn in of, so that edges there are hollow. */
  TriangleSurface
  wedge()
  {
    Tensor<1, 3> half_size;
    for (unsigned int d = 0; d < 3; ++d)
      half_size[d] = 0.7;
    TriangleSurface result = box_surface(half_size);
    result.corners[7]      = dealii::Point<3>(0.1, 0.2, 0.15);
    return result;
  }

  /** A mesh of a box is that box, with all derivatives; also on its faces. */
  void
  check_mesh()
  {
    const auto box = shape_of<3>("box",
                                 "set Size = 1.2, 0.8, 1\n"
                                 "set Rounding = 0.15\n");
    const auto mesh =
      MeshShape(box_surface(Tensor<1, 3>({0.45, 0.25, 0.35})), 0.15);
    double off = 0., bent = 0., above = 0.;
    for (unsigned int i = 0; i < 3000; ++i)
      {
        Tensor<1, 3> r = random_vector<3>(0.8);
        if (i % 3 == 0) // above the line between two triangles
          r = Tensor<1, 3>({0.45 * r[0], 0.25 * r[0], 0.6});
        const auto one = mesh.distance(r), other = box->distance(r);
        off   = std::max({off,
                          std::abs(one.value - other.value),
                          (one.normal - other.normal).norm()});
        bent  = std::max(bent,
                        (one.curvature - other.curvature).norm() /
                          (1. + other.curvature.norm()));
        above = std::max(above, mesh.least_distance(r) - one.value);
      }
    at_most("mesh of a box: distance and normal", off, 1e-12);
    at_most("mesh of a box: curvature", bent, 1e-9);
    at_most("mesh of a box: bound above its distance", above, 1e-15);
  }

  template <int dim>
  std::vector<std::pair<std::string, std::unique_ptr<ToolShape<dim>>>>
  all_shapes()
  {
    const std::string direction = list<dim>({0.3, -0.8, 0.5});
    std::vector<std::pair<std::string, std::string>> given{
      {"plane", "set Normal = " + direction + "\n"},
      {"ball", "set Radius = 0.7\n"},
      {"box",
       "set Size = " + list<dim>({1.2, 0.8, 1.}) + "\nset Rounding = 0.3\n"},
      {"cone",
       "set Axis = " + direction +
         "\nset Half angle = 35\nset Tip radius = 0.2\n"}};
    if (dim == 3)
      {
        const std::string axis = "set Axis = " + direction + "\n";
        given.emplace_back("cylinder", axis + "set Radius = 0.6\n");
        given.emplace_back("cylinder",
                           axis + "set Radius = 0.6\nset Length = 1.1\n"
                                  "set Rounding = 0.25\n");
      }
    std::vector<std::pair<std::string, std::unique_ptr<ToolShape<dim>>>> result;
    for (const auto &[name, statements] : given)
      result.emplace_back(name, shape_of<dim>(name, statements));
    if constexpr (dim == 3)
      result.emplace_back("mesh", std::make_unique<MeshShape>(wedge(), 0.1));
    return result;
  }

  /**
   * The error of a derivative against centred differences with steps h and
   * h/10, over the size of the derivative: small, or it falls with h^2.
   */
  template <class Function, int dim, class Derivative>
  bool
  is_derivative(const Function       &function,
                const Tensor<1, dim> &x,
                const Derivative     &derivative,
                const double          scale)
  {
    double errors[2] = {0., 0.};
    double h         = 1e-4;
    for (double &error : errors)
      {
        for (unsigned int d = 0; d < dim; ++d)
          {
            Tensor<1, dim> up = x, down = x;
            up[d] += h;
            down[d] -= h;
            error = std::max(
              error,
              derivative(d, (1. / (2. * h)) * (function(up) - function(down))));
          }
        h /= 10.;
      }
    return errors[1] <= 1e-9 * scale || errors[1] <= 0.02 * errors[0];
  }

  template <int dim>
  void
  check_shapes()
  {
    for (const auto &[name, shape] : all_shapes<dim>())
      {
        const std::string what = std::to_string(dim) + "D, " + name;
        unsigned int      n    = 0;
        for (unsigned int i = 0; i < 400; ++i)
          {
            const auto r    = random_vector<dim>(1.2);
            const auto here = shape->distance(r);
            // a kink next to the point is no error: in few of them
            if (std::abs(here.value) > 0.15)
              continue;
            ++n;
            check(std::abs(here.normal.norm() - 1.) < 1e-14,
                  what + ": the normal has length 1");
            check(std::abs(
                    shape->distance(r - here.value * here.normal).value) <
                    1e-14,
                  what + ": along the normal it is that far to the surface");
            n += !is_derivative(
              [&](const auto &x) { return shape->distance(x).value; },
              r,
              [&](const unsigned int d, const double slope) {
                return std::abs(slope - here.normal[d]);
              },
              1.);
            check(is_derivative(
                    [&](const auto &x) { return shape->distance(x).normal; },
                    r,
                    [&](const unsigned int d, const auto &slope) {
                      return (slope - here.curvature[d]).norm();
                    },
                    5.),
                  what + ": curvature");
          }
        check(n > 20, what + ": enough points are near the surface");
      }
  }

  /** A point near the surface, with a way that may cross it. */
  template <int dim>
  ContactPoint<dim>
  random_point(const ToolShape<dim> &shape, const bool has_spring)
  {
    ContactPoint<dim> point;
    do
      point.place = random_vector<dim>(1.2);
    while (std::abs(shape.distance(point.place).value) > 0.1);
    if (has_spring && shape.distance(point.place).value < 0.)
      point.spring = random_vector<dim>(0.01);
    return point;
  }

  template <int dim>
  void
  check_contact()
  {
    double       error = 0., least_slip = 0.;
    unsigned int n_acting = 0, n_sliding = 0, n_sticking = 0, n_wrong = 0;
    for (const auto &[name, shape] : all_shapes<dim>())
      for (unsigned int i = 0; i < 2000; ++i)
        {
          const bool       has_friction = i % 2 == 0, is_held = i % 7 == 3;
          const ContactLaw law{3., has_friction ? 0.4 : 0., 0.9};
          auto             point = random_point(*shape, has_friction);
          point.is_held          = is_held && !has_friction;
          // also ways that are next to nothing
          const auto   way  = random_vector<dim>(i % 5 == 0 ? 1e-9 : 0.08);
          const auto   here = contact(*shape, law, point, way);
          const double size = 3. * 0.01;
          error             = std::max(error,
                           std::abs(here.force * way + here.stored +
                                    here.spring_stored + here.slip) /
                             size);
          least_slip        = std::min(least_slip, here.slip / size);
          if (!here.acts)
            continue;
          ++n_acting;
          n_sliding += here.slip > 1e-6;
          n_sticking += has_friction && here.slip < 1e-12;
          const bool is_right = is_derivative(
            [&](const auto &w) { return contact(*shape, law, point, w).force; },
            way,
            [&](const unsigned int d, const auto &slope) {
              Tensor<1, dim> column;
              for (unsigned int c = 0; c < dim; ++c)
                column[c] = here.derivative[c][d];
              return (slope - column).norm();
            },
            10.);
          n_wrong += !is_right;
        }
    const std::string what = std::to_string(dim) + "D";
    at_most(what + ": work that is neither stored nor lost", error, 1e-14);
    at_most(what + ": slip that gives energy", -least_slip, 1e-15);
    std::cout << n_acting << " act, " << n_sliding << " slide, " << n_sticking
              << " stick, " << n_wrong << " next to a change\n";
    check(n_sliding > 100 && n_sticking > 100, "points slide, and stick");
    // within 1e-4 of a change of contact, friction or edge
    check(n_wrong < 0.02 * n_acting, what + ": derivative of the force");
  }

  template <int dim>
  void
  check_motion()
  {
    dealii::ParameterAcceptor::clear();
    Section                   section("tool");
    ToolMotionParameters<dim> parameters;
    parameters.declare(section);
    parameters.reference_point = {0.2, -0.1};
    parameters.axis            = {0.3, 1., -0.4};
    parameters.displacement    = "0.3*t; t^2";
    if (dim == 3)
      {
        parameters.reference_point.push_back(0.5);
        parameters.displacement += "; -t";
      }
    parameters.rotation = "0.4 + 0.7*t - 0.2*t^2";
    const ToolMotion<dim> motion(parameters, section);
    const auto Q_old = motion.directions(0.3), Q_new = motion.directions(0.8);
    const ToolStep<dim>  step  = motion.over(0.3, 0.5);
    const Tensor<1, dim> d_old = random_vector<dim>(1.),
                         d_new = d_old + random_vector<dim>(0.4);
    const Tensor<1, dim> from  = 0.5 * (d_old + d_new);
    const Tensor<1, dim> in_frame =
      transpose(Q_new) * d_new - transpose(Q_old) * d_old;
    const Tensor<1, dim> way =
      transpose(step.to_space) * (d_new - d_old - step.spin * from);
    at_most("turning tool: way in its frame", (way - in_frame).norm(), 1e-15);
    at_most("turning tool: step of the reference point",
            (motion.place(0.3) + step.displacement - motion.place(0.8)).norm(),
            1e-15);
    // a point of the tool does not move in its frame
    const Tensor<1, dim> carried = Q_new * (transpose(Q_old) * d_old);
    at_most("turning tool: what is carried along stays",
            (transpose(step.to_space) *
             (carried - d_old - 0.5 * (step.spin * (carried + d_old))))
              .norm(),
            1e-15);
    // a shape is drawn where its tool is: each facet, and all around it
    const dealii::Point<dim> place = motion.place(0.8);
    dealii::Point<dim>       lower, upper;
    for (unsigned int d = 0; d < dim; ++d)
      {
        lower[d] = place[d] - 2.;
        upper[d] = place[d] + 2.;
      }
    const double cell = 4. / (dim == 2 ? 200 : 40);
    for (const auto &[name, shape] : all_shapes<dim>())
      {
        double             off = 0.;
        Tensor<1, dim>     least, most;
        const Surface<dim> drawn =
          surface_of(*shape, place, Q_new, lower, upper);
        for (const auto &facet : drawn.facets)
          for (const auto &vertex : facet)
            {
              const Tensor<1, dim> r = transpose(Q_new) * (vertex - place);
              off = std::max(off, std::abs(shape->distance(r).value));
              for (unsigned int d = 0; d < dim; ++d)
                {
                  least[d] = std::min(least[d], vertex[d] - place[d]);
                  most[d]  = std::max(most[d], vertex[d] - place[d]);
                }
            }
        at_most(name + " as drawn: off its surface, in cells",
                off / cell,
                name == "mesh" ? 0.15 : 0.1); // hollow edges are sharp
        check((most - least).norm() > 0.3, name + " is drawn");
      }
    parameters.displacement = "";
    parameters.displacement_table =
      dim == 2 ? "0: 0, 1; 2: 4, 1" : "0: 0, 1, 0; 2: 4, 1, 0";
    const auto tabled =
      ToolMotion<dim>(parameters, section).place(0.5) - motion.place(0.);
    at_most("table of displacements",
            std::abs(tabled[0] - 1.) + std::abs(tabled[1] - 1.),
            1e-15);
    // v is 1 m/s until 1 s, grows to 3 until 3 s, and stays; across it to 2
    parameters.displacement_table = "";
    parameters.velocity_table =
      dim == 2 ? "1: 1, 0; 3: 3, 2" : "1: 1, 0, 0; 3: 3, 2, 0";
    const ToolMotion<dim> by_velocity(parameters, section);
    double                off = 0.;
    for (const auto &[time, x, y] : {std::array<double, 3>{{0., 0., 0.}},
                                     {{0.5, 0.5, 0.}},
                                     {{2., 2.5, 0.5}},
                                     {{3., 5., 2.}},
                                     {{4., 8., 4.}}})
      {
        const auto way = by_velocity.place(time) - motion.place(0.);
        off = std::max({off, std::abs(way[0] - x), std::abs(way[1] - y)});
      }
    at_most("table of velocities", off, 1e-14); // of 8 m
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_mesh();
  check_shapes<2>();
  check_shapes<3>();
  check_contact<2>();
  check_contact<3>();
  check_motion<2>();
  check_motion<3>();
  return test::report();
}
