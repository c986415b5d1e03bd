#include <emmy/base/text.h>
#include <emmy/study/study_quantity.h>

#include <deal.II/base/utilities.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <sstream>

namespace emmy
{
  std::vector<double>
  StudyPath::at(const double time) const
  {
    const std::size_t next =
      std::lower_bound(times.begin(), times.end(), time) - times.begin();
    std::vector<double> result;
    for (const auto &values : components)
      if (next == 0 || next == times.size())
        result.push_back(next == 0 ? values.front() : values.back());
      else
        {
          const double weight =
            (time - times[next - 1]) / (times[next] - times[next - 1]);
          result.push_back((1. - weight) * values[next - 1] +
                           weight * values[next]);
        }
    return result;
  }


  double
  StudyPath::range() const
  {
    double result = 0.;
    for (const auto &values : components)
      if (!values.empty())
        {
          const auto [lowest, highest] =
            std::minmax_element(values.begin(), values.end());
          result = std::max(result, *highest - *lowest);
        }
    return result;
  }


  double
  distance(const StudyPath &a, const StudyPath &b)
  {
    const StudyPath &coarse = a.times.size() <= b.times.size() ? a : b;
    const StudyPath &fine   = a.times.size() <= b.times.size() ? b : a;
    if (a.components.size() != b.components.size() || coarse.times.empty())
      return std::numeric_limits<double>::quiet_NaN();
    double sum = 0.;
    for (std::size_t row = 0; row < coarse.times.size(); ++row)
      {
        const std::vector<double> other = fine.at(coarse.times[row]);
        for (unsigned int c = 0; c < other.size(); ++c)
          sum += std::pow(coarse.components[c][row] - other[c], 2);
      }
    return std::sqrt(sum / coarse.times.size());
  }


  bool
  StudyQuantity::parse(const std::string &words, StudyQuantity &quantity)
  {
    std::istringstream       stream(words);
    std::vector<std::string> rest(std::istream_iterator<std::string>(stream),
                                  {});
    quantity       = {};
    quantity.words = join(rest, " ");
    while (rest.size() > 2)
      {
        const std::string limit = rest[rest.size() - 2];
        if (limit != "from" && limit != "to")
          break;
        char *end = nullptr;
        (limit == "from" ? quantity.from : quantity.to) =
          std::strtod(rest.back().c_str(), &end);
        if (*end != '\0')
          return false;
        rest.resize(rest.size() - 2);
      }
    if (rest.empty())
      return false;
    quantity.column = rest.back();
    rest.pop_back();
    for (const auto &[kind, start] :
         {std::make_pair(Kind::last, ""),
          std::make_pair(Kind::largest, "largest"),
          std::make_pair(Kind::time_of_largest, "time of largest"),
          std::make_pair(Kind::path, "path of")})
      if (join(rest, " ") == start)
        {
          quantity.kind = kind;
          return quantity.from < quantity.to;
        }
    return false;
  }


  std::string
  StudyQuantity::name() const
  {
    return dealii::Utilities::replace_in_string(words, " ", "_");
  }


  bool
  StudyQuantity::is_in(const LedgerHistory &ledger) const
  {
    return ledger.has(column) ||
           (kind == Kind::path && ledger.has(column + "_x"));
  }


  std::pair<std::size_t, std::size_t>
  StudyQuantity::rows(const std::vector<double> &times) const
  {
    // times are sums of steps: 0.1 + 0.1 + 0.1 is in <to 0.3>
    const double slack = 1e-9 * std::abs(times.back());
    return {std::lower_bound(times.begin(), times.end(), from - slack) -
              times.begin(),
            std::upper_bound(times.begin(), times.end(), to + slack) -
              times.begin()};
  }


  double
  StudyQuantity::value(const LedgerHistory &ledger) const
  {
    const std::vector<double> &times  = ledger.column("time");
    const std::vector<double> &values = ledger.column(column);
    const auto [first, end]           = rows(times);
    if (first >= end)
      return std::numeric_limits<double>::quiet_NaN();
    if (kind == Kind::last)
      return values[end - 1];
    std::size_t most = first;
    for (std::size_t row = first; row < end; ++row)
      if (std::abs(values[row]) >= std::abs(values[most]))
        most = row;
    if (kind == Kind::largest)
      return values[most];
    const auto is_below = [&](const std::size_t row) {
      return std::abs(values[row]) <= std::abs(values[most]);
    };
    if (most == 0 || most + 1 == times.size() || !is_below(most - 1) ||
        !is_below(most + 1))
      return times[most]; // at an end of the part: no vertex
    // Newton's form of the parabola: a (t - t0) + b (t - t0)(t - t1)
    const double step_old = times[most] - times[most - 1];
    const double step_new = times[most + 1] - times[most];
    const double a        = (values[most] - values[most - 1]) / step_old;
    const double b        = ((values[most + 1] - values[most]) / step_new - a) /
                     (step_old + step_new);
    return b == 0. ? times[most]
                   : times[most - 1] + 0.5 * step_old - 0.5 * a / b;
  }


  StudyPath
  StudyQuantity::path(const LedgerHistory &ledger) const
  {
    std::vector<std::string> columns;
    if (ledger.has(column))
      columns.push_back(column);
    else
      for (const char *axis : {"_x", "_y", "_z"})
        if (ledger.has(column + axis))
          columns.push_back(column + axis);
    const std::vector<double> &times = ledger.column("time");
    StudyPath                  result;
    result.components.resize(columns.size());
    const auto [first, end] = rows(times);
    for (std::size_t row = first; row < end; ++row)
      {
        result.times.push_back(times[row]);
        for (unsigned int c = 0; c < columns.size(); ++c)
          result.components[c].push_back(ledger.column(columns[c])[row]);
      }
    return result;
  }
} // namespace emmy
