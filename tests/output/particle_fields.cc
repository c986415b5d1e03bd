// Facts about what is said of particles: in a body that is stretched, or
// sheared, stresses and strains have their closed forms, in 2D and 3D; the
// measurements of a particle and of a region are these; displacement is the
// way since the start, in a body that flies; names that a scene does not have
// are refused with the nearest one; who does not ask for displacements pays
// nothing for them.

#include "../check.h"
#include "../scene.h"

#include <emmy/math/kinematics.h>

#include <map>

using namespace emmy;
using dealii::Tensor;
using test::check;
using test::check_close;

namespace
{
  constexpr double K = 5e6 / 3., G = 1e6; // E = 2.5e6 Pa, nu = 0.25

  template <int dim>
  std::string
  block(const std::string &more)
  {
    const auto in_space = [](const std::string &text) {
      return dim == 3 ? text : std::string();
    };
    return "set Dimension = " + std::to_string(dim) +
           "\nsubsection Grid\nset Lower corner = 0, 0" + in_space(", 0") +
           "\nset Upper corner = 4, 4" + in_space(", 4") +
           "\nset Cells = 4, 4" + in_space(", 4") +
           "\nend\nsubsection Materials\nset Names = soil\n"
           "subsection soil\nset Model = Hencky\nset Density = 1000\n"
           "set Young's modulus = 2.5e6\nset Poisson's ratio = 0.25\nend\nend\n"
           "subsection Bodies\nset Names = block\n"
           "subsection block\nset Shape = box\nset Material = soil\n"
           "set Points per direction = 2\nset Initial velocity = 0.25, 0.5" +
           in_space(", 1") + "\nsubsection box\nset Lower corner = 1, 1" +
           in_space(", 1") + "\nset Upper corner = 2, 2" + in_space(", 2") +
           "\nend\nend\nend\nsubsection Time\nset End time = 1\n"
           "set Step rule = fixed\nset Step size = 0.125\nend\n" +
           more;
  }

  const std::string all_fields =
    "cauchy_stress, pressure, von_mises_stress, logarithmic_strain";

  std::string
  measurements(const unsigned int dim)
  {
    const std::string z = dim == 3 ? ", 1.25" : "";
    return "subsection Measurements\nset Names = tip, box\nsubsection tip\n"
           "set Type = particle\nset Nearest to = 1.25, 1.25" +
           z + "\nset Fields = position, " + all_fields +
           "\nend\nsubsection box\nset Type = mean\nset Fields = " +
           all_fields + "\nset Upper corner = 1.5, 4" +
           (dim == 3 ? ", 4" : "") + "\nend\nend\n";
  }

  /** What the measurements of a block say that is deformed by F everywhere. */
  template <int dim>
  std::map<std::string, double>
  measured(const Tensor<2, dim> &F)
  {
    const SceneParameters<dim> parameters(
      ParameterFile::from_text(block<dim>(measurements(dim)), "test"));
    test::RunningScene<dim> run(parameters);
    auto                    batch = std::make_unique<MaterialBatch<dim>>();
    batch->n_points               = 1;
    batch->with_tangent           = false;
    batch->left_cauchy_green_less_unit[0] =
      mandel::symmetric_part<dim>(F * transpose(F), 1.) - mandel::unit<dim>();
    const auto b = batch->left_cauchy_green_less_unit[0];
    run.scene.materials[0]->evaluate(*batch);
    for (auto &particle : run.scene.particles)
      for (unsigned int c = 0; c < n_mandel<dim>; ++c)
        {
          auto        properties = particle.get_properties();
          const auto &layout     = run.scene.layout;
          properties[layout["left_cauchy_green_less_unit"] + c] = b[c];
          properties[layout["kirchhoff_stress"] + c] =
            batch->kirchhoff_stress[0][c];
        }
    std::map<std::string, double> result;
    for (const auto &measurement : run.scene.measurements)
      for (const StepMeasure &value : measurement->measure(run.scene.particles))
        result[value.name] = value.value;
    return result;
  }

