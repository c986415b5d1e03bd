// Loads on surfaces: a traction gives a free body the momentum t A dt, whatever
// the depth of its region; a pressure all around gives none, no angular
// momentum, and does the work -p times what the volume gains, while the body
// spins and stretches; pressures on all sides one by one do the same where the
// body deforms alike.

#include "tangent.h"

using namespace emmy;

namespace
{
  /** A free block that spins, drifts and breathes. */
  std::string
  block(const unsigned int dim)
  {
    const bool        in_space = dim == 3;
    const std::string one      = in_space ? ", 1" : "";
    return "set Dimension = " + std::to_string(dim) +
           "\nsubsection Grid\nset Lower corner = 0, 0" +
           (in_space ? ", 0" : "") + "\nset Upper corner = 4, 4" +
           (in_space ? ", 4" : "") + "\nset Cells = 8, 8" +
           (in_space ? ", 8" : "") +
           "\nend\nsubsection Materials\nset Names = m\nsubsection m\n"
           "set Model = Hencky\nset Density = 2\nset Young's modulus = 100\n"
           "set Poisson's ratio = 0.3\nend\nend\n"
           "subsection Bodies\nset Names = b\nsubsection b\nset Shape = box\n"
           "set Material = m\nset Points per direction = 2\n"
           "set Initial velocity = 0.1-2*(y-2)+0.8*(x-2); 2*(x-2)+0.3*(y-2)" +
           std::string(in_space ? "; 0.4*(z-1.5)+0.5*x" : "") +
           "\nsubsection box\nset Lower corner = 1.25, 1.5" + one +
           "\nset Upper corner = 2.75, 2.5" + (in_space ? ", 2" : "") +
           "\nend\nend\nend\nsubsection Effects\nset Names = surface loads\nend\n"
           "subsection Time\nset End time = 1\nset Step rule = fixed\n"
           "set Step size = 0.05\nend\n"
           "subsection Solver\nset Newton tolerance = 1e-14\nend\n";
  }

  ParameterFile
  with(const unsigned int              dim,
       const std::vector<std::string> &names,
       const std::vector<std::string> &sets)
  {
    std::string text =
      block(dim) + "subsection Effects\nsubsection Surface loads\nset Names = ";
    for (const std::string &name : names)
      text += (name == names[0] ? "" : ", ") + name;
    ParameterFile file =
      ParameterFile::from_text(text + "\nend\nend\n", "test");
    for (const std::string &set : sets)
      file.set(set);
    return file;
  }

  /** Under pressures, one all around and one on a side. */
  std::string
  pressed(const unsigned int dim, const std::string &geometry)
  {
    return block(dim) + "subsection Method\nset Geometry = " + geometry +
           "\nend\nsubsection Effects\nsubsection Surface loads\n"
           "set Names = around, beside\nsubsection around\nset Pressure = 5\nend\n"
           "subsection beside\nset Pressure = 8\nset Side = x-max\nend\n"
           "end\nend\n";
  }

  /** sum V0 det F. */
  template <int dim>
  double
  volume(const Scene<dim> &scene)
  {
    const unsigned int F = scene.layout["deformation_gradient"],
                       V = scene.layout["reference_volume"];
    double sum           = 0.;
    for (const auto &particle : scene.particles)
      {
        const auto             fields = particle.get_properties();
        dealii::Tensor<2, dim> here;
        for (unsigned int i = 0; i < dim; ++i)
          for (unsigned int j = 0; j < dim; ++j)
            here[i][j] = fields[F + dim * i + j];
        sum += fields[V] * determinant(here);
      }
    return dealii::Utilities::MPI::sum(sum, MPI_COMM_WORLD);
  }

  template <int dim>
  void
  check_all_around(const std::string       &name,
                   const double             p,
                   std::vector<std::string> sets)
  {
    sets.push_back("Effects/Surface loads/water/Pressure=" + std::to_string(p));
    test::RunningScene<dim> run{
      SceneParameters<dim>(with(dim, {"water"}, sets))};
    const double at_start = volume(run.scene);
    run.advance(dim == 2 ? 20 : 6);
    const double gain = volume(run.scene) - at_start;
    const auto   work = run.column("pressure_water_work");
    const double scale =
      run.column("kinetic_energy")[0] + std::abs(work.back());
    test::check(std::abs(gain) > 0.01 * at_start, name + ": it changes");
    test::at_most(name + ": work + p dV",
                  std::abs(work.back() + p * gain) / scale,
                  1e-11);
    test::at_most(name + ": balance",
                  std::abs(run.column("balance_error").back()) / scale,
                  1e-12);
    const auto m = run.column("linear_momentum_x");
    test::at_most(name + ": resultant of a closed surface over p A",
                  std::abs(m.back() - m[0]) / (p * 5.),
                  1e-11);
    const auto J = run.column("angular_momentum_z");
    test::at_most(name + ": moment",
                  std::abs(J.back() - J[0]) / std::abs(J[0]),
                  1e-10);
    const auto its = run.column("newton_iterations");
    test::at_most(name + ": iterations in a step",
                  *std::max_element(its.begin(), its.end()),
                  8.); // a fifth of E presses
  }

