// Facts about small vibrations without any load: a bar swings along its axis
// with the frequency of its waves, a cantilever with that of Timoshenko's beam,
// and the error falls with the square of the cell size.

#include "../scene.h"

using namespace emmy;
using dealii::numbers::PI;
using test::check;

namespace
{
  constexpr double density = 1000., young_modulus = 1e7, // no Poisson's effect
    length = 1.;

  /** A scene with one elastic box, clamped at x = 0, that starts to swing. */
  struct Swing
  {
    unsigned int dim, n_cells; ///< along the box
    double       height;       ///< of the box; in 3D also its depth
    double       poisson_ratio;
    std::string  sides; ///< that are rollers; empty: clamped at x-min
    std::string  initial_velocity;
    std::string  shape_functions;
    double       period;  ///< expected, s
    unsigned int n_steps; ///< per period

    ParameterFile
    file() const
    {
      const double h     = length / n_cells;
      const bool   bends = sides.empty(); // leave room for what bulges
      const auto   list  = [&](const double x, const double y) {
        return shortest(x) + ", " + shortest(y) +
               (dim == 3 ? ", " + shortest(y) : std::string());
      };
      const double room   = bends ? 2. * h : 0.;
      const auto   across = std::lround(height / h) + (bends ? 4 : 0);
      return ParameterFile::from_text(
        "set Dimension = " + std::to_string(dim) +
          "\nsubsection Grid\nset Lower corner = " + list(0., -room) +
          "\nset Upper corner = " + list(length + 2. * h, height + room) +
          "\nset Cells = " + list(n_cells + 2, across) +
          "\nend\nsubsection Materials\nset Names = m\nsubsection m\n"
          "set Model = Hencky\nset Density = " +
          shortest(density) +
          "\nset Young's modulus = " + shortest(young_modulus) +
          "\nset Poisson's ratio = " + shortest(poisson_ratio) +
          "\nend\nend\nsubsection Bodies\nset Names = bar\n"
          "subsection bar\nset Shape = box\nset Material = m\n"
          "set Points per direction = 2\nset Initial velocity = " +
          initial_velocity + "\nsubsection box\nset Lower corner = " +
          list(0., 0.) + "\nset Upper corner = " + list(length, height) +
          "\nend\nend\nend\nsubsection Boundary conditions\n" +
          (bends ? "set Fixed = x-min" : "set Roller = " + sides) +
          "\nend\nsubsection Method\nset Shape functions = " + shape_functions +
          "\nset Starved nodes = free\nend\nsubsection Time\nset End time = 1\n"
          "set Step rule = fixed\n"
          "set Step size = " +
          shortest(period / n_steps) + "\nend\n",
        "test");
    }

    /**
     * The angular frequency, from the first two times at which the momentum
     * is zero; what the mid-point rule adds to the period, tan(w dt/2) = W
     * dt/2 with W the true frequency, is taken out.
     */
    template <int d>
    double
    frequency(const std::string &momentum) const
    {
      const SceneParameters<d> parameters(file());
      test::RunningScene<d>    run(parameters);
      std::vector<double>      zeros;
      double                   before = run.ledger[momentum];
      for (unsigned int i = 0; i < n_steps && zeros.size() < 2; ++i)
        {
          run.advance(1);
          const double now = run.ledger[momentum];
          if (before * now <= 0.)
            zeros.push_back(run.ledger["time"] -
                            run.ledger["time_step"] * now / (now - before));
          before = now;
        }
      check(zeros.size() == 2, "it swings");
      const double dt = period / n_steps;
      return 2. / dt * std::tan(0.5 * dt * PI / (zeros[1] - zeros[0]));
    }
  };

  /** Errors of the frequency on finer and finer grids fall fast enough. */
  template <int dim>
  void
  check_frequency(Swing                            swing,
                  const std::vector<unsigned int> &n_cells,
                  const std::string               &momentum,
                  const double                     least_order,
                  const double                     largest_error,
                  const std::string               &name)
  {
    const double exact  = 2. * PI / swing.period;
    double       coarse = 0.;
    for (const unsigned int n : n_cells)
      {
        swing.n_cells = n;
        const double error =
          swing.template frequency<dim>(momentum) / exact - 1.;
        std::cout << name << ", " << n << " cells: frequency off by "
                  << 100. * error << " %";
        if (coarse != 0.)
          {
            const double order = std::log2(coarse / error);
            std::cout << ", order " << order;
            check(order > least_order, name + ": order in the cell size");
          }
        std::cout << '\n';
        coarse = error;
      }
    test::at_most(name + ": error of the frequency",
                  std::abs(coarse),
                  largest_error);
  }

