// Cases that are hard for other reasons than small cuts: incompressibility,
// large steps, impact, contrast, many steps, tiny increments.

#include <emmy/material/material.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "suite.h"

namespace emmy
{
  namespace stability
  {
    namespace
    {
      void
      incompressible(Suite &suite)
      {
        suite.open_case(
          "Nearly incompressible",
          "`block.prm` for 2 s with Poisson's ratios up to 0.4999 and a small "
          "ghost mass. The block swings without a change of\nvolume; its shear "
          "modulus hardly depends on the ratio, so nor must the strain energy "
          "after 1 s: were the elements to lock,\nit would.");
        for (const Remedy &remedy : {small_ghosts, followers})
          {
            double expected = 0.;
            for (const char *const nu : {"0.49", "0.499", "0.4999"})
              {
                Run<2> run;
                run.file = "stability/block.prm";
                run.settings =
                  with({"Method/Locking treatment=none",
                        std::string("Materials/rubber/Poisson's ratio=") + nu,
                        "Time/End time=2"},
                       remedy.settings);
                const auto result = suite.run<2>(
                  std::string("Poisson's ratio ") + nu + remedy.name, run);
                check_stable(suite, remedy, result, 5, 0.02);
                suite.at_most("times halved, or damped",
                              result.halvings + result.damped,
                              0);
                if (expected == 0.)
                  expected = result.strain[10];
                suite.at_most("difference of the strain energy after 1 s to "
                              "that at 0.49, relative",
                              std::abs(result.strain[10] / expected - 1.),
                              0.05);
              }
          }
      }

      // ----------------------------------------------------------------------

      void
      large_steps(Suite &suite)
      {
        suite.open_case(
          "Large steps",
          "`collision.prm` and `block.prm` with steps of 1 to 150 times "
          "`normalised` (the time of a wave through a cell). Steps in\nwhich "
          "parts or a wall would pass through one another are shortened until "
          "they meet, and then to `Maximum travel`, a quarter\nof a cell: so all see "
          "the collision. A step that Newton cannot solve is halved.");
        for (const Remedy &remedy : {nothing, ghosts, followers})
          for (const unsigned int factor : {1, 5, 15, 50, 150})
            {
              Run<2> run;
              run.file          = "stability/collision.prm";
              run.settings      = with({"Time/Factor=" + std::to_string(factor),
                                        "Time/End time=8",
                                        "Time/Maximum travel=0.25"},
                                  remedy.settings);
              run.is_stabilised = !remedy.settings.empty();
              const auto result =
                suite.run<2>(std::to_string(factor) + " x" + remedy.name, run);
              if (run.is_stabilised)
                check_stable(suite, remedy, result, 10, 0.8);
              suite.at_least("largest strain energy, of the energy",
                             *std::max_element(result.strain.begin(),
                                               result.strain.end()),
                             0.1);
            }
        for (const Remedy &remedy : {ghosts, followers})
          for (const unsigned int factor : {1, 5, 15, 50, 150})
            {
              Run<2> run;
              run.file          = "stability/block.prm";
              run.settings      = with({"Time/Step rule=normalised",
                                        "Time/Factor=" + std::to_string(factor),
                                        "Time/End time=60",
                                        "Solver/Newton tolerance=1e-12"},
                                  remedy.settings);
              const auto result = suite.run<2>(
                "block, " + std::to_string(factor) + " x" + remedy.name, run);
              suite.must_end(result);
            }
      }

      // ----------------------------------------------------------------------

      /** How often a curve rises above and falls below a tenth of its top. */
      unsigned int
      n_contacts(const std::vector<double> &strain)
      {
        const double top    = *std::max_element(strain.begin(), strain.end());
        unsigned int result = 0;
        bool         is_in  = false;
        for (const double value : strain)
          if (!is_in && value > 0.3 * top)
            {
              is_in = true;
              ++result;
            }
          else if (is_in && value < 0.1 * top)
            is_in = false;
        return result;
      }

      void
      collide(Suite &suite, const std::string &fraction, const Remedy &remedy)
      {
        const double wave_speed = 5.19; // of collision.prm, m/s
        const double closing    = std::stod(fraction) * wave_speed;
        const auto   speed      = std::to_string(0.5 * closing);
        const bool   is_long    = fraction == "0.1";
        Run<2>       run;
        run.file          = "stability/collision.prm";
        run.settings      = with({"Time/End time=" +
                                    (is_long ? "30" : std::to_string(6. / closing)),
                                  "Bodies/left/Initial velocity=" + speed + "; 0",
                                  "Bodies/right/Initial velocity=-" + speed + "; 0"},
                            remedy.settings);
        run.is_stabilised = !remedy.settings.empty();
        const auto result =
          suite.run<2>("impact at " + fraction + " c" + remedy.name, run);
        if (run.is_stabilised)
          check_stable(suite,
                       remedy,
                       result,
                       fraction == "1.0" ? 2 * 100 + 1 : 20, // both tries
                       0.7);
        suite.at_most("times halved", result.halvings, is_long ? 20 : 2);
        if (is_long)
          suite.at_least("contacts", n_contacts(result.strain), 2);
      }