  /** Each side by itself, for a step so short that F is known. */
  template <int dim>
  void
  check_sides(const std::string &name, std::vector<std::string> sets)
  {
    std::vector<std::string> names;
    for (unsigned int side = 0; side < 2 * dim; ++side)
      {
        names.push_back("side" + std::to_string(side));
        const std::string section = "Effects/Surface loads/" + names.back();
        sets.push_back(section + "/Side=" + side_names(dim)[side]);
        sets.push_back(section + "/Pressure=20");
      }
    sets.push_back("Time/Step size=1e-8");
    test::RunningScene<dim> run{SceneParameters<dim>(with(dim, names, sets))};
    const double            at_start = volume(run.scene);
    run.advance(1);
    double work = 0.;
    for (const std::string &side : names)
      work += run.column("pressure_" + side + "_work").back();
    // div v V p dt
    const double dV = (dim == 2 ? 1.1 : 1.5) * at_start * 1e-8;
    test::check_close(work / (-20. * dV), 1., 1e-4, name + ": sides do p dV");
  }

  template <int dim>
  void
  check_traction(const std::string &name, std::vector<std::string> sets)
  {
    for (const char *set :
         {"Side=y-max", "Region=y-2.1", "Amplitude table=0: 0, 0.5: 1"})
      sets.push_back(std::string("Effects/Surface loads/t/") + set);
    sets.push_back(std::string("Effects/Surface loads/t/Traction=3; -7") +
                   (dim == 3 ? "; 1" : ""));
    test::RunningScene<dim> run{SceneParameters<dim>(with(dim, {"t"}, sets))};
    run.advance(dim == 2 ? 20 : 5);
    const double t = run.column("time").back(); // int a dt
    const double a = t <= 0.5 ? t * t : t - 0.25;
    const auto   y = run.column("linear_momentum_y");
    test::check_close((y.back() - y[0]) / (-7. * 1.5 * a),
                      1.,
                      1e-11,
                      name + ": momentum");
    test::at_most(name + ": balance",
                  std::abs(run.column("balance_error").back()) /
                    run.column("kinetic_energy")[0],
                  1e-12);
  }
  /** A column between rollers under a dead load q, E ln(l)/l = -q, at rest. */
  void
  check_static()
  {
    ParameterFile         file = with(2,
                              {"t"},
                              {"Grid/Upper corner=1, 4",
                                       "Grid/Cells=2, 8",
                                       "Bodies/b/Initial velocity=",
                                       "Bodies/b/box/Lower corner=0, 0",
                                       "Bodies/b/box/Upper corner=1, 3",
                                       "Boundary conditions/Roller=x-min, x-max, y-min",
                                       "Materials/m/Poisson's ratio=0",
                                       "Time/Integrator=static",
                                       "Time/Step rule=fixed",
                                       "Time/Increments=4",
                                       "Effects/Surface loads/t/Side=y-max",
                                       "Effects/Surface loads/t/Traction=0; -30"});
    test::RunningScene<2> run{SceneParameters<2>(file)};
    run.advance(4);
    const double l = volume(run.scene) / 3.;
    // the end's weights reach a node beyond its box: 0.11 %
    test::check_close(-100. * std::log(l) / l / 30.,
                      1.,
                      2e-3,
                      "static column under a traction");
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::vector<std::string> linear{"Method/Shape functions=linear",
                                        "Method/Geometry=start"};
  const std::vector<std::string> gimp{"Method/Shape functions=GIMP",
                                      "Method/Geometry=start"};
  check_all_around<2>("GIMP, middle", 20., {});
  check_all_around<2>("GIMP, start", 20., gimp);
  check_all_around<2>("linear, start", 20., linear);
  check_all_around<3>("in space, linear, start", 20., linear);
  check_all_around<3>("in space, GIMP, middle", 20., {});
  check_sides<2>("GIMP, middle", {});
  check_sides<2>("linear, start", linear);
  check_sides<3>("in space", {});
  check_traction<2>("GIMP, middle", {});
  check_traction<2>("linear, start", linear);
  check_traction<3>("in space", linear);
  check_static();
  test::check_tangent_of_start<2>(pressed(2, "start"));
  test::check_tangent_of_start<3>(pressed(3, "start"));
  test::check_tangent_of_middle<2>(pressed(2, "middle"));
  test::check_tangent_of_middle<3>(pressed(3, "middle"));
  const auto refused = [](const std::vector<std::string> &sets,
                          const std::vector<std::string> &words) {
    test::check_throws_with(
      [&] {
        test::RunningScene<2> run{SceneParameters<2>(with(2, {"t"}, sets))};
      },
      words);
  };
  const std::string t = "Effects/Surface loads/t/";
  refused({}, {"Surface loads/t", "Pressure", "needs this"});
  refused({t + "Traction=0; 1"}, {"Side", "a traction needs a side"});
  refused({t + "Traction=0; 1", t + "Pressure=1", t + "Side=x-min"},
          {"Pressure", "Remove one"});
  refused({t + "Pressure=1", t + "Region=x-10"},
          {"Surface loads/t", "no particle"});
  return test::report();
}