  /** A quarter wave in a bar with the given stiffness. */
  double
  bar_period(const double modulus)
  {
    return 4. * length / std::sqrt(modulus / density);
  }

  void
  check_bars()
  {
    const double nu = 0.3, P_wave_modulus = young_modulus * (1. - nu) /
                                            ((1. + nu) * (1. - 2. * nu));
    const std::string swing = "1e-3*sin(pi/2*x); 0";
    // With GIMP boxes at the free end reach into the next cell, by next to
    // nothing, and its error falls unevenly: 0.23, 0.16, 0.035, 0.011 % with 4
    // to 32 cells.
    for (const bool is_linear : {true, false})
      check_frequency<2>({2,
                          0,
                          0.25,
                          nu,
                          "x-min, y-min, y-max",
                          swing,
                          is_linear ? "linear" : "GIMP",
                          bar_period(P_wave_modulus),
                          60},
                         is_linear ? std::vector<unsigned int>{4, 8, 16}
                                   : std::vector<unsigned int>{8, 16},
                         "linear_momentum_x",
                         is_linear ? 1.8 : 1.5,
                         1e-3,
                         std::string("bar between rollers, ") +
                           (is_linear ? "linear" : "GIMP"));
    check_frequency<3>({3,
                        0,
                        0.25,
                        0.,
                        "",
                        swing + "; 0",
                        "linear",
                        bar_period(young_modulus),
                        40},
                       {4, 8},
                       "linear_momentum_x",
                       1.8,
                       3e-3,
                       "free bar in space, linear");
  }

  /**
   * The lowest angular frequency of Timoshenko's cantilever of unit depth with
   * the shear coefficient 5/6: from the clamped end, where w = psi = 0, the
   * two solutions are integrated to the free one, where some mixture must have
   * neither moment nor shear force.
   */
  double
  timoshenko(const double height)
  {
    const double EI    = young_modulus * std::pow(height, 3) / 12.,
                 kGA   = 5. / 6. * 0.5 * young_modulus * height,
                 rho_A = density * height,
                 rho_I = density * std::pow(height, 3) / 12.;
    using State        = dealii::Tensor<1, 4>; // w, psi, moment, shear force
    const auto determinant = [&](const double omega) {
      const auto slope = [&](const State &y) {
        State s;
        s[0] = y[1] + y[3] / kGA;
        s[1] = y[2] / EI;
        s[2] = -y[3] - rho_I * omega * omega * y[1];
        s[3] = -rho_A * omega * omega * y[0];
        return s;
      };
      State              end[2];
      constexpr unsigned n = 400;
      constexpr double   h = length / n;
      for (unsigned int i = 0; i < 2; ++i)
        {
          State &y = end[i];
          y[2 + i] = 1.;
          for (unsigned int step = 0; step < n; ++step)
            {
              const State a = slope(y), b = slope(y + 0.5 * h * a),
                          c = slope(y + 0.5 * h * b), d = slope(y + h * c);
              y += h / 6. * (a + 2. * b + 2. * c + d);
            }
        }
      return end[0][2] * end[1][3] - end[0][3] * end[1][2];
    };
    // that of Euler and Bernoulli is above
    double low = 0., high = 1.8751 * 1.8751 * std::sqrt(EI / rho_A);
    check(determinant(low) * determinant(high) < 0.,
          "Euler and Bernoulli's frequency is above Timoshenko's");
    while (high - low > 1e-12 * high)
      {
        const double middle = 0.5 * (low + high);
        (determinant(middle) * determinant(low) > 0. ? low : high) = middle;
      }
    return low;
  }

  void
  check_cantilever()
  {
    const double height = 0.1, omega = timoshenko(height);
    std::cout << std::setprecision(5) << "cantilever: Timoshenko " << omega
              << ", Euler and Bernoulli "
              << 1.8751 * 1.8751 * std::sqrt(young_modulus / density / 12.) *
                   height
              << " 1/s\n";
    check_frequency<2>(
      {2,
       0,
       height,
       0.,
       "",
       "0; 1e-3*(cosh(1.8751*x) - cos(1.8751*x) - 0.73410*(sinh(1.8751*x) - "
       "sin(1.8751*x)))",
       "linear",
       2. * PI / omega,
       40},
      {20, 40, 80},
      "linear_momentum_y",
      1.8,
      2e-3,
      "cantilever, linear");
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_bars();
  check_cantilever();
  return test::report();
}
