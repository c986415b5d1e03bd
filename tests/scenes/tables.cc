// Particles with their state from files: what a scene writes as CSV or VTU,
// another one reads, with the same stress; states by hand against closed forms;
// the exact words of refusals.

#include <deal.II/base/mpi.h>

#include <emmy/base/exceptions.h>
#include <emmy/output/particle_csv.h>
#include <emmy/output/particle_fields.h>
#include <emmy/particles/particle_columns.h>

#include <filesystem>
#include <fstream>
#include <map>

#include <unistd.h>

#include "../check.h"
#include "../scene.h"

namespace
{
  using namespace emmy;
  using namespace emmy::test;

  const std::string metal = "set Model = von Mises\nset Density = 7800\n"
                            "set Young's modulus = 2e11\n"
                            "set Poisson's ratio = 0.3\n"
                            "set Yield stress = 2e8\n"
                            "set Hardening modulus = 1e9\n",
                    soil  = "set Model = Drucker-Prager\nset Density = 2000\n"
                            "set Young's modulus = 1e7\n"
                            "set Poisson's ratio = 0.3\nset Cohesion = 1e4\n"
                            "set Friction angle = 30\nset Dilation angle = 10\n"
                            "set Fit = plane strain\n"
                            "set Stiffness factor = 1 + 0.1*x\n"
                            "set Strength factor = 2\n",
                    gum   = "set Model = neo-Hooke\nset Density = 1000\n"
                            "set Bulk modulus = 2e5\nset Shear modulus = 1e5\n";

  /** A block that is free, of 2 x 2 (x 2) cells. */
  template <int dim>
  ParameterFile
  scene(const std::string &material,
        const std::string &velocity,
        const std::string &shape,
        const std::string &table = "")
  {
    const auto all = [](const std::string &x) {
      return x + ", " + x + (dim == 3 ? ", " + x : "");
    };
    return ParameterFile::from_text(
      "set Dimension = " + std::to_string(dim) +
        "\nsubsection Grid\nset Lower corner = " + all("0") +
        "\nset Upper corner = " + all("6") + "\nset Cells = " + all("6") +
        "\nend\nsubsection Materials\nset Names = m\nsubsection m\n" +
        material +
        "end\nend\nsubsection Bodies\nset Names = b\nsubsection b\nset "
        "Material = m\nset Points per direction = 2\nset Initial velocity = " +
        velocity + "\nset Shape = " + shape + "\n" + table +
        "end\nend\nsubsection Time\nset End time = 1\nset Factor = 0.5\nend\n"
        "subsection Output\nset Pictures = false\nend\n",
      "test.prm");
  }

  template <int dim>
  ParameterFile
  from_table(const std::string &material,
             const std::string &file,
             const std::string &more = "")
  {
    return scene<dim>(material,
                      dim == 2 ? "0; 0" : "0; 0; 0",
                      "particles",
                      "subsection particles\nset File = " + file + "\n" + more +
                        "end\n");
  }

  /** What particles say, by where they are and what it is called. */
  template <int dim>
  std::map<std::string, std::vector<double>>
  told(Scene<dim> &scene)
  {
    std::map<std::string, std::vector<double>> result;
    const ParticleFields<dim>                  fields(scene.layout);
    std::map<std::string, std::vector<double>> by_place;
    for (const std::string &name : fields.names())
      for (const auto &field : fields.find({name}, "", ""))
        {
          std::map<std::vector<double>, std::vector<double>> sorted;
          for (const auto &particle : scene.particles)
            {
              std::vector<double> place;
              for (unsigned int d = 0; d < dim; ++d)
                // in single precision, as in a .vtu
                place.push_back(float(particle.get_location()[d]));
              field.append(particle, sorted[place]);
            }
          for (const auto &[place, values] : sorted)
            result[name].insert(result[name].end(),
                                values.begin(),
                                values.end());
        }
    return result;
  }

  void
  check_same(const std::vector<double> &a,
             const std::vector<double> &b,
             const double               tolerance,
             const std::string         &what)
  {
    check(a.size() == b.size() && !a.empty(), what + ": as many numbers");
    double scale = 0., error = 0.;
    for (unsigned int i = 0; i < std::min(a.size(), b.size()); ++i)
      {
        scale = std::max(scale, std::abs(a[i]));
        error = std::max(error, std::abs(a[i] - b[i]));
      }
    check(scale > 0., what + ": there is something");
    check_close(error / scale, 0., tolerance, what);
  }

