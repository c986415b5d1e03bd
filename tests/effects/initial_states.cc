// Facts about bodies that begin with a stress, or whose material varies: the
// elastic strain has just that stress, of each material; level ground is in
// balance with its weight to round-off and stays at rest, in moduli that grow
// with depth too; the state does not depend on the ranks; a material that
// varies is, at each point, the one with those moduli and strengths; a column
// settles as the closed form says; stresses that a material does not bear, and
// factors that are not positive, are refused in words.

#include <emmy/material/graded_material.h>
#include <emmy/material/stressed_state.h>
#include <emmy/output/particle_fields.h>

#include <map>

#include "../material/laws.h"
#include "../scene.h"

using namespace emmy;
using test::check;
using test::check_close;

namespace
{
  void
  say(const std::string &text)
  {
    if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
      std::cout << text << '\n';
  }

  /** tau/J of the strain that was found is the stress. */
  template <int dim>
  void
  check_strains()
  {
    double worst = 0.;
    for (const auto &law : test::all_laws<dim>())
      for (unsigned int i = 0; i < 20; ++i)
        {
          // compressed, and within all strengths
          const auto stress =
            mandel::symmetric_part<dim>(test::random_tensor<dim>(0.5), -0.2) -
            3. * mandel::unit<dim>();
          const auto state = stressed_state<dim>(*law.material, {}, stress);
          check(state.is_found, law.name + ": a strain");
          const double J = std::sqrt(1. + mandel::determinant_less_one<dim>(
                                            state.left_cauchy_green_less_unit));
          check_close(J, state.volume_ratio, 1e-12, law.name + ": J");
          const double gap =
            (state.kirchhoff_stress / J - stress).norm() / stress.norm();
          worst = std::max(worst, gap);
        }
    say("stress of the strain, worst error " + brief(worst));
    check(worst < 1e-12, "the strain has the stress");
  }

  /** The formula's value, everywhere. */
  std::unique_ptr<dealii::FunctionParser<2>>
  constant(const double value)
  {
    return read_formulas<2>(shortest(value), 1, "test", "factor", "");
  }

  /** A graded material is the material with other constants. */
  void
  check_graded(const double s, const double r)
  {
    ElasticConstants soft;
    soft.density       = 5.;
    soft.young_modulus = 100.;
    soft.poisson_ratio = 0.3;
    soft               = soft.completed("test");
    ElasticConstants stiff(soft);
    stiff.young_modulus *= s;
    stiff.bulk_modulus *= s;
    stiff.shear_modulus *= s;
    std::vector<std::array<std::unique_ptr<Material<2>>, 2>> pairs;
    pairs.push_back(
      {{std::make_unique<VonMises<2>>(soft, YieldSurface{10., 7.}),
        std::make_unique<VonMises<2>>(stiff, YieldSurface{10. * r, 7. * s})}});
    pairs.push_back(
      {{std::make_unique<DruckerPrager<2>>(
          soft, DruckerPragerSurface{0.4, 0.1, 8., 15.}),
        std::make_unique<DruckerPrager<2>>(
          stiff, DruckerPragerSurface{0.4, 0.1, 8. * r, 15. * r})}});
    for (auto &[base, other] : pairs)
      {
        const GradedMaterial<2> graded(std::move(base),
                                       constant(s),
                                       constant(r));
        auto                    a = std::make_unique<MaterialBatch<2>>(),
             b                    = std::make_unique<MaterialBatch<2>>();
        for (auto *batch : {a.get(), b.get()})
          {
            batch->n_points = 8;
            batch->history.resize(graded.history().size());
            for (auto &history : batch->history)
              history.fill(0.01);
          }
        for (unsigned int q = 0; q < 8; ++q)
          a->left_cauchy_green_less_unit[q] =
            b->left_cauchy_green_less_unit[q] =
              mandel::symmetric_part<2>(test::random_tensor<2>(0.2), 0.05);
        for (const double factor : graded.parameters_at({}))
          {
            a->parameters.emplace_back();
            a->parameters.back().fill(factor);
          }
        graded.evaluate(*a);
        other->evaluate(*b);
        bool flows = false;
        for (unsigned int q = 0; q < 8; ++q)
          {
            const double scale = 100. * s;
            flows |= b->dissipation[q] > 0.;
            check_close(
              (a->kirchhoff_stress[q] - b->kirchhoff_stress[q]).norm(),
              0.,
              1e-13 * scale,
              "graded: stress");
            check_close((a->spatial_tangent[q] - b->spatial_tangent[q]).norm(),
                        0.,
                        1e-12 * scale,
                        "graded: tangent");
            check_close(a->stored_energy[q],
                        b->stored_energy[q],
                        1e-13 * scale,
                        "graded: energy");
            check_close(a->dissipation[q],
                        b->dissipation[q],
                        1e-13 * scale,
                        "graded: dissipation");
            check_close(a->history[0][q],
                        b->history[0][q],
                        1e-14,
                        "graded: history");
          }
        check(flows, "graded: some points flow");
      }
  }