  template <int dim>
  void
  check_stretch()
  {
    const std::string name    = std::to_string(dim) + "D, stretched: ";
    const double      stretch = 1.1, e = std::log(stretch);
    Tensor<2, dim>    F = dealii::unit_symmetric_tensor<dim>();
    F[0][0]             = stretch;
    auto         m      = measured<dim>(F);
    const double xx     = (K + 4. / 3. * G) * e / stretch,
                 yy     = (K - 2. / 3. * G) * e / stretch;
    for (const std::string of : {"tip_", "box_"})
      {
        check_close(m[of + "cauchy_stress_xx"], xx, 1e-14 * xx, name + "xx");
        check_close(m[of + "cauchy_stress_yy"], yy, 1e-14 * xx, name + "yy");
        check_close(m[of + "cauchy_stress_zz"], yy, 1e-14 * xx, name + "zz");
        check_close(m[of + "cauchy_stress_xy"], 0., 1e-14 * xx, name + "xy");
        check_close(m[of + "pressure"],
                    -K * e / stretch,
                    1e-14 * xx,
                    name + "pressure");
        check_close(m[of + "von_mises_stress"],
                    2. * G * e / stretch,
                    1e-14 * xx,
                    name + "von Mises stress");
        check_close(m[of + "logarithmic_strain_xx"], e, 1e-15, name + "strain");
        check_close(m[of + "logarithmic_strain_yy"], 0., 1e-15, name + "none");
      }
    check_close(m["tip_x"], 1.25, 1e-15, name + "position");
    check_close(m["box_volume"],
                0.5 * stretch,
                1e-14,
                name + "half of the block is in the box");
    // stresses and strains of both, pressures, position and volume
    check(m.size() == 2 * (2 * (dim == 2 ? 4 : 6) + 2) + dim + 1,
          name + "a column for each component that differs");
  }

  template <int dim>
  void
  check_shear()
  {
    const std::string name  = std::to_string(dim) + "D, sheared: ";
    const double      shear = 0.5, e = std::asinh(0.5 * shear);
    const double      root = std::sqrt(4. + shear * shear);
    Tensor<2, dim>    F    = dealii::unit_symmetric_tensor<dim>();
    F[0][1]                = shear;
    auto         m         = measured<dim>(F);
    const double xy = 2. * G * e * 2. / root, xx = 2. * G * e * shear / root;
    check_close(m["tip_cauchy_stress_xy"], xy, 1e-14 * xy, name + "xy");
    check_close(m["tip_cauchy_stress_xx"], xx, 1e-14 * xy, name + "xx");
    check_close(m["tip_cauchy_stress_yy"], -xx, 1e-14 * xy, name + "yy");
    check_close(m["tip_cauchy_stress_zz"], 0., 1e-14 * xy, name + "zz");
    check_close(m["tip_pressure"], 0., 1e-14 * xy, name + "pressure");
    check_close(m["tip_von_mises_stress"],
                std::sqrt(3.) * 2. * G * e,
                1e-13 * xy,
                name + "von Mises stress");
    check_close(m["tip_logarithmic_strain_xy"],
                2. * e / root,
                1e-15,
                name + "strain");
  }