  /** Run, write, read, compare, and run on. */
  template <int dim>
  void
  check_round_trip(const std::string &material,
                   const std::string &velocity,
                   const bool         flows)
  {
    const std::string name =
      material.substr(12, 8) + " in " + std::to_string(dim) + " dimensions: ";
    dealii::ParameterAcceptor::clear();
    const SceneParameters<dim> parameters(scene<dim>(
      material, velocity, dim == 2 ? "box(1,1;3,3)" : "box(1,1,1;3,3,3)"));
    RunningScene<dim>          first(parameters);
    first.most_residual_work = 1e-6; // a few steps of a hard motion
    first.advance(6);
    write_particle_csv<dim>("state.csv",
                            first.scene.layout,
                            first.scene.particles,
                            MPI_COMM_WORLD);
    auto then = told(first.scene);
    if (flows)
      check(largest(then["equivalent_plastic_strain"]) > 1e-4,
            name + "it has flowed");

    dealii::ParameterAcceptor::clear();
    const SceneParameters<dim> read(from_table<dim>(material, "state.csv"));
    RunningScene<dim>          second(read);
    second.most_residual_work = 1e-6;
    auto now                  = told(second.scene);
    for (const char *field : {"cauchy_stress",
                              "kirchhoff_stress",
                              "elastic_strain",
                              "logarithmic_strain",
                              "velocity",
                              "mass",
                              "reference_volume",
                              "strain_energy_density"})
      check_same(then[field], now[field], 1e-12, name + field);
    if (flows)
      for (const char *field :
           {"equivalent_plastic_strain", "plastic_dissipation_density"})
        check_same(then[field], now[field], 1e-12, name + field);
    if (then.count("stiffness_factor") > 0)
      check_same(then["stiffness_factor"],
                 now["stiffness_factor"],
                 1e-15,
                 name + "what varies goes with the particles");
    const auto stored = [](const RunningScene<dim> &run,
                           const unsigned int       row) {
      double sum = run.column("strain_energy")[row];
      if (const auto &names = run.ledger.columns();
          std::count(names.begin(), names.end(), "hardening_energy") > 0)
        sum += run.column("hardening_energy")[row];
      return sum;
    };
    check_close(stored(first, 6),
                stored(second, 0),
                1e-11 * stored(first, 6),
                name + "the ledger begins with the energy");
    second.advance(3);
    check_close(second.ledger["balance_error"],
                0.,
                1e-10 * (stored(first, 6) + first.ledger["kinetic_energy"]),
                name + "and balances");
  }

  void
  check_vtu()
  {
    dealii::ParameterAcceptor::clear();
    const SceneParameters<2> parameters(
      scene<2>(gum, "6*(y - 2); -3*x", "box(1,1;3,3)"));
    RunningScene<2> first(parameters);
    first.advance(6);
    auto       then = told(first.scene);
    const auto fields =
      ParticleFields<2>(first.scene.layout)
        .find({"carried", "cauchy_stress", "pressure"}, "Output", "");
    std::vector<FieldDescription> descriptions{{"id", 1, "1", "id", true}};
    for (const auto &field : fields)
      descriptions.push_back(field.description);
    DataFile<0, 2> file(descriptions);
    for (const auto &particle : first.scene.particles)
      {
        std::vector<double> values{double(particle.get_id())};
        for (const auto &field : fields)
          field.append(particle, values);
        file.add_point(particle.get_location(),
                       dealii::make_array_view(values));
      }
    const std::string name = file.write(".", "state", 7, 0.1, MPI_COMM_WORLD);
    for (const std::string &from : {name, std::string("state_0007.0.vtu")})
      {
        dealii::ParameterAcceptor::clear();
        const SceneParameters<2> read(from_table<2>(gum, from));
        RunningScene<2>          second(read);
        auto                     now = told(second.scene);
        // single precision is 6e-8
        check_same(then["kirchhoff_stress"],
                   now["kirchhoff_stress"],
                   2e-7,
                   from + ": the stress of the run, as rounded");
        check_same(then["velocity"],
                   now["velocity"],
                   2e-7,
                   from + ": velocity");
        check_same(then["reference_volume"],
                   now["reference_volume"],
                   1e-6,
                   from + ": volume");
        // the numbers in the file are met to all digits
        const auto columns = read_vtu_columns(from);
        const int  xx      = columns.find("kirchhoff_stress_xx"),
                  x = columns.find("x"), y = columns.find("y");
        check(xx >= 0 && columns.rows.size() == 16, from + ": its columns");
        std::map<std::vector<double>, std::vector<double>> sorted;
        for (const auto &row : columns.rows)
          sorted[{row[x], row[y]}].push_back(row[xx]);
        std::vector<double> written, taken;
        for (const auto &row : sorted)
          written.push_back(row.second[0]);
        for (unsigned int i = 0; i < now["kirchhoff_stress"].size(); i += 9)
          taken.push_back(now["kirchhoff_stress"][i]);
        check_same(written, taken, 1e-12, from + ": as it is written");
      }
  }

