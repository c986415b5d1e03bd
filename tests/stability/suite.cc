#include "suite.h"

#include <emmy/base/exceptions.h>
#include <emmy/output/gnuplot.h>

#include <chrono>

#include "../scene.h"

namespace emmy
{
  namespace stability
  {
    namespace
    {
      /** The value of a column that may not be there. */
      double
      value(const Ledger &ledger, const std::string &column)
      {
        const auto &names = ledger.columns();
        return std::find(names.begin(), names.end(), column) == names.end()
                 ? 0.
                 : ledger[column];
      }

      template <int dim>
      struct Measured
      {
        const Ledger &ledger;
        double        mass, speed, size; ///< kg, m/s, m: scales of momenta

        Measured(const Scene<dim> &scene, const Ledger &ledger)
          : ledger(ledger)
          , mass(test::total_mass(scene))
          , speed(std::sqrt(2. * ledger["kinetic_energy"] / mass))
          , size(scene.grid.lower_corner().distance(scene.grid.upper_corner()))
        {}
      };

      template <int dim>
      Result
      run_scene(const std::string &folder, const Run<dim> &run)
      {
        ParameterFile file(folder + "/prm/" + run.file);
        for (const std::string &setting : run.settings)
          file.set(setting);
        if (run.with_conditions)
          file.set("Diagnosis/Small cuts=true");
        const SceneParameters<dim> parameters(file);
        Scene<dim>                 scene(parameters, MPI_COMM_SELF);
        if (run.prepare)
          run.prepare(scene);
        Ledger              ledger(scene.stepper.initial_report(), dim);
        const double        initial = ledger.total_energy();
        const Measured<dim> scale(scene, ledger);

        std::vector<std::string> momenta;
        for (const std::string &name : ledger.columns())
          if (name.find("_momentum_") != std::string::npos)
            momenta.push_back(name);
        std::vector<double> at_start;
        for (const std::string &name : momenta)
          at_start.push_back(ledger[name]);

        Result              result;
        std::vector<double> changes;
        const auto          start = std::chrono::steady_clock::now();
        result.energy             = initial;
        try
          {
            const auto &limits = parameters.time;
            while (ledger["time"] < limits.end_time * (1. - 1e-12) &&
                   (limits.maximum_steps == 0 ||
                    result.steps < limits.maximum_steps))
              {
                const StepReport report = scene.stepper.advance();
                ledger.add(report);
                ++result.steps;
                for (const std::string &note : report.notes)
                  result.halvings +=
                    note.find("halved to") != std::string::npos;
                result.damped += report.is_damped;
                result.most_iterations =
                  std::max(result.most_iterations, report.newton_iterations);
                result.fewest_iterations =
                  result.steps == 1 ? report.newton_iterations
                                    : std::min(result.fewest_iterations,
                                               report.newton_iterations);
                result.mass_condition =
                  std::max(result.mass_condition,
                           value(ledger, "mass_condition"));
                result.jacobian_condition =
                  std::max(result.jacobian_condition,
                           value(ledger, "jacobian_condition"));
                result.energy = std::max(result.energy, ledger.total_energy());
                result.residual_work =
                  std::max(result.residual_work,
                           std::abs(ledger["residual_work"]));
                result.balance_errors.push_back(ledger["balance_error"]);

                result.lost = value(ledger, "ghost_mass_loss") +
                              value(ledger, "ghost_stiffness_loss");
                result.dissipated = value(ledger, "plastic_dissipation");
                const double drift =
                  ledger.total_energy() + result.lost + result.dissipated -
                  initial - value(ledger, "load_work") -
                  value(ledger, "reaction_work") - ledger["residual_work"];
                result.drift = std::max(result.drift, std::abs(drift));
                for (unsigned int i = 0; i < momenta.size(); ++i)
                  {
                    const bool is_linear = momenta[i][0] == 'l';
                    double    &change    = is_linear ? result.linear_momentum
                                                     : result.angular_momentum;
                    change =
                      std::max(change,
                               std::abs(ledger[momenta[i]] - at_start[i]) /
                                 (scale.mass * scale.speed *
                                  (is_linear ? 1. : scale.size)));
                  }
              }
            result.has_ended = true;
          }
        catch (const ExcRun &error)
          {
            result.problem = message_of(error);
          }
        result.seconds = std::chrono::duration<double>(
                           std::chrono::steady_clock::now() - start)
                           .count();
        result.final_energy = ledger.total_energy();
        result.final_strain = ledger["strain_energy"];
        const double energy = result.energy > 0. ? result.energy : 1.;
        for (double &error : result.balance_errors)
          error /= energy;
        result.balance_error = test::largest(result.balance_errors);
        result.drift /= energy;
        result.residual_work /= energy;
        return result;
      }