  /** Ground 1 m wide in a tube, 8 m deep, of 16 cells. */
  std::string
  ground(const std::string &material,
         const std::string &body,
         const std::string &time)
  {
    return "set Dimension = 2\nsubsection Grid\nset Lower corner = 0, -8\n"
           "set Upper corner = 1, 2\nset Cells = 2, 20\nend\n"
           "subsection Materials\nset Names = m\nsubsection m\n"
           "set Density = 2000\nset Young's modulus = 1e7\n"
           "set Poisson's ratio = 0.25\n" +
           material +
           "end\nend\nsubsection Bodies\nset Names = b\nsubsection b\n"
           "set Shape = box\nset Material = m\nset Points per direction = 2\n" +
           body +
           "subsection box\nset Lower corner = 0, -8\n"
           "set Upper corner = 1, 0\nend\nend\nend\n"
           "subsection Boundary conditions\nset Roller = x-min, x-max, y-min\n"
           "end\nsubsection Effects\nset Names = gravity\nsubsection Gravity\n"
           "set Acceleration = 0, -10\nend\nend\nsubsection Time\n" +
           time + "end\n";
  }

  const std::string at_rest =
    "set Initial stress = level ground\nset Ground level = 0\n"
    "set Unit weight = 20e3\n";

  /** It does not move, and the first row has what is stored. */
  void
  check_rest(const std::string &name,
             const std::string &material,
             const std::string &body)
  {
    const SceneParameters<2> parameters(ParameterFile::from_text(
      ground(material,
             body,
             "set Step rule = fixed\nset Step size = 0.01\nset End time = 1\n"),
      name));
    test::RunningScene<2>    run(parameters);
    run.most_residual_work = 1.; // there is nothing but round-off
    const double stored    = run.ledger["strain_energy"];
    const double imbalance = run.scene.stepper->imbalance();
    // files say the same of it before the first step and after
    const auto pressures = [&run] {
      const ParticleFields<2> fields(run.scene.layout);
      const auto              pressure =
        fields.find({"pressure"}, "Output", "Particle fields").front();
      std::map<unsigned int, double> result;
      for (const auto &particle : run.scene.particles)
        {
          std::vector<double> value;
          pressure.append(particle, value);
          result[particle.get_id()] = value[0];
        }
      return result;
    };
    const auto before = pressures();
    run.advance(1);
    for (const auto &[id, pressure] : pressures())
      check_close(pressure,
                  before.at(id),
                  1e-9 * std::abs(before.at(id)),
                  name + ": pressure before and after the first step");
    run.advance(49);
    const double moves = test::largest(run.column("kinetic_energy"));
    say(name + ": stored " + brief(stored) + " J, out of balance by " +
        brief(imbalance) + ", kinetic energy at most " + brief(moves) + " J");
    check(imbalance < 1e-13, name + ": in balance");
    const auto told = run.column("initial_imbalance");
    check(told[0] == imbalance && test::largest(told) == imbalance,
          name + ": row 0 says how far from balance it is");
    check(stored > 1e3, name + ": row 0 has the energy");
    check(moves < 1e-20 * stored, name + ": it stays at rest");
    check_close(run.ledger["strain_energy"],
                stored,
                1e-12 * stored,
                name + ": and keeps its energy");
    check(!run.scene.notes.empty() &&
            run.scene.notes.back().find("initial stress: ") == 0,
          name + ": the log says so");
  }

  /**
   * Static steps: with none of the loads raised ground stays as it is; with
   * all, its weight goes and comes again, and a note says so.
   */
  void
  check_static_steps()
  {
    for (const bool is_raised : {false, true})
      {
        const SceneParameters<2> parameters(ParameterFile::from_text(
          ground("set Model = Hencky\n",
                 at_rest + "set K0 = 0.5\n",
                 "set Integrator = static\nset Increments = 4\n"
                 "set End time = 1\n" +
                   std::string(is_raised ? "" : "set Raised loads = none\n")),
          "static"));
        test::RunningScene<2>    run(parameters);
        run.most_residual_work = 1.;
        const double stored    = run.ledger["strain_energy"];
        const bool   is_told   = std::any_of(
          run.scene.notes.begin(), run.scene.notes.end(), [](const auto &note) {
            return note.find("raised from zero") != std::string::npos;
          });
        check(is_told == is_raised, "static steps: a note if all is raised");
        run.advance(1);
        const double left = run.ledger["strain_energy"] / stored;
        if (is_raised)
          check(left < 0.5, "static steps: its weight is raised");
        else
          check_close(left, 1., 1e-12, "static steps: its weight acts");
      }
  }

