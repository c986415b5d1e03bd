// A study is a loop. What varies are entries of a parameter file, set in
// memory; what is compared are numbers of the ledger. deal.II makes the table.
#include <deal.II/base/convergence_table.h>

#include <emmy/output/gnuplot.h>
#include <emmy/output/ledger.h>
#include <emmy/run/scene.h>

#include <cmath>
#include <fstream>
#include <iostream>

using namespace emmy;

// What we compare, of one run: energies at the end, and what it took.
struct Result
{
  double       kinetic_energy = 0., strain_energy = 0.; // J
  double       loss       = 0.;                         // of the stress rule, J
  unsigned int iterations = 0;                          // of Newton, all steps
};

// Nothing is written: a scene and a ledger live in memory. A column that a
// scene does not have is an error, so we ask for stress_rule_loss only where
// there is one.
Result
run(const std::string &filename, const std::string &rule, const double dt)
{
  ParameterFile file(filename);
  file.set("Method/Stress rule=" + rule);
  file.set("Time/Step size=" + shortest(dt));
  const SceneParameters<2> parameters(file);
  Scene<2>                 scene(parameters, MPI_COMM_WORLD);
  Ledger                   ledger(scene.initial_report(), 2);
  Result                   result;
  while (ledger["time"] < parameters.time.end_time * (1. - 1e-12))
    {
      const StepReport report = scene.advance();
      result.iterations += report.newton_iterations;
      ledger.add(report);
    }
  result.kinetic_energy = ledger["kinetic_energy"];
  result.strain_energy  = ledger["strain_energy"];
  if (rule != "conserving")
    result.loss = ledger["stress_rule_loss"];
  return result;
}

// One rule, smaller and smaller steps. The error is that of the strain energy
// at the end, over the limit that the finest conserving runs tend to.
std::vector<double>
study(const std::string         &filename,
      const std::string         &rule,
      const std::vector<double> &steps,
      const double               limit)
{
  dealii::ConvergenceTable table;
  std::vector<double>      errors;
  for (const double dt : steps)
    {
      const Result result = run(filename, rule, dt);
      errors.push_back(std::abs(result.strain_energy / limit - 1.));
      table.add_value("dt", dt);
      table.add_value("steps", static_cast<unsigned int>(std::round(1. / dt)));
      table.add_value("Newton", result.iterations);
      table.add_value("error", errors.back());
      table.add_value("loss, J", result.loss);
    }
  table.set_precision("dt", 4);
  table.set_precision("error", 2);
  table.set_precision("loss, J", 2);
  table.set_scientific("error", true);
  table.set_scientific("loss, J", true);
  table.evaluate_convergence_rates(
    "error", dealii::ConvergenceTable::reduction_rate_log2);
  std::cout << rule << '\n';
  table.write_text(std::cout);
  return errors;
}

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  try
    {
      const std::string         file = argc > 1 ? argv[1] : "step-7.prm";
      const std::vector<double> steps{0.1, 0.05, 0.025, 0.0125};

      // The limit of steps to zero. The rule is of second order, so two runs
      // give it: the finer one plus a third of their difference (Richardson).
      const double coarse = run(file, "conserving", 0.0125).strain_energy,
                   fine   = run(file, "conserving", 0.00625).strain_energy;
      const double limit  = fine + (fine - coarse) / 3.;

      std::ofstream script("step-7.gp");
      gnuplot::write_preamble(script, "step-7", {1200., 750., 24.});
      script << "set logscale\nset xlabel 'dt, s'\nset ylabel 'error'\n"
                "set key bottom right\nset format y '%.0e'\n"
                "set xrange [0.01:0.13]\n";
      bool         is_right = true;
      std::string  plot;
      unsigned int n = 0;
      for (const std::string rule :
           {"conserving", "mid-point", "trapezoidal", "end-point"})
        {
          const std::vector<double> errors = study(file, rule, steps, limit);
          const double              order  = std::log2(errors[2] / errors[3]);
          is_right =
            is_right && std::abs(order - (rule == "end-point" ? 1. : 2.)) < 0.3;
          script << "$d" << n << " << EOD\n";
          for (unsigned int i = 0; i < steps.size(); ++i)
            script << steps[i] << ' ' << errors[i] << '\n';
          script << "EOD\n";
          plot += (n == 0 ? "plot $d" : ", $d") + std::to_string(n) +
                  " with linespoints lw 3 ps 2 title '" + rule + "'";
          ++n;
        }
      script << plot << '\n';
      script.close();
      gnuplot::run(".", "step-7");
      std::cout << "orders are two, of the end-point rule one: " << is_right
                << '\n';
      return is_right ? 0 : 1;
    }
  catch (const std::exception &error)
    {
      std::cerr << error.what() << std::endl;
      return 1;
    }
}