  /** One particle under a stress that is written by hand. */
  void
  check_by_hand()
  {
    std::ofstream("hand.csv")
      << "x y volume density cauchy_stress_xx cauchy_stress_yy "
         "cauchy_stress_zz cauchy_stress_xy\n"
         "2.5 2.5 0.25 8000 -1e7 -2e7 -5e6 3e6\n";
    dealii::ParameterAcceptor::clear();
    const SceneParameters<2> parameters(from_table<2>(metal, "hand.csv"));
    RunningScene<2>          run(parameters);
    auto                     now = told(run.scene);
    check_same({-1e7, 3e6, 0., 3e6, -2e7, 0., 0., 0., -5e6},
               now["cauchy_stress"],
               1e-13,
               "a stress by hand");
    check_close(now["mass"][0], 2000., 1e-12, "mass of a density");
    const double trace = -3.5e7 * (1. - 2. * 0.3) / 2e11; // at J = 1
    check_close(now["reference_volume"][0],
                0.25 * std::exp(-trace),
                1e-8,
                "the undeformed volume is larger");
    bool is_told = false;
    for (const std::string &note : run.scene.notes)
      is_told |= note.find("as in a virgin body: equivalent_plastic_strain") !=
                 std::string::npos;
    check(is_told, "the log says what the table does not");
  }

  void
  check_refusals()
  {
    const auto refuses = [](const std::string              &material,
                            const std::string              &text,
                            const std::vector<std::string> &words,
                            const std::string              &more = "") {
      std::ofstream("refused.csv") << text;
      dealii::ParameterAcceptor::clear();
      const SceneParameters<2> parameters(
        from_table<2>(material, "refused.csv", more));
      check_throws_with([&] { Scene<2> scene(parameters, MPI_COMM_WORLD); },
                        words);
    };
    const std::string two = "x y volume body T\n2.2 2 0.2 0 3\n3 2 0.2 1 3\n";
    refuses(gum,
            "x y volume equivalent_plastic_strain\n2 2 0.2 0.1\n",
            {"body <b> has no use for the columns equivalent_plastic_strain",
             "Leave out"});
    refuses(gum, two, {"particles of several bodies", "Rows of body"});
    refuses(gum, two, {"the columns T"}, "set Rows of body = 1\n");
    refuses(gum,
            "x y volume cauchy_stress_xx\n2 2 0.2 1\n",
            {"cauchy_stress without cauchy_stress_yy"});
    refuses(metal,
            "x y volume cauchy_stress_xx cauchy_stress_yy cauchy_stress_zz "
            "cauchy_stress_xy\n2 2 0.2 1e9 0 0 0\n",
            {"does not bear the state of the particle at (2, 2)",
             "plastic strain"});
    refuses(gum, "x y volume mass density\n2 2 0.2 1 1\n", {"both <mass>"});
    std::ofstream("refused.vtu") << "<VTKFile><nothing/></VTKFile>";
    check(read_vtu_columns("refused.vtu").problem.find("cannot be read") !=
            std::string::npos,
          "a .vtu without particles");
    dealii::ParameterAcceptor::clear();
    std::ofstream("two.csv") << two;
    const SceneParameters<2> parameters(from_table<2>(
      gum, "two.csv", "set Rows of body = 1\nset Leave out = T\n"));
    Scene<2>                 scene(parameters, MPI_COMM_WORLD);
    check(scene.particles.n_global_particles() == 1, "the rows of one body");
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  // what is written stays nowhere
  const auto folder = std::filesystem::temp_directory_path() /
                      ("emmy-test-tables-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  std::filesystem::current_path(folder);
  check_round_trip<2>(gum, "6*(y - 2); -3*x", false);
  check_round_trip<2>(metal, "200*(y - 2); 50*(x - 2)", true);
  check_round_trip<2>(soil, "20*(y - 2); 2*(x - 2)", true);
  check_round_trip<3>(metal, "200*(y - 2); 50*(z - 2); 30*(x - 2)", true);
  check_vtu();
  check_by_hand();
  check_refusals();
  std::filesystem::remove_all(folder);
  return report();
}
