// Facts about tools. Random states: the force of a contact point does exactly
// the work that is stored or lost, for each shape, turning or not; distances
// and forces have the derivatives that they say, with the order of a centred
// difference; the equation of a whole step too, whether places stay or follow.

#include <emmy/effects/tool_contact.h>
#include <emmy/effects/tool_motion.h>
#include <emmy/step/middle_equation.h>

#include <random>

#include "../check.h"
#include "../scene.h"

using namespace emmy;
using dealii::Tensor;
using test::at_most;
using test::check;

namespace
{
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
    parameters.displacement = "";
    parameters.displacement_table =
      dim == 2 ? "0: 0, 1; 2: 4, 1" : "0: 0, 1, 0; 2: 4, 1, 0";
    const auto tabled =
      ToolMotion<dim>(parameters, section).place(0.5) - motion.place(0.);
    at_most("table of displacements",
            std::abs(tabled[0] - 1.) + std::abs(tabled[1] - 1.),
            1e-15);
  }

  /** A soft block in a corner of tools, some of which turn. */
  template <int dim>
  std::string
  cornered(const std::string &geometry)
  {
    const auto in = [](const std::string &plane, const std::string &space) {
      return dim == 2 ? plane : space;
    };
    return "set Dimension = " + std::to_string(dim) +
           "\nsubsection Grid\nset Lower corner = " + in("0, 0", "0, 0, 0") +
           "\nset Upper corner = " + in("3, 3", "3, 3, 3") +
           "\nset Cells = " + in("6, 6", "6, 6, 6") +
           "\nend\nsubsection Method\nset Geometry = " + geometry +
           "\nset Starved nodes = follow\nend\n"
           "subsection Materials\nset Names = m\nsubsection m\n"
           "set Model = Hencky\nset Density = 5\n"
           "set Young's modulus = 100\nset Poisson's ratio = 0.3\nend\nend\n"
           "subsection Bodies\nset Names = block\nsubsection block\n"
           "set Shape = box\nset Material = m\nset Points per direction = 2\n"
           "set Initial velocity = -0.9 + 0.2*y; -0.4 + 0.3*x" +
           in("", "; 0.2*x") +
           "\nsubsection box\nset Lower corner = " + in("1, 1", "1, 1, 1") +
           "\nset Upper corner = " + in("2, 2", "2, 2, 1.5") +
           "\nend\nend\nend\nsubsection Effects\nset Names = tools\n"
           "subsection Tools\nset Names = floor, drum, punch\n"
           "subsection floor\nset Shape = plane\nset Friction coefficient = "
           "0.3\nset Reference point = " +
           in("1, 0.98", "1, 0.98, 0") +
           "\nset Displacement = " + in("0.1*t; 0.4*t", "0.1*t; 0.4*t; 0") +
           "\nsubsection plane\nset Normal = " + in("0.05, 1", "0.05, 1, 0.1") +
           "\nend\nend\nsubsection drum\nset Shape = ball\n"
           "set Stiffness = 4\nset Friction coefficient = 5\n"
           "set Reference point = " +
           in("0.5, 1.6", "0.5, 1.6, 1.2") + "\nset Rotation = 2*t\n" +
           in("", "set Rotation axis = 0.1, 0.2, 1\n") +
           "subsection ball\nset Radius = 0.53\nend\nend\n"
           "subsection punch\nset Shape = box\nset Reference point = " +
           in("1.6, 2.2", "1.6, 2.2, 1.2") +
           "\nset Displacement = " + in("0; -0.5*t", "0; -0.5*t; 0") +
           "\nset Rotation = -t\n" + in("", "set Rotation axis = 0, 0, 1\n") +
           "subsection box\nset Size = " + in("0.5, 0.5", "0.5, 0.5, 0.5") +
           "\nset Rounding = 0.25\nend\nend\nend\nend\n"
           "subsection Time\nset End time = 1\nset Step rule = fixed\n"
           "set Step size = 0.04\nend\n"
           "subsection Solver\nset Newton tolerance = 1e-15\nend\n";
  }

  /** Balances of a run, and that all that can happen does. */
  template <int dim>
  void
  check_run(const std::string &geometry)
  {
    const SceneParameters<dim> parameters(
      ParameterFile::from_text(cornered<dim>(geometry), "test"));
    test::RunningScene<dim> run(parameters);
    run.advance(dim == 2 ? 12 : 4);
    const std::string what  = std::to_string(dim) + "D, " + geometry + ": ";
    const double      scale = test::largest(run.column("kinetic_energy"));
    at_most(what + "balance of energy",
            test::largest(run.column("balance_error")) / scale,
            1e-12);
    const auto lost  = run.column("friction_dissipation");
    double     least = 0.;
    for (unsigned int row = 1; row < lost.size(); ++row)
      least = std::min(least, lost[row] - lost[row - 1]);
    at_most(what + "slip that gives energy", -least / scale, 1e-15);
    for (const char *column :
         {"contact_energy", "friction_energy", "friction_dissipation"})
      check(std::abs(run.ledger[column]) > 1e-6 * scale,
            what + "there is " + column);
    for (const char *tool : {"floor", "drum", "punch"})
      check(test::largest(run.column(std::string("tool_") + tool + "_work")) >
              1e-3 * scale,
            what + tool + " works");
    // the impulses of the tools are what the body gains
    const auto dt = run.column("time_step");
    for (unsigned int d = 0; d < dim; ++d)
      {
        const std::string axis(1, "xyz"[d]);
        const auto        momentum = run.column("linear_momentum_" + axis);
        double            sum      = momentum.back() - momentum.front();
        for (const char *tool : {"floor", "drum", "punch"})
          {
            const auto force =
              run.column(std::string("tool_") + tool + "_force_" + axis);
            for (unsigned int row = 1; row < dt.size(); ++row)
              sum += dt[row] * force[row];
          }
        at_most(what + "momentum without a tool",
                std::abs(sum) / test::largest(momentum),
                1e-11);
      }
    // and their moments, about the origin
    const auto spin = run.column("angular_momentum_z");
    double     sum  = spin.back() - spin.front();
    for (const char *tool : {"floor", "drum", "punch"})
      {
        const auto of = [&](const char *name) {
          return run.column(std::string("tool_") + tool + name);
        };
        const auto x = of("_x"), y = of("_y"), fx = of("_force_x"),
                   fy = of("_force_y"), moment = of("_moment_z");
        for (unsigned int row = 1; row < dt.size(); ++row)
          sum +=
            dt[row] * (moment[row] + 0.5 * (x[row] + x[row - 1]) * fy[row] -
                       0.5 * (y[row] + y[row - 1]) * fx[row]);
      }
    at_most(what + "angular momentum without a tool",
            std::abs(sum) / test::largest(spin),
            geometry == "start" ? 1e-11 : 1e-8);
  }

  /** J du of an equation that is solved, and how r changes along du. */
  template <int dim>
  void
  check_tangent(NonlinearEquation    &equation,
                const GridStart<dim> &start,
                Vector               &solution,
                const std::string    &what)
  {
    equation.evaluate(solution, true);
    Vector direction = solution;
    for (auto &entry : direction)
      entry = random(-1., 1.);
    equation.expand(direction);
    Vector expected = solution;
    equation.jacobian().vmult(expected, direction);
    start.active->constraints().set_zero(expected); // followers have none
    double error = 0.;
    for (const double h : {1e-6, 1e-7})
      {
        Vector step = direction;
        step *= h;
        Vector change = solution;
        for (const int sign : {1, -1})
          {
            equation.take(solution, step);
            check(equation.evaluate(solution, false), what + ": has meaning");
            if (sign == 1)
              change = equation.residual();
            else
              change -= equation.residual();
            equation.take_back(solution, step);
            equation.evaluate(solution, true);
            step *= -1.;
          }
        change *= 1. / (2. * h);
        change -= expected;
        error = change.l2_norm() / expected.l2_norm();
      }
    at_most(what + ": derivative of the whole step", error, 2e-7);
  }

  template <int dim>
  void
  check_tangent_of_start()
  {
    const SceneParameters<dim> parameters(
      ParameterFile::from_text(cornered<dim>("start"), "test"));
    Scene<dim> scene(parameters, MPI_COMM_WORLD);
    scene.initial_report();
    scene.advance();
    scene.advance();
    const auto stencils =
      scene.shape_functions->evaluate(scene.particles, scene.grid);
    const auto           points = gather(stencils, scene.layout);
    ParticlesToGrid<dim> to_grid(scene.grid,
                                 scene.boundary_conditions,
                                 scene.layout,
                                 scene.mapping);
    scene.balance.classify(stencils, points, scene.grid, nullptr);
    auto &start         = to_grid(stencils,
                          points,
                          scene.balance.couplings(stencils,
                                                  scene.grid,
                                                  scene.boundary_conditions,
                                                  nullptr));
    start.velocity      = start.mean_velocity;
    const auto equation = scene.balance.over(
      {stencils, points, start, scene.state.time, 0.04, nullptr, nullptr});
    Vector u = start.mean_velocity;
    u *= 0.04;
    start.active->constraints().expand(u);
    check_tangent<dim>(*equation, start, u, std::to_string(dim) + "D, start");
  }

  template <int dim>
  void
  check_tangent_of_middle()
  {
    const SceneParameters<dim> parameters(
      ParameterFile::from_text(cornered<dim>("middle"), "test"));
    Scene<dim> scene(parameters, MPI_COMM_WORLD);
    scene.initial_report();
    scene.advance();
    scene.advance();
    Places<dim> places =
      scene.shape_functions->places(scene.particles, scene.grid);
    PointArrays<dim> states = gather(places, scene.layout);
    places                  = scene.middle->first(
      std::move(places), states, 0.04, scene.domain_update.get(), scene.grid);
    ParticlesToGrid<dim> to_grid(scene.grid,
                                 scene.boundary_conditions,
                                 scene.layout,
                                 scene.mapping);
    MiddleEquation<dim>  equation({{*scene.shape_functions,
                                    scene.domain_update.get(),
                                    scene.grid,
                                    scene.layout,
                                    scene.mapping},
                                   scene.balance,
                                   scene.boundary_conditions,
                                   to_grid,
                                   std::move(states),
                                   scene.state.time,
                                   0.04,
                                   1e-8,
                                   &scene.phases},
                                 std::move(places));
    Vector               u = equation.first_displacement();
    // places settle where u is; they may move 12 times in all
    for (unsigned int i = 0; i < 5; ++i)
      {
        equation.evaluate(u, true);
        Vector none = u;
        none        = 0.;
        equation.take(u, none);
      }
    check_tangent<dim>(equation,
                       equation.grid_start(),
                       u,
                       std::to_string(dim) + "D, middle");
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_shapes<2>();
  check_shapes<3>();
  check_contact<2>();
  check_contact<3>();
  check_motion<2>();
  check_motion<3>();
  for (const char *geometry : {"start", "middle"})
    {
      check_run<2>(geometry);
      check_run<3>(geometry);
    }
  check_tangent_of_start<2>();
  check_tangent_of_start<3>();
  check_tangent_of_middle<2>();
  check_tangent_of_middle<3>();
  return test::report();
}
