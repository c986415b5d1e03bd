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

      /** A body in free flight to the right, for three steps. */
      Run<2>
      flight(const bool    is_tip,
             const bool    is_gimp,
             const Remedy &remedy,
             const double  offset)
      {
        Run<2> run;
        run.file = is_tip ? "stability/tip.prm" : "stability/block.prm";
        run.settings =
          with({"Time/Maximum steps=3",
                is_tip
                  ? "Bodies/diamond/Initial velocity=0.5 + 0.3*(x - 3.25); "
                    "-0.3*(y - 3.25)"
                  : "Bodies/block/Initial velocity=0.5 + 0.3*(x - 3.5); "
                    "-0.3*(y - 3.5)"},
               remedy.settings);
        if (is_gimp)
          run.settings.push_back(gimp);
        run.prepare       = shift(offset);
        run.is_stabilised = !remedy.settings.empty();
        return run;
      }

      std::string
      name_of(const bool is_tip, const bool is_gimp, const Remedy &remedy)
      {
        return std::string(is_tip ? "tip" : "block") +
               (is_gimp ? ", GIMP" : ", linear") + remedy.name;
      }

      /**
       * Where nodes follow, the least mass of a fed node is a part of the full
       * one: with GIMP 0.02, so that conditions go to 1/0.02. At a tip the box
       * of a single particle can feed two nodes; then the mass is singular,
       * but the Jacobian is not.
       */
      void
      check_conditions(Suite                     &suite,
                       const bool                 is_lone,
                       const Remedy              &remedy,
                       const std::vector<Result> &results)
      {
        double mass = 0., jacobian = 0.;
        for (const Result &result : results)
          {
            mass     = std::max(mass, result.mass_condition);
            jacobian = std::max(jacobian, result.jacobian_condition);
          }
        suite.at_most("condition of the Jacobian", jacobian, 100.);
        if (!is_lone || remedy.name != followers.name)
          suite.at_most("condition of the mass", mass, 60.);
      }

      /** One body, one method, all offsets. */
      void
      sweep(Suite        &suite,
            const bool    is_tip,
            const bool    is_gimp,
            const Remedy &remedy)
      {
        const std::string name = name_of(is_tip, is_gimp, remedy);
        // all particles go to the right: none changes its cell again; the
        // outermost particles lie a quarter of a cell from the edge of
        // their cells, the tip's beyond it; boxes of GIMP end another quarter
        // away
        const double edge =
          is_tip ? (is_gimp ? -0.5 : -0.25) : (is_gimp ? 0. : 0.25);
        std::vector<Run<2>> runs;
        for (const double offset : offsets())
          {
            Run<2> run = flight(is_tip, is_gimp, remedy, edge + offset);
            run.with_conditions = true;
            runs.push_back(run);
          }
        const auto results = suite.run_all<2>(name, runs);

        std::vector<Point> curve;
        unsigned int       steps = 0, fewest = 1000, most = 0;
        double             best = 1e300;
        for (unsigned int i = 0; i < results.size(); ++i)
          {
            curve.emplace_back(offsets()[i], results[i].mass_condition);
            steps += results[i].steps;
            fewest = std::min(fewest, results[i].most_iterations);
            most   = std::max(most, results[i].most_iterations);
            best   = std::min(best, results[i].mass_condition);
          }
        if (is_tip)
          suite.curve(Panel::tip, name, curve);
        if (remedy.settings.empty())
          {
            suite.at_least("condition of the mass at each offset",
                           best,
                           is_tip ? 1e15 : 50.);
            return;
          }
        suite.at_least("steps, three for each offset", steps, 60);
        suite.at_least("condition of the mass at each offset", best, 1.);
        check_conditions(suite, is_tip && is_gimp, remedy, results);
        suite.at_most("iterations: difference between offsets",
                      most - fewest,
                      is_gimp ? 1 : 0);
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
            for (const Remedy &remedy : {nothing, ghosts, followers})
              sweep(suite, is_tip, is_gimp, remedy);
      }

      // ----------------------------------------------------------------------

      /** Largest differences between two runs: strain energy, of the energy,
       * and positions at the end, in cells. */
      struct Jump
      {
        double strain = 0., position = 0.;

        void
        include(const Result &one, const Result &other)
        {
          strain =
            std::max(strain, std::abs(one.strain.back() - other.strain.back()));
          for (unsigned int i = 0; i < one.positions.size(); ++i)
            position =
              std::max(position,
                       std::abs(one.positions[i] - other.positions[i]));
        }
      };

      /** Move a body through a cell; where followers change, look closely. */
      void
      find_jumps(Suite &suite, const bool is_tip, const bool is_gimp)
      {
        const std::string name = name_of(is_tip, is_gimp, followers);
        const auto        run  = [&](const double offset) {
          return suite.measure<2>(name,
                                  flight(is_tip, is_gimp, followers, offset));
        };
        std::vector<Result> results;
        Jump                jump;
        unsigned int        n_changes = 0;
        for (unsigned int i = 0; i <= 40; ++i)
          {
            // not at round numbers, where particles lie on faces
            double upper = i / 40. + 0.003, lower = upper - 1. / 40.;
            results.push_back(run(upper));
            if (i == 0 || results[i].followers == results[i - 1].followers)
              continue;
            Result at_lower = results[i - 1], at_upper = results[i];
            while (upper - lower > 1e-10)
              {
                const double middle    = 0.5 * (lower + upper);
                const Result at_middle = run(middle);
                const bool is_lower = at_middle.followers == at_lower.followers;
                (is_lower ? lower : upper)       = middle;
                (is_lower ? at_lower : at_upper) = at_middle;
              }
            jump.include(at_lower, at_upper);
            ++n_changes;
          }
        suite.add_row(name, results);
        suite.at_least("changes", n_changes, 4);
        suite.at_most("jump of the strain energy, of the energy",
                      jump.strain,
                      0.03);
        suite.at_most("jump of a particle's position, in cells",
                      jump.position,
                      0.03);
      }

      void
      class_changes(Suite &suite)
      {
        suite.open_case(
          "A node begins or ceases to follow",
          "The block and the diamond of the offsets, at 41 places of a cell, "
          "three steps each. Where the nodes that follow differ\nbetween two "
          "places, the place of the change is found to 1e-10 cells, and the "
          "results on both sides are compared.");
        for (const bool is_tip : {false, true})
          for (const bool is_gimp : {false, true})
            find_jumps(suite, is_tip, is_gimp);
      }

      // ----------------------------------------------------------------------

      void
      small_contacts(Suite &suite)
      {
        suite.open_case("Small contacts and cuts",
                        "A sliver of a block in the outermost cells of the "
                        "grid, beside a free edge; two blocks that meet corner "
                        "to\ncorner; a particle that flies alone.");
        for (const Remedy &remedy : {nothing, ghosts, followers})
          {
            Run<2> sliver, corners, corners_gimp;
            sliver.file           = "stability/block.prm";
            sliver.settings       = remedy.settings;
            sliver.prepare        = shift(2. + 0.25 + 1e-6);
            corners.file          = "stability/corners.prm";
            corners.settings      = sliver.settings;
            corners_gimp          = corners;
            corners_gimp.settings = with(corners.settings, {gimp});

            for (auto [name, run] :
                 {std::make_pair("sliver", sliver),
                  std::make_pair("corners", corners),
                  std::make_pair("corners, GIMP", corners_gimp)})
              {
                run.with_conditions = true;
                run.is_stabilised   = !remedy.settings.empty();
                const auto result   = suite.run<2>(name + remedy.name, run);
                suite.must_end(result);
                if (remedy.settings.empty())
                  {
                    suite.at_least("condition of the mass",
                                   result.mass_condition,
                                   50.);
                    continue;
                  }
                // the least fed node has 0.15 of the full mass, or 0.02
                const bool is_gimp = name == std::string("corners, GIMP");
                suite.at_most("condition of the mass",
                              result.mass_condition,
                              is_gimp ? 100. : 50.);
                check_stable(suite, remedy, result, 5, 0.35);
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
        suite.must_end(result);
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
        suite.must_end(without);
        suite.at_least("iterations", without.most_iterations, fewest_without);

        run.is_stabilised = true;
        for (const Remedy &remedy : {small_ghosts, followers})
          {
            run.settings = remedy.settings;
            // where the first one names the effect, the scene's stay
            if (run.settings[0].find("Effects/Names=") == 0)
              run.settings[0].insert(run.settings[0].find('=') + 1,
                                     other_effects);
            const auto result = suite.run<2>(file + remedy.name, run);
            check_stable(suite, remedy, result, 4, most_lost);
            suite.at_most("times halved, or damped",
                          result.halvings + result.damped,
                          0);
          }
      }

      void
      paper(Suite &suite)
      {
        suite.open_case(
          "Examples 7.1 and 7.3B of the paper",
          "GIMP; a particle alone in a new cell makes Newton's matrix singular. "
          "Without a remedy the damped try takes over\n(`run.log` names each such "
          "step), or Newton is slow; a small ghost mass, `Mass penalty = 1e-3` "
          "and `Stiffness\npenalty = 0`, ends this, and so do followers.");
        paper_scene(suite, "7.1a.prm", "point load, ", 50, 0.002);
        paper_scene(suite, "7.1b.prm", "point load, ", 50, 0.04);
        paper_scene(suite, "7.3b.prm", "", 20, 0.03);
      }

      // ----------------------------------------------------------------------

      void
      space(Suite &suite)
      {
        suite.open_case(
          "Space, eight points per cell",
          "`two-balls.prm` with 2 x 2 x 2 points per cell instead "
          "of 8 x 8 x 8.");
        // ghosts do not keep places of the middle still at ragged edges
        const std::vector<std::pair<std::string, std::vector<std::string>>>
          functions = {{"linear", {}},
                       {"GIMP, start", {gimp, at_start}},
                       {"GIMP", {gimp}}};
        for (const Remedy &remedy : {nothing, ghosts, followers})
          for (const auto &[name, settings] : functions)
            {
              if (name == "GIMP" && remedy.name != followers.name)
                continue;
              Run<3> run;
              run.file     = "validation/two-balls.prm";
              run.settings = with(with({"Bodies/left/Points per direction=2",
                                        "Bodies/right/Points per direction=2"},
                                       remedy.settings),
                                  settings);
              run.is_stabilised = !remedy.settings.empty();
              const auto result = suite.run<3>(name + remedy.name, run);
              if (run.is_stabilised)
                {
                  check_stable(suite, remedy, result, 4, 0.25);
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
              {"class_changes", &class_changes},
              {"contacts", &small_contacts},
              {"paper", &paper},
              {"space", &space}};
    }
  } // namespace stability
} // namespace emmy
