// What is done against small cuts, side by side: nothing, more points, ghosts,
// followers.

#include <algorithm>
#include <cmath>

#include "suite.h"

namespace emmy
{
  namespace stability
  {
    namespace
    {
      /** Examples 7.2 and 7.3B on the grid of 7.3B. */
      Run<2>
      example(const std::string &file,
              const unsigned int n,
              const Remedy      &remedy)
      {
        const std::string points = "Points per direction=" + std::to_string(n);
        Run<2>            run;
        run.file            = "paper/" + file;
        run.settings        = with({"Grid/Cells=40, 24",
                                    "Bodies/left/" + points,
                                    "Bodies/right/" + points,
                                    "Time/Step rule=fixed",
                                    "Time/Step size=0.0602",
                                    "Solver/Newton tolerance=1e-15"},
                            remedy.settings);
        run.with_conditions = true;
        run.is_stabilised   = !remedy.settings.empty();
        return run;
      }

      /** Of a curve over time at another time, by linear interpolation. */
      double
      value_at(const double               time,
               const std::vector<double> &times,
               const std::vector<double> &values)
      {
        const auto   upper = std::upper_bound(times.begin(), times.end(), time);
        const size_t i =
          std::clamp<size_t>(upper - times.begin(), 1, times.size() - 1);
        const double part = (time - times[i - 1]) / (times[i] - times[i - 1]);
        return values[i - 1] + part * (values[i] - values[i - 1]);
      }

      /** Largest difference of the kinetic energies, each of its own energy. */
      double
      difference(const Result &one, const Result &other)
      {
        double result = 0.;
        for (unsigned int i = 0; i < one.times.size(); ++i)
          result = std::max(result,
                            std::abs(one.kinetic[i] - value_at(one.times[i],
                                                               other.times,
                                                               other.kinetic)));
        return result;
      }

      /** @param most_different of kinetic energies, of the energy */
      void
      compare(Suite             &suite,
              const std::string &file,
              const Panel        panel,
              const double       most_lost,
              const double       most_different)
      {
        const auto run =
          [&](const unsigned int n, const Remedy &remedy, const bool is_drawn) {
            const std::string points =
              std::to_string(n) + " x " + std::to_string(n);
            const auto result = suite.run<2>(file + ", " + points + remedy.name,
                                             example(file, n, remedy));
            if (is_drawn)
              for (const auto &[name, values] :
                   {std::make_pair("kinetic", result.kinetic),
                    std::make_pair("strain", result.strain)})
                {
                  std::vector<Point> points_of_curve;
                  for (unsigned int i = 0; i < values.size(); ++i)
                    points_of_curve.emplace_back(result.times[i], values[i]);
                  suite.curve(panel,
                              std::string(name) + ", " + points + remedy.name,
                              points_of_curve);
                }
            return result;
          };
        run(2, nothing, false);
        const Result many = run(8, nothing, true);
        suite.must_end(many);
        for (const Remedy &remedy : {small_ghosts, followers})
          {
            const Result result = run(2, remedy, true);
            check_stable(suite, remedy, result, 6, most_lost);
            suite.at_most("times halved, or damped",
                          result.halvings + result.damped,
                          0);
            suite.at_most("kinetic energy: difference to 8 x 8 points, of the "
                          "energy",
                          difference(result, many),
                          most_different);
            if (remedy.name == followers.name)
              {
                suite.at_most("work of residuals, of the energy",
                              result.residual_work,
                              1e-11);
                suite.at_most("condition of the mass",
                              result.mass_condition,
                              100.);
              }
          }
      }

      void
      side_by_side(Suite &suite)
      {
        suite.open_case(
          "Nothing, more points, ghosts, followers",
          "Examples 7.2 (elastic, linear functions) and 7.3B (plastic, GIMP), "
          "both on the grid of 7.3B with steps of 0.0602 s to 8 s.\n\n"
          "![Energies over time](pictures/remedies.png)\n\n"
          "As the discs part, the nodes between them starve: with followers "
          "they follow one disc, and outermost particles of the other\nstretch. "
          "A particle all of whose nodes follow one root moves rigidly with "
          "it and keeps its strain. With 2 x 2 points and linear\nfunctions the "
          "discs so keep more of the energy as strain; GIMP and many points "
          "feed these nodes better.");
        compare(suite, "7.2.prm", Panel::elastic, 0.2, 0.25);
        compare(suite, "7.3b.prm", Panel::plastic, 0.1, 0.06);
        // GIMP on the elastic example
        const auto with_gimp = [](const unsigned int n, const Remedy &remedy) {
          auto run = example("7.2.prm", n, remedy);
          run.settings.push_back(gimp);
          return run;
        };
        const Result many =
          suite.run<2>("7.2.prm, GIMP, 8 x 8", with_gimp(8, nothing));
        const Result few = suite.run<2>("7.2.prm, GIMP, 2 x 2" + followers.name,
                                        with_gimp(2, followers));
        check_stable(suite, followers, few, 6, 0.);
        suite.at_most("kinetic energy: difference to 8 x 8 points, of the "
                      "energy",
                      difference(few, many),
                      0.04);
      }
    } // namespace

    std::vector<Case>
    remedies()
    {
      return {{"remedies", &side_by_side}};
    }
  } // namespace stability
} // namespace emmy
