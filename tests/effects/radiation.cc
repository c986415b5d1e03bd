// What damps, and what takes up waves: a pulse that meets a viscous side leaves
// (Lysmer and Kuhlemeyer 1969), at its front as at its flank; what is in the
// body and what has left are what was put in. Mass damping stops a free body as
// exp(-rate t), to the second order in the step.

#include "../check.h"
#include "../scene.h"

using namespace emmy;

namespace
{
  /** A bar of 10 m in a tube, c_p = 10 m/s, with a pulse in its middle. */
  std::string
  bar(const std::string &velocity)
  {
    return "set Dimension = 2\n"
           "subsection Grid\nset Upper corner = 10, 0.25\nset Cells = 80, 2\nend\n"
           "subsection Materials\nset Names = m\nsubsection m\n"
           "set Model = Hencky\nset Density = 2\nset Young's modulus = 200\n"
           "set Poisson's ratio = 0\nend\nend\n"
           "subsection Bodies\nset Names = b\nsubsection b\nset Shape = box\n"
           "set Material = m\nset Points per direction = 2\n"
           "set Initial velocity = " +
           velocity +
           "\nsubsection box\nset Lower corner = 0, 0\nset Upper corner = 10, 0.25\nend\nend\nend\n"
           "subsection Time\nset End time = 2\nset Step rule = fixed\n"
           "set Step size = 0.005\nend\n"
           "subsection Solver\nset Newton tolerance = 1e-13\nend\n";
  }
  const std::string pulse = "1e-3*exp(-(x-5)^2/0.5)";

  double
  last(const test::RunningScene<2> &run, const std::string &column)
  {
    return run.column(column).back();
  }

  void
  check_pulse(const std::string              &name,
              const std::string              &velocity,
              const unsigned int              n_steps,
              const std::vector<std::string> &sets)
  {
    ParameterFile file = ParameterFile::from_text(bar(velocity), "test");
    file.set("Effects/Names=viscous sides");
    file.set("Effects/Viscous sides/Sides=x-min, x-max");
    for (const std::string &set : sets)
      file.set(set);
    test::RunningScene<2> run{SceneParameters<2>(file)};
    const double          put_in = last(run, "kinetic_energy");
    run.advance(n_steps);
    const double inside =
      last(run, "kinetic_energy") + last(run, "strain_energy");
    const auto radiated = run.column("radiated_energy");
    test::at_most(name + ": share that came back", inside / put_in, 0.01);
    test::at_most(name + ": in = inside + out + what the map loses",
                  std::abs(last(run, "balance_error")) / put_in,
                  1e-12);
    test::check(radiated.back() > 0.95 * put_in, name + ": it left");
    test::check(std::is_sorted(radiated.begin(), radiated.end()),
                name + ": nothing comes in");
  }

  /**
   * A block moves as a whole along two sides that meet it. In a step so short
   * that no wave gets far they take up rho c v^2 for each area and time, with
   * the speed of pressure waves on one and that of shear waves on the other.
   */
  template <int dim>
  void
  check_traction(const std::string &name, const std::vector<std::string> &sets)
  {
    const std::string end  = dim == 3 ? ", 1" : "";
    ParameterFile     file = ParameterFile::from_text(
      "set Dimension = " + std::to_string(dim) +
        "\nsubsection Grid\nset Lower corner = 0, 0" + (dim == 3 ? ", 0" : "") +
        "\nset Upper corner = 2, 2" + end + "\nset Cells = 8, 8" +
        (dim == 3 ? ", 4" : "") +
        "\nend\nsubsection Materials\nset Names = m\nsubsection m\n"
            "set Model = Hencky\nset Density = 2\nset Young's modulus = 200\n"
            "set Poisson's ratio = 0.25\nend\nend\n"
            "subsection Bodies\nset Names = b\nsubsection b\nset Shape = box\n"
            "set Material = m\nset Points per direction = 2\n"
            "set Initial velocity = 3; 0" +
        (dim == 3 ? "; 0" : "") + "\nsubsection box\nset Lower corner = 1, 0" +
        (dim == 3 ? ", 0" : "") + "\nset Upper corner = 2, 1.5" + end +
        "\nend\nend\nend\nsubsection Effects\nset Names = viscous sides\n"
            "subsection Viscous sides\nset Sides = x-max, y-min\nend\nend\n"
            "subsection Time\nset End time = 1\nset Step rule = fixed\n"
            "set Step size = 1e-7\nend\n",
      "test");
    for (const std::string &set : sets)
      file.set(set);
    test::RunningScene<dim> run{SceneParameters<dim>(file)};
    run.advance(1);
    const double c_p = std::sqrt(240. / 2.), c_s = std::sqrt(80. / 2.);
    const double along_x_max = 1.5, along_y_min = 1.; // 1 m thick
    test::check_close(run.column("radiated_energy").back() /
                        (2. * (c_p * along_x_max + c_s * along_y_min) * 9. *
                         1e-7),
                      1.,
                      1e-4,
                      name + ": power at two sides");
  }