      void
      impact(Suite &suite)
      {
        suite.open_case(
          "Impact near the speed of sound, cells crossed, contact again",
          "`collision.prm`: the discs meet with 0.1, 0.5 and 1 times the wave "
          "speed, 5.19 m/s; at 0.1 for 30 s, in which they\npart, meet the "
          "walls and one another again. At 1.0 the discs are pressed to a "
          "fraction, and a step may need to be halved.\n`block.prm` in a long "
          "grid: 3.3 cells a step.");
        for (const Remedy &remedy : {nothing, ghosts, followers})
          {
            for (const char *const fraction : {"0.1", "0.5", "1.0"})
              collide(suite, fraction, remedy);
            Run<2> run;
            run.file          = "stability/block.prm";
            run.settings      = with({"Grid/Upper corner=80, 8",
                                      "Grid/Cells=80, 8",
                                      "Time/End time=2",
                                      "Bodies/block/Initial velocity=33 + 0.3*(x - "
                                           "3.5); -0.3*(y - 3.5)"},
                                remedy.settings);
            run.is_stabilised = !remedy.settings.empty();
            const auto result =
              suite.run<2>("3.3 cells a step" + remedy.name, run);
            check_stable(suite, remedy, result, 6, 1e-3);
            suite.at_most("change of linear momentum",
                          result.linear_momentum,
                          1e-13);
          }
      }

      // ----------------------------------------------------------------------

      void
      contrast(Suite &suite)
      {
        suite.open_case(
          "A million times as stiff, a thousand times as heavy",
          "`collision.prm`; the right disc has 1e6 times the stiffness and 1e3 "
          "times the density of the left one.");
        for (const Remedy &remedy : {nothing, ghosts, followers})
          {
            Run<2> run;
            run.file     = "stability/collision.prm";
            run.settings = with({"Materials/right rubber/Young's modulus=1e8",
                                 "Materials/right rubber/Density=5e3",
                                 "Time/Step rule=fixed",
                                 "Time/Step size=0.05",
                                 "Time/End time=4"},
                                remedy.settings);
            run.with_conditions = true;
            run.is_stabilised   = !remedy.settings.empty();
            const auto result   = suite.run<2>("discs" + remedy.name, run);
            if (run.is_stabilised)
              {
                // a node between both may follow a soft and a stiff cell
                const bool follows = remedy.name == followers.name;
                check_stable(suite, remedy, result, follows ? 5 : 4, 0.01);
                suite.at_most("condition of the Jacobian",
                              result.jacobian_condition,
                              follows ? 1e5 : 1e3);
              }
            else
              suite.at_least("iterations", result.most_iterations, 20);
          }
      }

      // ----------------------------------------------------------------------

      /** Largest balance error over a random walk of round-off. */
      double
      growth(const std::vector<double> &balance_errors)
      {
        // N steps of size e at random reach sqrt(N) e
        const double epsilon = std::numeric_limits<double>::epsilon();
        double       result  = 0.;
        for (unsigned int i = 1; i < balance_errors.size(); ++i)
          result = std::max(result,
                            std::abs(balance_errors[i]) /
                              (std::sqrt(double(i)) * epsilon));
        return result;
      }

      Result
      run_long(Suite                          &suite,
               const std::string              &file,
               const std::string              &name,
               const std::vector<std::string> &settings,
               const bool                      is_stabilised,
               const double                    residual_work)
      {
        Run<2> run;
        run.file          = "stability/" + file;
        run.settings      = settings;
        run.is_stabilised = is_stabilised;
        const auto result = suite.run<2>(name, run);

        std::vector<Point> points;
        for (unsigned int i = 50; i < result.balance_errors.size(); i += 50)
          points.emplace_back(i,
                              std::max(std::abs(result.balance_errors[i]),
                                       1e-18));
        suite.curve(Panel::steps, name, points);
        suite.at_least("steps", result.steps, 10000);
        suite.at_most("work of residuals, of the energy",
                      result.residual_work,
                      residual_work);
        if (!is_stabilised)
          return result;
        suite.at_most("balance error, of sqrt(steps) times the round-off of "
                      "the energy",
                      growth(result.balance_errors),
                      5.);
        suite.at_most("energy that the ledger does not account for",
                      result.drift,
                      1e-12);
        return result;
      }

