// Cases that begin with a small cut: few particles, or none but one, reach the
// nodes of a cell.

#include <emmy/transfer/particle_sort.h>

#include <algorithm>
#include <cmath>

#include "suite.h"

namespace emmy
{
  namespace stability
  {
    namespace
    {
      /** Move all particles before the run starts. */
      std::function<void(Scene<2> &)>
      shift(const double by)
      {
        return [by](Scene<2> &scene) {
          for (auto &particle : scene.particles)
            {
              auto position = particle.get_location();
              position[0] += by;
              particle.set_location(position);
            }
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

      /** How the strain energy at the end depends on the offset. */
      void
      check_smooth(Suite &suite, const std::vector<Result> &results)
      {
        // boxes of GIMP are taken smaller by 1.5e-8: below that offset the new
        // cell is not entered, and its ghost faces are not there
        unsigned int least = 0;
        while (least + 1 < results.size() && offsets()[least + 1] > 1e-7)
          ++least;
        double slope = 0., jump = 0.;
        for (unsigned int i = 0; i < results.size(); ++i)
          {
            const double change =
              std::abs(results[i].strain.back() - results[least].strain.back());
            if (i < least)
              slope = std::max(slope, (change - 1e-9) / offsets()[i]);
            else
              jump = std::max(jump, change);
          }
        suite.at_most("change of the strain energy at the end per offset in "
                      "cells, of the energy",
                      slope,
                      0.3);
        suite.at_most("its jump from 1e-7 to 1e-12", jump, 1e-3);
      }

      /** One body, one method, all offsets. */
      void
      sweep(Suite     &suite,
            const bool is_tip,
            const bool is_gimp,
            const bool has_ghosts)
      {
        const std::string name = std::string(is_tip ? "tip" : "block") +
                                 (is_gimp ? ", GIMP" : ", linear") +
                                 (has_ghosts ? ", ghosts" : "");
        // all particles go to the right: none changes its cell again
        const std::string velocity =
          is_tip ? "Bodies/diamond/Initial velocity=0.5 + 0.3*(x - 3.25); "
                   "-0.3*(y - 3.25)"
                 : "Bodies/block/Initial velocity=0.5 + 0.3*(x - 3.5); "
                   "-0.3*(y - 3.5)";
        // the outermost particles lie a quarter of a cell from the edge of
        // their cells, the tip's beyond it; boxes of GIMP end another quarter
        // away
        const double edge =
          is_tip ? (is_gimp ? -0.5 : -0.25) : (is_gimp ? 0. : 0.25);
        std::vector<Run<2>> runs;
        for (const double offset : offsets())
          {
            Run<2> run;
            run.file = is_tip ? "stability/tip.prm" : "stability/block.prm";
            run.settings =
              with(with({"Time/Maximum steps=3", velocity}, gimp, is_gimp),
                   ghosts,
                   has_ghosts);
            run.prepare         = shift(edge + offset);
            run.with_conditions = true;
            run.is_stabilised   = has_ghosts;
            runs.push_back(run);
          }
        const auto results = suite.run_all<2>(name, runs);

        std::vector<Point> curve;
        unsigned int       steps = 0, fewest = 1000, most = 0;
        double             worst = 0., best = 1e300;
        for (unsigned int i = 0; i < results.size(); ++i)
          {
            curve.emplace_back(offsets()[i], results[i].mass_condition);
            steps += results[i].steps;
            fewest = std::min(fewest, results[i].most_iterations);
            most   = std::max(most, results[i].most_iterations);
            worst  = std::max({worst,
                               results[i].mass_condition,
                               results[i].jacobian_condition});
            best   = std::min(best, results[i].mass_condition);
          }
        if (is_tip)
          suite.curve(0, name, curve);
        if (!has_ghosts)
          {
            suite.at_least("condition of the mass at each offset",
                           best,
                           is_tip ? 1e15 : 50.);
            return;
          }
        suite.at_least("steps, three for each offset", steps, 60);
        suite.at_least("condition of the mass at each offset", best, 1.);
        suite.at_most("condition of mass and Jacobian", worst, 60.);
        suite.at_most("iterations: difference between offsets",
                      most - fewest,
                      0);
        check_smooth(suite, results);
      }

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
        for (const bool is_tip : {false, true})
          for (const bool is_gimp : {false, true})
            for (const bool has_ghosts : {false, true})
              sweep(suite, is_tip, is_gimp, has_ghosts);
      }

      // ----------------------------------------------------------------------

      void
      small_contacts(Suite &suite)
      {
        suite.open_case("Small contacts and cuts",
                        "A sliver of a block in the outermost cells of the "
                        "grid, beside a free edge; two blocks that meet corner "
                        "to\ncorner; a particle that flies alone.");
        for (const bool has_ghosts : {false, true})
          {
            Run<2> sliver, corners, corners_gimp;
            sliver.file           = "stability/block.prm";
            sliver.settings       = with({}, ghosts, has_ghosts);
            sliver.prepare        = shift(2. + 0.25 + 1e-6);
            corners.file          = "stability/corners.prm";
            corners.settings      = sliver.settings;
            corners_gimp          = corners;
            corners_gimp.settings = with(corners.settings, gimp, true);

            for (auto [name, run] :
                 {std::make_pair("sliver", sliver),
                  std::make_pair("corners", corners),
                  std::make_pair("corners, GIMP", corners_gimp)})
              {
                run.with_conditions = true;
                run.is_stabilised   = has_ghosts;
                const auto result   = suite.run<2>(
                  std::string(name) + (has_ghosts ? ", ghosts" : ""), run);
                suite.at_least("runs to the end", result.has_ended, 1);
                if (!has_ghosts)
                  {
                    suite.at_least("condition of the mass",
                                   result.mass_condition,
                                   50.);
                    continue;
                  }
                suite.at_most("condition of the mass",
                              result.mass_condition,
                              50.);
                check_stable(suite, result, 4, 0.35);
              }
          }
        // no ghost face touches a cell without neighbours; free flight needs
        // none
        Run<2> alone;
        alone.file            = "stability/block.prm";
        alone.settings        = {"Bodies/block/Points per direction=1",
                                 "Bodies/block/Initial velocity=0.3; 0.2",
                                 "Bodies/block/box/Lower corner=2, 2",
                                 "Bodies/block/box/Upper corner=3, 3"};
        alone.with_conditions = true;
        const auto result     = suite.run<2>("lone particle", alone);
        suite.at_least("runs to the end", result.has_ended, 1);
        suite.at_most("change of its momentum", result.linear_momentum, 1e-13);
      }

      // ----------------------------------------------------------------------

      void
      paper_scene(Suite             &suite,
                  const std::string &file,
                  const std::string &other_effects,
                  const unsigned int fewest_without,
                  const double       most_lost)
      {
        Run<2> run;
        run.file           = "paper/" + file;
        run.is_stabilised  = false;
        const auto without = suite.run<2>(file + ", nothing", run);
        suite.at_least("runs to the end", without.has_ended, 1);
        suite.at_least("iterations", without.most_iterations, fewest_without);

        run.is_stabilised = true;
        run.settings      = {"Effects/Names=" + other_effects +
                               "ghost stabilisation",
                             "Effects/Ghost stabilisation/Mass penalty=1e-3",
                             "Effects/Ghost stabilisation/Stiffness penalty=0"};
        const auto result = suite.run<2>(file + ", ghosts", run);
        check_stable(suite, result, 4, most_lost);
        suite.at_most("times halved, or damped",
                      result.halvings + result.damped,
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
        paper_scene(suite, "7.1a.prm", "point load, ", 50, 0.002);
        paper_scene(suite, "7.1b.prm", "point load, ", 50, 0.04);
        paper_scene(suite, "7.3b.prm", "", 20, 0.01);
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
              Run<3> run;
              run.file     = "validation/two-balls.prm";
              run.settings = with(with({"Bodies/left/Points per direction=2",
                                        "Bodies/right/Points per direction=2"},
                                       gimp,
                                       is_gimp),
                                  ghosts,
                                  has_ghosts);
              run.is_stabilised = has_ghosts;
              const auto result =
                suite.run<3>(std::string(is_gimp ? "GIMP" : "linear") +
                               (has_ghosts ? ", ghosts" : ""),
                             run);
              if (has_ghosts)
                {
                  check_stable(suite, result, 4, 0.25);
                  suite.at_most("times halved, or damped",
                                result.halvings + result.damped,
                                0);
                }
              else
                suite.at_least("iterations", result.most_iterations, 20);
            }
      }
    } // namespace

    std::vector<Case>
    small_cuts()
    {
      return {{"offsets", &offset_sweep},
              {"contacts", &small_contacts},
              {"paper", &paper},
              {"space", &space}};
    }
  } // namespace stability
} // namespace emmy