  /** A block that flies: v = v0 ((1 - r dt/2)/(1 + r dt/2))^n exactly. */
  template <int dim>
  void
  check_stop(const std::string &name, const std::vector<std::string> &sets)
  {
    const std::string one = dim == 3 ? ", 1" : "";
    const std::string text =
      "set Dimension = " + std::to_string(dim) +
      "\nsubsection Grid\nset Upper corner = 4, 2" + (dim == 3 ? ", 2" : "") +
      "\nset Cells = 8, 4" + (dim == 3 ? ", 4" : "") +
      "\nend\nsubsection Materials\nset Names = m\nsubsection m\n"
      "set Model = Hencky\nset Density = 2\nset Young's modulus = 200\n"
      "set Poisson's ratio = 0.3\nend\nend\n"
      "subsection Bodies\nset Names = b\nsubsection b\nset Shape = box\n"
      "set Material = m\nset Points per direction = 2\n"
      "set Initial velocity = 1; 0" +
      (dim == 3 ? "; 0" : "") + "\nsubsection box\nset Lower corner = 1, 0.5" +
      (dim == 3 ? ", 0.5" : "") + "\nset Upper corner = 2, 1.5" +
      (dim == 3 ? ", 1.5" : "") +
      "\nend\nend\nend\nsubsection Effects\nset Names = mass damping\n"
      "subsection Mass damping\nset Rate = 2\nend\nend\n"
      "subsection Time\nset End time = 2\nset Step rule = fixed\n"
      "set Step size = 0.05\nend\n"
      "subsection Solver\nset Newton tolerance = 1e-13\nend\n";
    ParameterFile file = ParameterFile::from_text(text, "test");
    for (const std::string &set : sets)
      file.set(set);
    test::RunningScene<dim> run{SceneParameters<dim>(file)};
    run.advance(20);
    const auto   p = run.column("linear_momentum_x");
    const double r = 0.05; // rate dt / 2
    test::check_close(p.back() / p[0],
                      std::pow((1. - r) / (1. + r), 20),
                      1e-11,
                      name + ": momentum");
    const auto loss = run.column("damping_loss");
    test::check(std::is_sorted(loss.begin(), loss.end()), name + ": a loss");
    test::at_most(name + ": balance",
                  std::abs(run.column("balance_error").back()) /
                    run.column("kinetic_energy")[0],
                  1e-12);
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::vector<std::string>           tube = {
              "Boundary conditions/Roller=y-min, y-max"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.end(), tube.begin(), tube.end());
    return more;
  };
  check_pulse("pressure, GIMP, middle", pulse + "; 0", 200, tube);
  check_pulse("pressure, linear, start",
              pulse + "; 0",
              200,
              with({"Method/Shape functions=linear", "Method/Geometry=start"}));
  check_traction<2>("GIMP, middle", {});
  check_traction<2>("linear, start",
                    {"Method/Shape functions=linear", "Method/Geometry=start"});
  check_traction<3>("in space", {});
  check_stop<2>("GIMP, middle", {});
  check_stop<2>("linear, start",
                {"Method/Shape functions=linear", "Method/Geometry=start"});
  check_stop<3>("in space", {});
  test::check_throws_with(
    [] {
      ParameterFile file = ParameterFile::from_text(bar("0; 0"), "test");
      file.set("Effects/Names=viscous sides");
      test::RunningScene<2> run{SceneParameters<2>(file)};
    },
    {"Viscous sides", "Sides", "it is required"});
  test::check_throws_with(
    [] {
      ParameterFile file = ParameterFile::from_text(bar("0; 0"), "test");
      file.set("Effects/Names=viscous sides");
      file.set("Effects/Viscous sides/Sides=x-min, x-min");
      test::RunningScene<2> run{SceneParameters<2>(file)};
    },
    {"Viscous sides", "Sides", "stands there twice"});
  test::check_throws_with(
    [] {
      ParameterFile file = ParameterFile::from_text(bar("0; 0"), "test");
      file.set("Effects/Names=mass damping");
      test::RunningScene<2> run{SceneParameters<2>(file)};
    },
    {"Mass damping", "Rate", "must be positive"});
  return test::report();
}
