// Whole runs at small strains, down to 1e-9 of a metre in a bar of steel:
// Newton needs at most three iterations in each step, none is halved or damped,
// the balance closes to round-off, and what comes out is the linear solution.

#include <cmath>
#include <limits>

#include "../scene.h"

using namespace emmy;
using dealii::numbers::PI;

namespace
{
  /** A run, and what it must not do. */
  template <int dim>
  struct SmallRun : public test::RunningScene<dim>
  {
    unsigned int halvings = 0, damped = 0, iterations = 0;

    explicit SmallRun(const ParameterFile &file)
      : SmallRun(SceneParameters<dim>(file))
    {}

    explicit SmallRun(const SceneParameters<dim> &parameters)
      : test::RunningScene<dim>(parameters, MPI_COMM_SELF)
    {
      const double end = parameters.time.end_time;
      while (this->ledger["time"] < end * (1. - 1e-10))
        {
          const StepReport report = this->scene.advance();
          this->ledger.add(report);
          halvings += report.halvings;
          damped += report.is_damped;
          iterations += report.newton_iterations;
        }
    }

    /** The largest energy that the scene has or gets. */
    double
    energy() const
    {
      double result = test::largest(this->column("kinetic_energy"));
      return std::max(result, test::largest(this->column("strain_energy")));
    }

    void
    judge(const std::string &name) const
    {
      const double steps = this->ledger["step"];
      std::cout << name << ": " << steps << " steps, " << iterations / steps
                << " iterations a step\n";
      test::check(halvings == 0 && damped == 0,
                  name + ": no step is halved or damped");
      test::at_most("  iterations of a step",
                    test::largest(this->column("newton_iterations")),
                    3);
      test::at_most("  balance error, of the energy",
                    test::largest(this->column("balance_error")) / energy(),
                    1e-12);
    }
  };

  /** Quarter waves of a bar, from 1e-2 to 1e-9 m. */
  void
  check_bar(const std::string &folder)
  {
    const double omega = 0.5 * PI * std::sqrt(2e11 / 7800.), // of 1 m
      time_step        = 1.2342761036332187e-05;
    // the mid-point rule lengthens periods
    const double omega_of_rule =
      2. / time_step * std::atan(0.5 * omega * time_step);
    std::vector<double> smallest; // kinetic energy over its first value
    for (int digits = 9; digits >= 2; --digits)
      {
        const double  amplitude = std::pow(10., -digits);
        ParameterFile file(folder + "/validation/steel-bar.prm");
        file.set("Bodies/bar/Initial velocity=" + std::to_string(omega) +
                 "*1e-" + std::to_string(digits) + "*sin(pi*x/2); 0");
        const SmallRun<2> run(file);
        run.judge("steel bar, 1e-" + std::to_string(digits) + " m");

        auto kinetic = run.column("kinetic_energy");
        for (double &value : kinetic)
          value /= run.column("kinetic_energy")[0];
        if (smallest.empty())
          smallest = kinetic;
        const auto time      = run.column("time");
        double     from_wave = 0., from_smallest = 0.;
        for (std::size_t i = 0; i < time.size(); ++i)
          {
            const double wave = std::pow(std::cos(omega_of_rule * time[i]), 2);
            from_wave = std::max(from_wave, std::abs(kinetic[i] - wave));
            from_smallest =
              std::max(from_smallest, std::abs(kinetic[i] - smallest[i]));
          }
        if (digits > 2) // with 1e-2 m particles cross cells
          test::at_most("  kinetic energy, from that of the wave",
                        from_wave,
                        0.02);
        if (digits > 3)
          test::at_most("  the same, from that of 1e-9 m",
                        from_smallest,
                        10. * amplitude + 1e-10);
      }
  }