      std::string
      short_number(const double value)
      {
        std::ostringstream out;
        out << std::setprecision(2) << value;
        return out.str();
      }

      /** What must hold whatever happens: nothing goes wrong unnoticed. */
      void
      check_result(const std::string &variant,
                   const bool         is_stabilised,
                   const Result      &result)
      {
        const double limit = is_stabilised ? 1e-11 : 1e-6;
        const double error = std::max(result.balance_error, result.drift);
        test::check(error <= limit,
                    variant + ": the ledger accounts for the energy to " +
                      short_number(limit) + ", not to " + short_number(error));
        test::check(result.has_ended ||
                      (result.problem.find("Step ") == 0 &&
                       result.problem.find("Remedy: ") != std::string::npos),
                    variant +
                      ": a run that stops says where, why and what "
                      "helps, not <" +
                      result.problem + ">");
      }

      double
      worst(const std::vector<Result> &results, const double Result::*member)
      {
        double result = 0.;
        for (const Result &one : results)
          if (!(one.*member <= result)) // NaN too
            result = one.*member;
        return result;
      }
    } // namespace

    void
    Suite::open_case(const std::string &title, const std::string &text)
    {
      close_case();
      page +=
        "\n## " + title + "\n\n" + text +
        "\n\n| | runs to the end | steps | halved | damped | Newton | cond "
        "M | cond J | ghost losses | work of residuals | unaccounted | "
        "seconds |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n";
      std::cout << "\n" << title << "\n" << std::flush;
    }

    void
    Suite::close_case()
    {
      if (!bounds.empty())
        page += "\nMeasured, and what the test allows:\n" + bounds + "\n";
      bounds.clear();
      bound_variant.clear();
    }

    template <int dim>
    Result
    Suite::run(const std::string &variant, const Run<dim> &run)
    {
      return run_all<dim>(variant, {run})[0];
    }

    template <int dim>
    std::vector<Result>
    Suite::run_all(const std::string           &variant,
                   const std::vector<Run<dim>> &runs)
    {
      std::vector<Result> results;
      for (const Run<dim> &run : runs)
        {
          results.push_back(run_scene(source_folder, run));
          check_result(variant, run.is_stabilised, results.back());
        }
      add_row(variant, results);
      return results;
    }

    void
    Suite::add_row(const std::string         &variant,
                   const std::vector<Result> &results)
    {
      last_variant         = variant;
      unsigned int n_ended = 0, steps = 0, halvings = 0, damped = 0, most = 0;
      double       seconds = 0., lost = 0.;
      for (const Result &one : results)
        {
          n_ended += one.has_ended;
          steps += one.steps;
          halvings += one.halvings;
          damped += one.damped;
          most = std::max(most, one.most_iterations);
          seconds += one.seconds;
          lost = std::max(lost, one.energy > 0. ? one.lost / one.energy : 0.);
        }
      const auto condition = [](const double value) {
        return value == 0.    ? std::string("-")
               : value > 1e15 ? std::string("singular")
                              : short_number(value);
      };
      std::ostringstream row;
      row << "| " << variant << " | "
          << (results.size() == 1
                ? (n_ended ? "yes" : "no, step " + std::to_string(steps + 1))
                : std::to_string(n_ended) + " of " +
                    std::to_string(results.size()))
          << " | " << steps << " | " << halvings << " | " << damped << " | "
          << most << " | " << condition(worst(results, &Result::mass_condition))
          << " | " << condition(worst(results, &Result::jacobian_condition))
          << " | " << (lost > 0. ? short_number(100. * lost) + " %" : "-")
          << " | " << short_number(worst(results, &Result::residual_work))
          << " | " << short_number(worst(results, &Result::drift)) << " | "
          << short_number(seconds) << " |\n";
      page += row.str();
      std::cout << row.str() << std::flush;
      for (const Result &one : results)
        if (!one.has_ended)
          {
            std::cout << "  stopped: " << one.problem << "\n";
            break;
          }
    }

    void
    Suite::bound(const std::string &what,
                 const double       value,
                 const double       limit,
                 const bool         holds,
                 const char        *relation)
    {
      std::ostringstream line;
      line << what << " " << std::setprecision(3) << value << " (" << relation
           << " " << limit << ")";
      bounds += bound_variant == last_variant
                  ? "; " + line.str()
                  : "\n- " + last_variant + ": " + line.str();
      bound_variant = last_variant;
      std::cout << "  " << line.str() << "\n" << std::flush;
      test::check(holds, last_variant + ": " + line.str());
    }