  /** Half the stress that the weight asks for is far out of balance. */
  void
  check_imbalance()
  {
    const SceneParameters<2> parameters(ParameterFile::from_text(
      ground("set Model = Hencky\n",
             "set Initial stress = level ground\nset Ground level = 0\n"
             "set Unit weight = 10e3\nset K0 = 0.5\n",
             "set Step rule = fixed\nset Step size = 0.01\nset End time = 1\n"),
      "too light"));
    test::RunningScene<2>    run(parameters);
    run.advance(1);
    const auto told = run.column("initial_imbalance");
    say("half the weight: out of balance by " + brief(told[0]));
    // half of the weight, of forces that count those on sides too
    check(told[0] > 0.1 && told[0] < 0.5, "too light: out of balance");
    check(told[1] == 0., "too light: row 0 alone says it");
    check(run.scene.notes.back().find("Is its Unit weight") !=
            std::string::npos,
          "too light: a note asks for its weight");
  }

  /** Moduli that grow with depth: the settlement of the closed form. */
  void
  check_settlement()
  {
    const SceneParameters<2> parameters(ParameterFile::from_text(
      ground(
        "set Model = Hencky\nset Stiffness factor = 1 - 0.5*y\n",
        "",
        "set Integrator = static\nset End time = 1\nset Increments = 2\n") +
        "subsection Measurements\nset Names = top\nsubsection top\n"
        "set Type = extent\nend\nend\n",
      "settlement"));
    test::RunningScene<2>    run(parameters);
    run.most_residual_work = 1e-6;
    run.advance_to(1.);
    // M(z) = M (1 + k z): u = rho g/M (H/k - ln(1 + k H)/k^2)
    const double M = 1e7 * 0.75 / (1.25 * 0.5), k = 0.5, H = 8.,
                 right   = 20e3 / M * (H / k - std::log(1. + k * H) / (k * k));
    const double settled = -run.ledger["top_upper_y"];
    say("settlement " + brief(settled) + " m, small strains " + brief(right) +
        " m");
    check_close(settled, right, 0.02 * right, "settlement");
  }

  void
  check_refused(const std::string              &material,
                const std::string              &body,
                const std::vector<std::string> &words)
  {
    test::check_throws_with(
      [&] {
        const SceneParameters<2> parameters(
          ParameterFile::from_text(ground(material, body, "set End time = 1\n"),
                                   "refused"));
        test::RunningScene<2> run(parameters);
      },
      words);
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_strains<2>();
  check_strains<3>();
  check_graded(3., 0.5);

  check_rest("level ground",
             "set Model = Hencky\n",
             at_rest + "set K0 = 0.5\n");
  check_rest("sand",
             "set Model = Drucker-Prager\nset Cohesion = 0\n"
             "set Friction angle = 35\nset Dilation angle = 5\n",
             at_rest + "set K0 = 0.45\n");
  check_rest("clay, stiffer and stronger with depth",
             "set Model = von Mises\nset Yield measure = undrained\n"
             "set Yield stress = 1e4\nset Stiffness factor = 1 - 0.2*y\n"
             "set Strength factor = 0.5 - y\n",
             at_rest + "set K0 = 0.8\n");
  check_rest("formulas",
             "set Model = neo-Hooke\n",
             "set Initial stress = formulas\n"
             "set Stress = 10e3*y; 20e3*y; 12e3*y; 0\n");
  check_imbalance();
  check_static_steps();
  check_settlement();

  check_refused("set Model = von Mises\nset Yield stress = 1e3\n",
                at_rest + "set K0 = 0.3\n",
                {"does not bear the Initial stress of body <b>",
                 "choose a K0"});
  check_refused("set Model = Hencky\n",
                at_rest,
                {"<Bodies/b/K0>", "nu/(1 - nu)"});
  check_refused("set Model = Hencky\n",
                at_rest + "set K0 = -0.1\n",
                {"<Bodies/b/K0> is <-0.1>", "must not be negative"});
  check_refused("set Model = Hencky\n",
                at_rest + "set K0 = 0.5\nset Surcharge = -1\n",
                {"<Bodies/b/Surcharge> is <-1>", "must not be negative"});
  check_refused("set Model = Hencky\nset Stiffness factor = y\n",
                "",
                {"the stiffness_factor of body <b>", "must be positive"});
  check_refused("set Model = Hencky\nset Strength factor = 2\n",
                "",
                {"<Materials/m/Strength factor> is <2>", "has no strength"});
  return test::report();
}