  /** A load that is there at once: twice the settlement. */
  void
  check_block(const std::string &folder)
  {
    for (const char *modulus : {"2e11", "1e12", "1e13"})
      {
        const double E = std::stod(modulus), period = 4. * std::sqrt(7800. / E);
        ParameterFile file(folder + "/validation/steel-block.prm");
        file.set(std::string("Materials/steel/Young's modulus=") + modulus);
        file.set("Time/End time=" + shortest(period));
        const SmallRun<2> run(file);
        run.judge(std::string("steel block, ") + modulus + " Pa");

        const auto y      = run.column("top_y");
        double     lowest = y[0];
        for (const double value : y)
          lowest = std::min(lowest, value);
        const double settled =
          2. * 7800. * 9.81 / E * (y[0] - 0.5 * y[0] * y[0]);
        test::at_most("  lowest point of the top, from 2 rho g H^2/(2 E)",
                      std::abs((y[0] - lowest) / settled - 1.),
                      0.03);
      }
  }

  /** Of a weight that rises to its value in 2 s, at that time: all modes. */
  double
  settlement(const double y)
  {
    const double rho = 2000., g = 9.81, H = 10., ramp = 2.,
                 M = 1e7 * 0.7 / (1.3 * 0.4), c = std::sqrt(M / rho);
    double result = 0.;
    for (unsigned int n = 1; n < 1000; ++n)
      {
        const double k = (n - 0.5) * PI / H, omega = k * c;
        result += 2. * rho * g / (M * H * k * k * k) * std::sin(k * y) *
                  (1. - std::sin(omega * ramp) / (omega * ramp));
      }
    return result;
  }

  void
  check_column(const std::string &folder)
  {
    ParameterFile     file(folder + "/validation/ramped-column.prm");
    const SmallRun<2> run(file);
    run.judge("ramped column");
    const auto top = run.column("column_upper_y");
    test::at_most("  settlement of the top, from that of waves",
                  std::abs((top[0] - top.back()) / settlement(top[0]) - 1.),
                  0.02);

    file.set("Method/Stress rule=trapezoidal");
    const SmallRun<2> trapezoidal(file);
    test::at_most("  iterations, of those of the trapezoidal rule",
                  static_cast<double>(run.iterations) / trapezoidal.iterations,
                  1.3);
  }

  /**
   * Manufactured solutions of 1e-6 m (rad): the error falls with the order of
   * the method, and 1e-9 has the same, relative to its size.
   *
   * @param coarse cells and step, twice those of the file
   */
  void
  check_manufactured(const std::string              &folder,
                     const std::string              &name,
                     const std::string              &entry,
                     const std::vector<std::string> &values,
                     const std::vector<std::string> &coarse,
                     const double                    order)
  {
    const auto error = [&](const std::string              &value,
                           const std::vector<std::string> &settings) {
      ParameterFile file(folder + "/validation/" + name + ".prm");
      file.set("Effects/Manufactured solution/" + entry + "=" + value);
      for (const std::string &setting : settings)
        file.set(setting);
      const SmallRun<2> run(file);
      run.judge(name + ", " + value);
      return run.ledger["displacement_error"] / std::stod(value);
    };
    const double fine = error(values[0], {});
    test::at_most("  order, below the expected one",
                  order - std::log2(error(values[0], coarse) / fine),
                  0.1);
    // positions of 1 m have 16 digits
    test::at_most("  error of 1e-9 from that of 1e-6, of the amplitude",
                  std::abs(error(values[1], {}) - fine),
                  1e-6 + 10. * std::numeric_limits<double>::epsilon() / 1e-9);
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::string                        folder = argv[1];
  check_bar(folder);
  check_block(folder);
  check_column(folder);
  check_manufactured(folder,
                     "vibration",
                     "vibration/Amplitude",
                     {"1e-6, -0.8e-6", "1e-9, -0.8e-9"},
                     {"Grid/Cells=8, 8", "Time/Step size=0.0004"},
                     2.);
  check_manufactured(folder,
                     "vortex",
                     "vortex/Angle",
                     {"1e-6", "1e-9"},
                     {"Grid/Cells=24, 24", "Time/Step size=0.0005"},
                     1.7);
  return test::report();
}