  /** What is written in files: 3x3 tensors, by rows. */
  void
  check_files()
  {
    const SceneParameters<2> parameters(ParameterFile::from_text(
      block<2>("subsection Output\nset Particle fields = displacement, "
               "cauchy_stress, carried, mass\n"
               "set Picture field = displacement\nend\n"),
      "test"));
    test::RunningScene<2>    run(parameters);
    const auto              &fields = run.scene.written_fields;
    check(fields[0].description.name == "displacement" &&
            fields[0].description.n_components == 2 &&
            fields[0].description.unit == "m" &&
            fields[1].description.name == "cauchy_stress" &&
            fields[1].description.n_components == 9 &&
            fields[1].description.unit == "Pa" &&
            fields[2].description.name == "velocity",
          "fields in the order of the list");
    unsigned int n_mass = 0;
    for (const auto &field : fields)
      n_mass += field.description.name == "mass";
    check(n_mass == 1, "each once");
    run.advance(8);
    double worst = 0., picture = 0.;
    for (const auto &particle : run.scene.particles)
      {
        std::vector<double> way, stress;
        fields[0].append(particle, way);
        fields[1].append(particle, stress);
        check(way.size() == 2 && stress.size() == 9, "numbers of a field");
        worst =
          std::max({worst, std::abs(way[0] - 0.25), std::abs(way[1] - 0.5)});
        picture = std::max(picture,
                           std::abs(run.scene.drawn_number.value(particle) -
                                    std::hypot(0.25, 0.5)));
      }
    check_close(worst, 0., 1e-12, "displacement of a body that flies");
    check_close(picture, 0., 1e-12, "its length in the picture");
    check(run.scene.drawn_number.label == "displacement (m)",
          "what the picture shows");
    const auto number = [&run](const std::string &name) {
      return ParticleFields<2>(run.scene.layout)
        .number(name, "Output", "Picture field");
    };
    for (const auto &particle : run.scene.particles)
      check_close(number("velocity_y").value(particle),
                  0.5,
                  1e-12,
                  "a component of a vector");
    check(number("cauchy_stress_xy").label == "cauchy stress xy (Pa)" &&
            number("strain_energy_density").label ==
              "strain energy density (J/m^3)",
          "labels");
  }

  void
  check_absence()
  {
    const SceneParameters<2> parameters(
      ParameterFile::from_text(block<2>(""), "test"));
    const Scene<2> scene(parameters, MPI_COMM_WORLD);
    check(!scene.layout.has("start_position"), "no displacement, no field");
    check(scene.drawn_number.label == "strain energy density (J/m^3)",
          "pictures show the energy where nothing else is asked for");
    const auto &fields = scene.written_fields;
    check(fields.size() == scene.layout.fields().size() + 3 &&
            fields.back().description.name == "von_mises_stress",
          "files have what is carried, and stresses");
  }

  void
  check_errors()
  {
    const auto refused = [](const std::string              &section,
                            const std::vector<std::string> &words) {
      test::check_throws_with(
        [&] {
          const SceneParameters<2> parameters(
            ParameterFile::from_text(block<2>(section), "test"));
          const Scene<2> scene(parameters, MPI_COMM_WORLD);
        },
        words);
    };
    const auto output = [](const std::string &entry) {
      return "subsection Output\nset " + entry + "\nend\n";
    };
    refused(output("Particle fields = carried, cauchy_stres"),
            {"<Output/Particle fields> is <cauchy_stres>",
             "did you mean <cauchy_stress>?",
             "kirchhoff_stress"});
    refused(output("Particle fields = equivalent_plastic_strain"),
            {"<Output/Particle fields> is <equivalent_plastic_strain>",
             "The particles of this scene have carried, velocity"});
    refused(output("Particle fields = displacment"),
            {"did you mean <displacement>?"});
    refused(output("Picture field = presure"),
            {"<Output/Picture field> is <presure>",
             "did you mean <pressure>?"});
    refused(output("Picture field = cauchy_stress"),
            {"did you mean <cauchy_stress_", "velocity_x"});
    const auto mean = [](const std::string &entries) {
      return "subsection Measurements\nset Names = box\nsubsection box\n"
             "set Type = mean\n" +
             entries + "\nend\nend\n";
    };
    refused(mean("set Lower corner = 3, 3"),
            {"<Measurements/box/Lower corner> is <3, 3>",
             "no particle in this box"});
    refused(mean("set Upper corner = 3"),
            {"<Measurements/box/Upper corner> is <3>", "2 coordinates"});
    refused(mean("set Fields = pres"),
            {"<Measurements/box/Fields> is <pres>", "pressure"});
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_stretch<2>();
  check_stretch<3>();
  check_shear<2>();
  check_shear<3>();
  check_files();
  check_absence();
  check_errors();
  return test::report();
}
