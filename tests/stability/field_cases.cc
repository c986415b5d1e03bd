#include <algorithm>
#include <cmath>

#include "suite.h"

namespace emmy
{
  namespace stability
  {
    namespace
    {
      /** A number of a run that has a right value. */
      struct Fact
      {
        std::string what;
        std::string column;    ///< of the ledger
        double      time;      ///< s; below zero: at the end
        bool        is_change; ///< from the start
        double      right, tolerance;
      };

      double
      found(const Result &result, const Fact &fact)
      {
        const auto &values = result.ledger.at(fact.column);
        const auto &times  = result.ledger.at("time");
        const auto  row =
          fact.time < 0.
             ? values.size() - 1
             : std::lower_bound(times.begin(), times.end(), fact.time - 1e-9) -
                times.begin();
        return values[std::min<std::size_t>(row, values.size() - 1)] -
               (fact.is_change ? values.front() : 0.);
      }

      Result
      run_file(Suite                          &suite,
               const std::string              &variant,
               const std::string              &file,
               const std::vector<std::string> &settings)
      {
        Run<2> run;
        run.file     = file;
        run.settings = settings;
        return suite.run<2>(variant, run);
      }

      /** Run a file; each fact must be right. */
      void
      expect(Suite                          &suite,
             const std::string              &variant,
             const std::string              &file,
             const std::vector<std::string> &settings,
             const std::vector<Fact>        &facts)
      {
        const Result result = run_file(suite, variant, file, settings);
        suite.must_end(result);
        for (const Fact &fact : facts)
          suite.is(fact.what, found(result, fact), fact.right, fact.tolerance);
      }

      /** Run a file; the fact is wrong, by at least so much. */
      void
      expect_wrong(Suite                          &suite,
                   const std::string              &variant,
                   const std::string              &file,
                   const std::vector<std::string> &settings,
                   const Fact                     &fact)
      {
        const Result result = run_file(suite, variant, file, settings);
        suite.at_least(fact.what + ": error",
                       std::abs(found(result, fact) - fact.right),
                       fact.tolerance);
      }

      const std::string start  = "Method/Geometry=start",
                        linear = "Method/Shape functions=linear";

      void
      settling_columns(Suite &suite)
      {
        const std::string sudden = "field/sudden-column.prm",
                          slow   = "validation/slow-column.prm";
        const Fact at_8{"top at 8 s, m", "top_y", 8., true, -2.001, 0.04};
        const Fact at_15{
          "top at 15.9 s, m", "top_y", 15.9, true, -0.159, 0.0032};
        const Fact at_48{"top at 48 s, m", "top_y", 48., true, -1.7282, 0.0173};
        expect(suite, "sudden column", sudden, {}, {at_8, at_15});
        expect_wrong(suite,
                     "sudden column, start",
                     sudden,
                     {start},
                     {"top at 15.9 s, m", "top_y", 15.9, true, -0.159, 0.5});
        expect(suite, "slow column", slow, {}, {at_48});
        expect_wrong(suite,
                     "slow column, start",
                     slow,
                     {start},
                     {"top at 48 s, m", "top_y", 48., true, -1.7282, 0.08});
      }

      void
      field(Suite &suite)
      {
        suite.open_case(
          "Cases from the field",
          "Scenes after what users of other codes have reported, in "
          "`prm/field`, each with its right value; `test_field CASE` prints "
          "more of\neach. *start*: `Method/Geometry = start`, which the paper "
          "has; *linear*: linear functions. Both are wrong where the default "
          "is\nnot, and say so in the run.");
        settling_columns(suite);
        expect(suite,
               "hanging bar",
               "field/hanging-bar.prm",
               {},
               {{"tip at 0.396 s, m", "tip_y", 0.396, true, -0.191, 0.002}});
        expect_wrong(
          suite,
          "hanging bar, linear",
          "field/hanging-bar.prm",
          {linear},
          {"largest drop of the tip, m", "tip_y", 0.104, true, -0.191, 0.3});
        expect(suite,
               "flight over edges of cells",
               "field/flight-over-cell-edges.prm",
               {},
               {{"place at 6 s, m", "p_x", 6., false, 1.5, 1e-12}});
        expect(suite,
               "free fall",
               "field/free-fall.prm",
               {},
               {{"place at 1.4 s, m", "p_y", 1.4, false, 5.6362, 1e-9}});
        expect(suite,
               "end time",
               "field/end-time.prm",
               {},
               {{"end, s", "time", -1., false, 1., 1e-12}});
        expect(
          suite,
          "two discs",
          "field/two-discs.prm",
          {},
          {{"momentum, kg m/s", "linear_momentum_x", -1., true, 0., 1e-9}});
        expect(suite,
               "thrown at a wall",
               "field/thrown-at-wall.prm",
               {"Time/Step size=0.01"},
               {});
        expect(suite,
               "two pieces of one body",
               "field/two-pieces.prm",
               {"Time/Step size=0.002"},
               {{"way of the left piece, m", "left_x", -1., true, 3.8, 1.2}});
        expect(suite, "fold", "field/fold.prm", {}, {});
        expect(
          suite,
          "shifted box",
          "field/shifted-box.prm",
          {},
          {{"lower side at first, m", "e_lower_x", 0., false, 1.06, 1e-12}});
        expect(suite,
               "slope",
               "field/slope.prm",
               {},
               {{"momentum at 1.5 s, kg m/s",
                 "linear_momentum_x",
                 1.5,
                 false,
                 7357.5,
                 1e-8}});
        expect(suite,
               "disc into water",
               "field/disc-into-water.prm",
               {},
               {{"lowest point, m", "e_lower_y", -1., false, -0.185, 0.01}});
        expect(
          suite,
          "block on faces of cells",
          "field/block-on-faces.prm",
          {},
          {{"momentum, kg m/s", "linear_momentum_y", 1., false, -4000., 1e-7}});
      }
    } // namespace

    std::vector<Case>
    field_cases()
    {
      return {{"field", &field}};
    }
  } // namespace stability
} // namespace emmy
