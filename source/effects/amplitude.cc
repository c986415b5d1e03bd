#include <deal.II/base/utilities.h>

#include <emmy/base/exceptions.h>
#include <emmy/base/formula.h>
#include <emmy/base/text.h>
#include <emmy/effects/amplitude.h>

#include <cmath>

namespace emmy
{
  void
  AmplitudeParameters::declare(Section &section)
  {
    section.add_parameter("Amplitude",
                          expression,
                          "Factor of the load, a formula in the time t (s): "
                          "sin(2*pi*t). Unit: 1. For a jump use <Amplitude "
                          "table>: the times of steps are sums with round-off, "
                          "and a formula may jump a step too early.");
    section.add_parameter("Amplitude table",
                          table,
                          "The factor as pairs <time: value>, with straight "
                          "lines between them and constant beyond the ends: "
                          "0: 0, 25: 1, 25: 0. Times must not decrease; two "
                          "equal ones are a jump, and at the time itself the "
                          "first value holds. Units: s, 1. Empty: <Amplitude> "
                          "is used.");
    section.add_parameter("Sampling",
                          sampling,
                          "mid: a step takes the amplitude at its middle, as "
                          "the mid-point rule does. end: at its end.",
                          dealii::ParameterAcceptor::prm,
                          dealii::Patterns::Selection("mid|end"));
  }

  namespace
  {
    constexpr const char *table_example =
      " Write pairs <time: value> separated by commas, with times (s) that do "
      "not decrease, e.g. 0: 0, 25: 1, 25: 0.";

    std::vector<std::pair<double, double>>
    read_table(const std::string &text, const std::string &section)
    {
      const auto require = [&](const bool fact, const std::string &what) {
        AssertThrow(
          fact,
          ExcParameter(section, "Amplitude table", text, what + table_example));
      };
      std::vector<std::pair<double, double>> table;
      for (const std::string &item :
           dealii::Utilities::split_string_list(text, ','))
        {
          const std::string wrong =
            "<" + item + "> is not a pair of finite numbers.";
          const auto pair = dealii::Utilities::split_string_list(item, ':');
          require(pair.size() == 2, wrong);
          try
            {
              table.emplace_back(dealii::Utilities::string_to_double(pair[0]),
                                 dealii::Utilities::string_to_double(pair[1]));
            }
          catch (const dealii::ExceptionBase &)
            {
              require(false, wrong);
            }
          require(std::isfinite(table.back().first) &&
                    std::isfinite(table.back().second),
                  wrong);
        }
      require(!table.empty(), "it has no pair.");
      for (std::size_t i = 1; i < table.size(); ++i)
        {
          require(table[i].first >= table[i - 1].first,
                  "time " + shortest(table[i].first) + " s stands after " +
                    shortest(table[i - 1].first) + " s.");
          require(i == 1 || table[i].first > table[i - 2].first,
                  "time " + shortest(table[i].first) +
                    " s stands there more than twice.");
        }
      return table;
    }
  } // namespace

  Amplitude::Amplitude(const AmplitudeParameters &parameters,
                       const std::string         &section)
    : section(section)
    , sampled_part(parameters.sampling == "end" ? 1. : 0.5)
  {
    // a file that emmy wrote has the default, 1, beside a table
    const std::string &expression = parameters.expression;
    const bool has_table = !dealii::Utilities::trim(parameters.table).empty();
    AssertThrow(!has_table || dealii::Utilities::trim(expression) == "1",
                ExcParameter(section,
                             "Amplitude",
                             expression,
                             "<Amplitude table> is given too, <" +
                               parameters.table + ">. Remove one of them."));
    if (has_table)
      {
        table = read_table(parameters.table, section);
        text  = "Amplitude table <" + parameters.table + ">";
        return;
      }
    formula = read_formulas<1>(
      expression,
      1,
      section,
      "Amplitude",
      "Write a formula in t, the time (s), e.g. if(t <= 25, t/25, 0).",
      "t");
    text = "Amplitude <" + expression + ">";
  }

  TimeHistory
  AmplitudeParameters::history(const std::string &name,
                               const std::string &section) const
  {
    const auto factor = std::make_shared<const Amplitude>(*this, section);
    return {name, [factor](const double t) { return factor->over(t, 0.); }};
  }

  double
  Amplitude::over(const double time, const double time_step) const
  {
    const double sample = time + sampled_part * time_step;
    // times are sums of steps: round-off must not carry a step over a jump
    const double value = formula ? formula->value(dealii::Point<1>(sample))
                         : table.empty() ? 1.
                                         : in_table(sample, 1e-6 * time_step);
    AssertThrow(std::isfinite(value),
                ExcRun(section,
                       text + " is " + shortest(value) +
                         " at t = " + shortest(sample) + " s",
                       "correct it: it must be finite at all times of the "
                       "run. What was written so far is kept."));
    return value;
  }

  double
  Amplitude::in_table(const double time, const double tolerance) const
  {
    for (std::size_t i = 0; i < table.size(); ++i)
      {
        const auto [end, value] = table[i];
        const bool is_jump = i + 1 < table.size() && table[i + 1].first == end;
        if (time > end + (is_jump ? tolerance : 0.))
          continue;
        if (i == 0 || time >= end)
          return value;
        const auto [start, start_value] = table[i - 1];
        return start_value +
               (value - start_value) * ((time - start) / (end - start));
      }
    return table.back().second;
  }
} // namespace emmy