      void
      long_runs(Suite &suite)
      {
        suite.open_case(
          "10,000 steps",
          "A block that spins and swings in free flight, some sixty turns; a "
          "bar, held at one end, that swings along its axis.\nWithout a remedy "
          "the block meets a singular matrix now and then: numbers there are "
          "so large that round-off leaves more, and Newton too.");
        run_long(suite,
                 "tumbling.prm",
                 "tumbling block, 6 x 6 points",
                 {},
                 false,
                 1e-6);
        for (const bool has_ghosts : {true, false})
          {
            const Remedy &remedy = has_ghosts ? ghosts : followers;
            const auto    result =
              run_long(suite,
                       "tumbling.prm",
                       "tumbling block, 2 x 2 points" + remedy.name,
                       with({"Bodies/block/Points per direction=2"},
                            remedy.settings),
                       true,
                       1e-10);
            suite.at_most("change of linear momentum, of m v",
                          result.linear_momentum,
                          1e-12);
            suite.at_most("change of angular momentum",
                          result.angular_momentum,
                          has_ghosts ? 1e-3 : 1e-10);
          }
        run_long(suite, "bar.prm", "vibrating bar", {}, true, 1e-10);

        std::vector<Point> line;
        for (const double n : {1., 1e4})
          line.emplace_back(n,
                            std::sqrt(n) *
                              std::numeric_limits<double>::epsilon());
        suite.curve(Panel::steps, "sqrt(step) times round-off", line);
      }

      // ----------------------------------------------------------------------

      /** Give all particles one deformation, and what the material says of it.
       */
      template <int dim>
      std::function<void(Scene<dim> &)>
      strain(const MandelVector<dim> &b)
      {
        return [b](Scene<dim> &scene) {
          MaterialBatch<dim> batch;
          batch.n_points                       = 1;
          batch.with_tangent                   = false;
          batch.left_cauchy_green_less_unit[0] = b - mandel::unit<dim>();
          scene.material_of_body[0]->evaluate(batch);
          for (auto &particle : scene.particles)
            {
              auto values = particle.get_properties();
              for (unsigned int c = 0; c < n_mandel<dim>; ++c)
                {
                  values[scene.layout["left_cauchy_green_less_unit"] + c] =
                    batch.left_cauchy_green_less_unit[0][c];
                  values[scene.layout["kirchhoff_stress"] + c] =
                    batch.kirchhoff_stress[0][c];
                }
              values[scene.layout["strain_energy_density"]] =
                batch.stored_energy[0];
            }
        };
      }

      void
      increment(Suite                          &suite,
                const std::string              &name,
                const std::vector<std::string> &settings,
                const MandelVector<2>          &b,
                const unsigned int              most_iterations)
      {
        Run<2> run;
        run.file          = "stability/block.prm";
        run.settings      = settings;
        run.prepare       = strain<2>(b);
        const auto result = suite.run<2>(name, run);
        suite.must_end(result);
        suite.at_most("iterations", result.most_iterations, most_iterations);
        suite.at_most("work of residuals, of the energy",
                      result.residual_work,
                      1e-13);
        suite.at_most("unaccounted", result.drift, 1e-12);
        suite.at_most("change of angular momentum",
                      result.angular_momentum,
                      1e-12);
      }

      void
      small_increments(Suite &suite)
      {
        suite.open_case(
          "Small and special increments",
          "`block.prm` at rest; in rigid rotation; in uniform expansion (equal "
          "eigenvalues); strained by about 10 %, with steps that\nstrain it by "
          "1e-5 down to 1e-13 more. Newton must end at round-off in each, not "
          "in noise: its tolerance is 1e-15 there.");
        const auto        unit     = mandel::unit<2>();
        const std::string velocity = "Bodies/block/Initial velocity=";
        Run<2>            rest;
        rest.file         = "stability/block.prm";
        rest.settings     = {velocity + "0; 0"};
        const auto result = suite.run<2>("rest", rest);
        suite.at_most("iterations", result.most_iterations, 0);
        suite.at_most("energy, J", result.final_energy, 0.);

        increment(suite,
                  "rotation",
                  {velocity + "-0.1*(y - 3.5); 0.1*(x - 3.5)"},
                  unit,
                  3);
        increment(suite,
                  "expansion",
                  {velocity + "0.3*(x - 3.5); 0.3*(y - 3.5)"},
                  unit,
                  3);
        MandelVector<2> b = unit;
        b[0]              = 1.2;
        b[1]              = 0.85;
        b[2]              = 0.05;
        for (const char *const dt :
             {"1e-4", "1e-5", "1e-6", "1e-7", "1e-8", "1e-9", "1e-10", "1e-12"})
          increment(suite,
                    std::string("strained, dt = ") + dt + " s",
                    {std::string("Time/Step size=") + dt,
                     "Solver/Newton tolerance=1e-15",
                     "Time/Maximum steps=10",
                     velocity + "0.1*(x - 3.5) + 0.02*(y - 3.5); -0.07*(y - "
                                "3.5)"},
                    b,
                    2);
      }
    } // namespace

    std::vector<Case>
    hard_motions()
    {
      return {{"incompressible", &incompressible},
              {"large_steps", &large_steps},
              {"impact", &impact},
              {"contrast", &contrast},
              {"long", &long_runs},
              {"increments", &small_increments}};
    }
  } // namespace stability
} // namespace emmy
