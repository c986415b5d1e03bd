// A plain scene in space that chooses nothing must not stall.

#include "suite.h"

namespace emmy
{
  namespace stability
  {
    namespace
    {
      void
      cantilevers(Suite &suite)
      {
        suite.open_case(
          "Cantilevers at default settings",
          "A beam of 10 x 4 x 4 m in cells of 0.625 m, which its sides cut, "
          "bends under its own weight; steps are 15 times as long as a wave "
          "needs through a cell. The file chooses neither shape functions "
          "nor what starved nodes do; rows say what is set. With one particle "
          "per cell and direction nodes move as those of cells twice as "
          "large.");
        const std::string linear = "Method/Shape functions=linear";
        const auto        points = [](const unsigned int n) {
          return "Bodies/beam/Points per direction=" + std::to_string(n);
        };
        const auto steps = [](const unsigned int n) {
          return "Time/Maximum steps=" + std::to_string(n);
        };
        struct Variant
        {
          std::string              name, file;
          std::vector<std::string> settings;
        };
        for (const Variant &variant : std::vector<Variant>{
               {"GIMP", "cantilever", {}},
               {"GIMP, turned by 30 degrees", "cantilever-turned", {}},
               {"GIMP, 3 points", "cantilever", {points(3), steps(5)}},
               {"linear", "cantilever", {linear}},
               {"linear, turned", "cantilever-turned", {linear}},
               {"linear, 3 points", "cantilever", {linear, points(3)}},
               {"linear, 1 point", "cantilever", {linear, points(1)}},
               {"linear, 1 point, turned",
                "cantilever-turned",
                {linear, points(1)}},
               {"GIMP, 1 point", "cantilever", {points(1), steps(5)}},
               {"GIMP, 1 point, turned",
                "cantilever-turned",
                {points(1), steps(5)}}})
          {
            Run<3> run;
            run.file           = "stability/" + variant.file + ".prm";
            run.settings       = variant.settings;
            run.is_stabilised  = true;
            const auto &result = suite.run<3>(variant.name, run);
            check_stable(suite, nothing, result, 4, 0.);
            suite.at_most("times halved, or damped",
                          result.halvings + result.damped,
                          0);
            suite.at_most("work of residuals, of the energy",
                          result.residual_work,
                          1e-8); // what Newton's tolerance leaves
          }
      }
    } // namespace

    std::vector<Case>
    cantilever_cases()
    {
      return {{"cantilevers", &cantilevers}};
    }
  } // namespace stability
} // namespace emmy