    void
    Suite::at_most(const std::string &what,
                   const double       value,
                   const double       limit)
    {
      bound(what, value, limit, value <= limit, "at most");
    }

    void
    Suite::at_least(const std::string &what,
                    const double       value,
                    const double       limit)
    {
      bound(what, value, limit, value >= limit, "at least");
    }

    void
    Suite::curve(const unsigned int        panel,
                 const std::string        &name,
                 const std::vector<Point> &points)
    {
      curves.push_back({panel, name, points});
    }

    void
    Suite::write(const std::string &folder)
    {
      close_case();
      std::ofstream(folder + "/stability.md")
        << "# What hard cases do\n\n"
           "Printed by `build/tests/test_stability all --write doc`; `ctest -L "
           "stability` runs the cases one by one\nand checks the bounds. "
           "Scenes: `prm/stability` and `prm/paper`.\n\n"
           "A row is a run, or several with the worst of each column. *halved*: "
           "times a step was tried again with half its\nsize; *damped*: steps "
           "that needed the damped try; *Newton*: most iterations in a step; "
           "*cond M*, *cond J*: largest\ncondition of the scaled mass matrix "
           "and Jacobian, if measured (- if not); *ghost losses*, *work of "
           "residuals*,\n*unaccounted*: of the largest energy. *unaccounted* is "
           "what energies, losses and works in the ledger do not add\nup to: "
           "it must stay below 1e-11, without a remedy below 1e-6. A run "
           "that stops must say in which step,\nwhy, and what helps.\n\n"
           "![Condition of the mass matrix over the offset, and balance error "
           "over the steps](pictures/stability.png)\n"
        << page;

      const std::string pictures = folder + "/pictures";
      std::ofstream     script(pictures + "/stability.gp");
      gnuplot::Canvas   canvas;
      canvas.height = 900.;
      gnuplot::write_preamble(script, "stability", canvas);
      script << "set multiplot layout 1,2\nset logscale xy\n"
                "set format '10^{%T}'\nset key outside below maxrows 2\n"
                "set grid lc rgb '#dddddd'\n";
      const char *const titles[] = {
        "set title 'A tip enters a cell'\n"
        "set xlabel 'offset / h'\nset ylabel 'condition of scaled mass'\n"
        "set yrange [1:1e17]\n",
        "set title '10,000 steps'\n"
        "set xlabel 'step'\nset ylabel '|balance error| / energy'\n"
        "set yrange [1e-18:1e-12]\n"};
      for (unsigned int panel = 0; panel < 2; ++panel)
        {
          std::string plots;
          for (const Curve &curve : curves)
            if (curve.panel == panel)
              {
                const std::string block =
                  "$curve" + std::to_string(&curve - curves.data());
                script << block << " << EOD\n";
                for (const Point &point : curve.points)
                  script << point.first << ' ' << point.second << '\n';
                script << "EOD\n";
                plots += (plots.empty() ? "plot " : ", ") + block + " with " +
                         (panel == 0 ? "linespoints pt 7" : "lines") +
                         " lw 3 title " + gnuplot::quoted(curve.name);
              }
          script << titles[panel] << plots << "\n";
        }
      script << "unset multiplot\n";
      script.close();
      AssertThrow(gnuplot::run(pictures, "stability") ==
                    gnuplot::Outcome::drawn,
                  ExcRun("Stability",
                         "the picture could not be drawn in " + pictures,
                         "install gnuplot, and see gnuplot.log there."));
    }

    template Result
    Suite::run<2>(const std::string &, const Run<2> &);
    template Result
    Suite::run<3>(const std::string &, const Run<3> &);
    template std::vector<Result>
    Suite::run_all<2>(const std::string &, const std::vector<Run<2>> &);
    template std::vector<Result>
    Suite::run_all<3>(const std::string &, const std::vector<Run<3>> &);
  } // namespace stability
} // namespace emmy

int
main(int argc, char *argv[])
{
  using namespace emmy;
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::vector<std::string>           arguments(argv + 1, argv + argc);
  const auto                               all = stability::cases();
  const std::string name = arguments.empty() ? "" : arguments[0];

  stability::Suite suite(EMMY_SOURCE_DIR);
  bool             is_known = false;
  for (const auto &one : all)
    if (name == one.name || name == "all")
      {
        is_known = true;
        one.run(suite);
      }
  if (!is_known)
    {
      std::cerr << "usage: test_stability CASE [--write FOLDER]\ncases: all";
      for (const auto &one : all)
        std::cerr << ", " << one.name;
      std::cerr << "\n";
      return 2;
    }
  if (arguments.size() == 3 && arguments[1] == "--write")
    suite.write(arguments[2]);
  return test::report();
}
