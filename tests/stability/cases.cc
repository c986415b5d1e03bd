#include <emmy/material/material.h>
#include <emmy/transfer/grid_to_particles.h>

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
      const std::string ghosts = "Effects/Names=ghost stabilisation";
      const std::string gimp   = "Method/Shape functions=GIMP";
      std::vector<std::string>
      operator+(std::vector<std::string> a, const std::vector<std::string> &b)
      {
        a.insert(a.end(), b.begin(), b.end());
        return a;
      }

      /** Move all particles before the run starts. */
      template <int dim>
      std::function<void(Scene<dim> &)>
      shift(const dealii::Tensor<1, dim> &by)
      {
        return [by](Scene<dim> &scene) {
          for (auto &particle : scene.particles)
            particle.set_location(particle.get_location() + by);
          sort_into_cells(scene.grid, scene.particles);
        };
      }

      /** 20 offsets from 1e-1 down to 1e-12, in cells. */
      std::vector<double>
      offsets()
      {
        std::vector<double> result;
        for (unsigned int i = 0; i < 20; ++i)
          result.push_back(std::pow(10., -1. - 11. * i / 19.));
        return result;
      }

      // ----------------------------------------------------------------------

      void
      sweep(Suite                          &suite,
            const std::string              &file,
            const std::string              &name,
            const std::vector<std::string> &settings,
            const double                    edge,
            const bool                      is_stabilised)
      {
        std::vector<Run<2>> runs;
        for (const double offset : offsets())
          {
            dealii::Tensor<1, 2> by;
            by[0] = edge + offset;
            runs.push_back({"stability/" + file,
                            settings,
                            shift<2>(by),
                            true,
                            is_stabilised});
          }
        const auto results = suite.run_all<2>(name, runs);

        std::vector<Point> conditions;
        for (unsigned int i = 0; i < results.size(); ++i)
          conditions.emplace_back(offsets()[i], results[i].mass_condition);
        if (file == "tip.prm")
          suite.curve(0, name, conditions);
        if (!is_stabilised)
          {
            if (file == "tip.prm")
              suite.at_least("largest condition",
                             results.back().mass_condition,
                             1e15);
            return;
          }

        unsigned int fewest = 1000, most = 0;
        double       worst = 0., slope = 0., jump = 0.;
        // boxes of GIMP are taken smaller by 1.5e-8: below that offset the new
        // cell is not entered, and its ghost faces are not there
        unsigned int least = 0;
        while (least + 1 < results.size() && offsets()[least + 1] > 1e-7)
          ++least;
        for (unsigned int i = 0; i < results.size(); ++i)
          {
            fewest = std::min(fewest, results[i].most_iterations);
            most   = std::max(most, results[i].most_iterations);
            worst  = std::max({worst,
                               results[i].mass_condition,
                               results[i].jacobian_condition});
            const double change =
              std::abs(results[i].final_strain - results[least].final_strain) /
              results[i].energy;
            if (i < least)
              slope = std::max(slope, (change - 1e-9) / offsets()[i]);
            else
              jump = std::max(jump, change);
          }
        suite.at_most("largest condition", worst, 100.);
        suite.at_most("most iterations in a step, between offsets",
                      most - fewest,
                      0);
        suite.at_most("change of the strain energy at the end per offset in "
                      "cells, of the energy",
                      slope,
                      1.);
        suite.at_most("jump of the strain energy from 1e-7 to 1e-12, of the "
                      "energy",
                      jump,
                      0.02);
      }

      // ----------------------------------------------------------------------

      void
      offset_sweep(Suite &suite)
      {
        suite.open_case(
          "A body shifted through a cell",
          "20 offsets from 1e-1 to 1e-12 cells, three steps each, which end "
          "before further particles change cells. `block.prm`: a\nwhole side "
          "of a block reaches into new cells; `tip.prm`: a single particle "
          "does, and feeds two new nodes, so that\nthe mass matrix is singular "
          "at any offset.");
        for (const std::string file : {"block.prm", "tip.prm"})
          for (const bool is_gimp : {false, true})
            for (const bool has_ghosts : {false, true})
              {
                const std::string center = file == "tip.prm" ? "3.25" : "3.5";
                std::vector<std::string> settings{
                  "Time/Maximum steps=3",
                  "Bodies/" +
                    std::string(file == "tip.prm" ? "diamond" : "block") +
                    "/Initial velocity=0.5 + 0.3*(x - " + center +
                    "); -0.3*(y - " + center + ")"};
                if (is_gimp)
                  settings.push_back(gimp);
                if (has_ghosts)
                  settings.push_back(ghosts);
                // the outermost particles lie a quarter of a cell from the
                // edge of their cells; boxes of GIMP end there
                sweep(suite,
                      file,
                      file.substr(0, file.find('.')) +
                        (is_gimp ? ", GIMP" : ", linear") +
                        (has_ghosts ? ", ghosts" : ""),
                      settings,
                      file == "tip.prm" ? (is_gimp ? -0.5 : -0.25)
                                        : (is_gimp ? 0. : 0.25),
                      has_ghosts);
              }
      }

      // ----------------------------------------------------------------------

      void
      corners(Suite &suite)
      {
        suite.open_case("Small contacts and cuts",
                        "A sliver of a block in the outermost cells of the "
                        "grid, beside a free edge; two blocks that meet corner "
                        "to\ncorner; a particle that flies alone.");
        dealii::Tensor<1, 2> to_edge;
        to_edge[0] = 2. + 0.25 + 1e-6;
        for (const bool has_ghosts : {false, true})
          {
            const std::string              with = has_ghosts ? ", ghosts" : "";
            const std::vector<std::string> effects =
              has_ghosts ? std::vector<std::string>{ghosts}
                         : std::vector<std::string>{};
            const auto run_one = [&](const std::string &name,
                                     const Run<2>      &run) {
              const auto result = suite.run<2>(name + with, run);
              suite.at_least("runs to the end", result.has_ended, 1);
              if (!has_ghosts)
                return;
              suite.at_most("condition of the mass",
                            result.mass_condition,
                            100.);
              suite.at_most("most iterations", result.most_iterations, 4);
            };
            run_one("sliver",
                    {"stability/block.prm", effects, shift<2>(to_edge), true});
            run_one("corner contact",
                    {"stability/corners.prm", effects, {}, true});
            run_one("corner contact, GIMP",
                    {"stability/corners.prm",
                     effects + std::vector<std::string>{gimp},
                     {},
                     true});
          }
        // no ghost face touches a cell without neighbours: free flight
        const auto lone =
          suite.run<2>("lone particle",
                       {"stability/block.prm",
                        {"Bodies/block/Points per direction=1",
                         "Bodies/block/Initial velocity=0.3; 0.2",
                         "Bodies/block/box/Lower corner=2, 2",
                         "Bodies/block/box/Upper corner=3, 3"},
                        {},
                        true});
        suite.at_least("runs to the end", lone.has_ended, 1);
        suite.at_most("change of its momentum", lone.linear_momentum, 1e-13);
      }

      // ----------------------------------------------------------------------

      void
      paper_scene(Suite             &suite,
                  const std::string &file,
                  const std::string &other_effects)
      {
        const auto without =
          suite.run<2>(file + ", nothing",
                       {"paper/" + file, {}, {}, false, false});
        suite.at_least("runs to the end", without.has_ended, 1);
        suite.at_most("work of residuals, of the energy",
                      without.residual_work,
                      1e-6);
        const auto with =
          suite.run<2>(file + ", ghosts",
                       {"paper/" + file,
                        {"Effects/Names=" + other_effects +
                           "ghost stabilisation",
                         "Effects/Ghost stabilisation/Mass penalty=1e-3",
                         "Effects/Ghost stabilisation/Stiffness penalty=0"},
                        {}});
        suite.at_least("runs to the end", with.has_ended, 1);
        suite.at_most("most iterations", with.most_iterations, 6);
        suite.at_most("times halved, or damped",
                      with.halvings + with.damped,
                      0);
      }

      void
      paper(Suite &suite)
      {
        suite.open_case(
          "Examples 7.1 and 7.3B of the paper",
          "GIMP; a particle alone in a new cell makes Newton's matrix singular. "
          "Without ghosts the damped try takes over\n(`run.log` names each such "
          "step), or Newton is slow; a small ghost mass, `Mass penalty = 1e-3` "
          "and `Stiffness\npenalty = 0`, ends this.");
        paper_scene(suite, "7.1a.prm", "point load, ");
        paper_scene(suite, "7.1b.prm", "point load, ");
        paper_scene(suite, "7.3b.prm", "");
      }

      // ----------------------------------------------------------------------

      void
      space(Suite &suite)
      {
        suite.open_case(
          "Space, eight points per cell",
          "`two-balls.prm` with 2 x 2 x 2 points per cell instead "
          "of 8 x 8 x 8.");
        for (const bool has_ghosts : {false, true})
          for (const bool is_gimp : {false, true})
            {
              std::vector<std::string> settings{
                "Bodies/left/Points per direction=2",
                "Bodies/right/Points per direction=2"};
              if (is_gimp)
                settings.push_back(gimp);
              if (has_ghosts)
                settings.push_back(ghosts);
              const auto result = suite.run<3>(
                std::string(is_gimp ? "GIMP" : "linear") +
                  (has_ghosts ? ", ghosts" : ""),
                {"validation/two-balls.prm", settings, {}, false, has_ghosts});
              if (!has_ghosts)
                continue;
              suite.at_least("runs to the end", result.has_ended, 1);
              suite.at_most("most iterations", result.most_iterations, 4);
              suite.at_most("times halved, or damped",
                            result.halvings + result.damped,
                            0);
            }
      }

      // ----------------------------------------------------------------------

      void
      incompressible(Suite &suite)
      {
        suite.open_case(
          "Nearly incompressible",
          "`block.prm` for 10 s, 100 steps, with Poisson's ratios "
          "up to 0.4999 and ghosts.");
        for (const char *const nu : {"0.3", "0.49", "0.499", "0.4999"})
          {
            const auto result =
              suite.run<2>(std::string("Poisson's ratio ") + nu,
                           {"stability/block.prm",
                            {ghosts,
                             std::string("Materials/rubber/Poisson's ratio=") +
                               nu,
                             "Time/End time=10"},
                            {},
                            true});
            suite.at_least("runs to the end", result.has_ended, 1);
            suite.at_most("most iterations", result.most_iterations, 8);
            suite.at_most("times halved", result.halvings, 0);
          }
      }

      // ----------------------------------------------------------------------

      void
      large_steps(Suite &suite)
      {
        suite.open_case(
          "Large steps",
          "`collision.prm` with steps of 1 to 150 times `normalised` (the time "
          "of a wave through a cell). What a step cannot\nresolve is cut down, "
          "in words, and never wrong.");
        for (const bool has_ghosts : {false, true})
          for (const unsigned int factor : {1, 5, 15, 50, 150})
            {
              std::vector<std::string> settings{"Time/Factor=" +
                                                  std::to_string(factor),
                                                "Time/End time=8"};
              if (has_ghosts)
                settings.push_back(ghosts);
              const auto result = suite.run<2>(
                std::to_string(factor) + " x" + (has_ghosts ? ", ghosts" : ""),
                {"stability/collision.prm", settings, {}, false, has_ghosts});
              if (has_ghosts)
                suite.at_least("runs to the end", result.has_ended, 1);
            }
      }

      // ----------------------------------------------------------------------

      void
      impact(Suite &suite)
      {
        suite.open_case(
          "Impact near the speed of sound, cells crossed, contact again",
          "`collision.prm`: the discs meet with 0.1, 0.5 and 1 times the wave "
          "speed, 5.19 m/s; at 0.1 they part, meet the walls\nand each other "
          "again. `block.prm` in a long grid: 3.3 cells a step.");
        for (const bool has_ghosts : {false, true})
          {
            const std::string with = has_ghosts ? ", ghosts" : "";
            for (const double fraction : {0.1, 0.5, 1.})
              {
                // half the speed each
                const std::string speed = std::to_string(0.5 * fraction * 5.19);
                std::vector<std::string> settings{
                  "Time/End time=" + std::to_string(6. / (fraction * 5.19)),
                  "Bodies/left/Initial velocity=" + speed + "; 0",
                  "Bodies/right/Initial velocity=-" + speed + "; 0"};
                if (fraction == 0.1)
                  settings[0] = "Time/End time=30";
                if (has_ghosts)
                  settings.push_back(ghosts);
                const auto result = suite.run<2>(
                  "impact at " + std::to_string(fraction).substr(0, 3) + " c" +
                    with,
                  {"stability/collision.prm", settings, {}, false, has_ghosts});
                if (has_ghosts)
                  {
                    suite.at_least("runs to the end", result.has_ended, 1);
                    suite.at_most("most iterations",
                                  result.most_iterations,
                                  20);
                  }
              }
            std::vector<std::string> settings{
              "Grid/Upper corner=80, 8",
              "Grid/Cells=80, 8",
              "Time/End time=2",
              "Bodies/block/Initial velocity=33 + 0.3*(x - 3.5); -0.3*(y - "
              "3.5)"};
            if (has_ghosts)
              settings.push_back(ghosts);
            const auto result = suite.run<2>(
              "3.3 cells a step" + with,
              {"stability/block.prm", settings, {}, true, has_ghosts});
            suite.at_least("runs to the end", result.has_ended, 1);
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
        for (const bool has_ghosts : {false, true})
          {
            std::vector<std::string> settings{
              "Materials/right rubber/Young's modulus=1e8",
              "Materials/right rubber/Density=5e3",
              "Time/Step rule=fixed",
              "Time/Step size=0.05",
              "Time/End time=4"};
            if (has_ghosts)
              settings.push_back(ghosts);
            const auto result = suite.run<2>(
              has_ghosts ? "ghosts" : "nothing",
              {"stability/collision.prm", settings, {}, true, has_ghosts});
            if (has_ghosts)
              suite.at_least("runs to the end", result.has_ended, 1);
          }
      }

      // ----------------------------------------------------------------------

      void
      run_long(Suite                          &suite,
               const std::string              &file,
               const std::string              &name,
               const std::vector<std::string> &settings,
               const double                    residual_work)
      {
        const auto result =
          suite.run<2>(name, {"stability/" + file, settings, {}});
        suite.at_least("steps", result.steps, 10000);

        // a random walk of N steps of size e reaches sqrt(N) e
        const double       epsilon = std::numeric_limits<double>::epsilon();
        double             growth  = 0.;
        std::vector<Point> points;
        for (unsigned int i = 0; i < result.balance_errors.size(); ++i)
          {
            const double error = std::abs(result.balance_errors[i]);
            growth = std::max(growth, error / (std::sqrt(i + 1.) * epsilon));
            if ((i + 1) % 50 == 0)
              points.emplace_back(i + 1, std::max(error, 1e-18));
          }
        suite.curve(1, name, points);
        suite.at_most("largest balance error, of sqrt(steps) times the "
                      "round-off of the energy",
                      growth,
                      5.);
        suite.at_most("work of residuals, of the energy",
                      result.residual_work,
                      residual_work);
        suite.at_most("drift of the energy that the ledger does not account "
                      "for",
                      result.drift,
                      1e-12);
        if (file == "tumbling.prm")
          suite.at_most("drift of linear momentum, of m v",
                        result.linear_momentum,
                        1e-11);
        if (file == "tumbling.prm" && result.lost == 0.)
          suite.at_most("drift of angular momentum, of m v times the grid's "
                        "size",
                        result.angular_momentum,
                        residual_work);
      }

      void
      long_runs(Suite &suite)
      {
        suite.open_case("10,000 steps",
                        "A block that spins and swings in free flight; a bar "
                        "that swings along its axis.");
        run_long(
          suite, "tumbling.prm", "tumbling block, 6 x 6 points", {}, 1e-6);
        run_long(suite,
                 "tumbling.prm",
                 "tumbling block, 2 x 2 points, ghosts",
                 {"Bodies/block/Points per direction=2", ghosts},
                 1e-11);
        run_long(suite, "bar.prm", "vibrating bar", {}, 1e-10);
        std::vector<Point> line;
        for (const double n : {1., 1e4})
          line.emplace_back(n,
                            std::sqrt(n) *
                              std::numeric_limits<double>::epsilon());
        suite.curve(1, "sqrt(step) times round-off", line);
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
          batch.n_points             = 1;
          batch.with_tangent         = false;
          batch.left_cauchy_green[0] = b;
          scene.material_of_body[0]->evaluate(batch);
          for (auto &particle : scene.particles)
            {
              auto values = particle.get_properties();
              for (unsigned int c = 0; c < n_mandel<dim>; ++c)
                {
                  values[scene.layout["left_cauchy_green"] + c] = b[c];
                  values[scene.layout["kirchhoff_stress"] + c] =
                    batch.kirchhoff_stress[0][c];
                }
              values[scene.layout["strain_energy_density"]] =
                batch.stored_energy[0];
            }
        };
      }

      void
      small_increments(Suite &suite)
      {
        suite.open_case(
          "Small and special increments",
          "`block.prm` at rest; in rigid rotation; in uniform expansion (equal "
          "eigenvalues); strained by 10 %, with steps that\nstrain it by "
          "1e-5 down to 1e-13 more. Newton must end at round-off in each, not "
          "in noise.");
        const auto rest = suite.run<2>("rest",
                                       {"stability/block.prm",
                                        {"Bodies/block/Initial velocity=0; 0"},
                                        {}});
        suite.at_most("iterations", rest.most_iterations, 0);
        suite.at_most("energy", rest.final_energy, 0.);
        const auto rotation = suite.run<2>(
          "rotation",
          {"stability/block.prm",
           {"Bodies/block/Initial velocity=-0.1*(y - 3.5); 0.1*(x - 3.5)"},
           {}});
        suite.at_most("most iterations", rotation.most_iterations, 4);
        suite.at_most("change of angular momentum",
                      rotation.angular_momentum,
                      1e-13);
        const auto expansion = suite.run<2>(
          "expansion",
          {"stability/block.prm",
           {"Bodies/block/Initial velocity=0.3*(x - 3.5); 0.3*(y - 3.5)"},
           {}});
        suite.at_most("most iterations", expansion.most_iterations, 4);

        MandelVector<2> b = mandel::unit<2>();
        b[0]              = 1.2;
        b[1]              = 0.85;
        b[2]              = 0.05;
        for (const char *const dt :
             {"1e-4", "1e-5", "1e-6", "1e-7", "1e-8", "1e-9", "1e-10", "1e-12"})
          {
            const auto result =
              suite.run<2>(std::string("strained, dt = ") + dt + " s",
                           {"stability/block.prm",
                            {std::string("Time/Step size=") + dt,
                             "Solver/Newton tolerance=1e-15",
                             "Time/Maximum steps=10",
                             "Bodies/block/Initial velocity=0.1*(x - 3.5) + "
                             "0.02*(y - 3.5); -0.07*(y - 3.5)"},
                            strain<2>(b)});
            suite.at_least("runs to the end", result.has_ended, 1);
            suite.at_most("most iterations", result.most_iterations, 4);
            suite.at_most("work of residuals, of the energy",
                          result.residual_work,
                          1e-13);
          }
      }
    } // namespace

    std::vector<Case>
    cases()
    {
      return {{"offsets", &offset_sweep},
              {"corners", &corners},
              {"paper", &paper},
              {"space", &space},
              {"incompressible", &incompressible},
              {"large_steps", &large_steps},
              {"impact", &impact},
              {"contrast", &contrast},
              {"long", &long_runs},
              {"increments", &small_increments}};
    }
  } // namespace stability
} // namespace emmy
