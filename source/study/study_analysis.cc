#include <emmy/base/text.h>
#include <emmy/study/study_analysis.h>
#include <emmy/study/study_table.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace emmy
{
  namespace
  {
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

    /** Geometric mean of the ratios that are numbers; NaN of none. */
    class MeanRatio
    {
    public:
      void
      add(const double ratio)
      {
        if (!(ratio > 0. && ratio < std::numeric_limits<double>::infinity()))
          return;
        sum += std::log(ratio);
        ++n;
      }

      double
      value() const
      {
        return n > 0 ? std::exp(sum / n) : unknown;
      }

    private:
      double       sum = 0.;
      unsigned int n   = 0;
    };
  } // namespace


  std::vector<StudyCurve>
  study_curves(const StudyPlan &plan)
  {
    std::vector<StudyCurve> curves;
    for (unsigned int m = 0; m < plan.members.size(); ++m)
      {
        std::vector<std::string> rest;
        for (unsigned int i = 0; i < plan.lists.size(); ++i)
          if (i != plan.refined_list && plan.lists[i].varies() &&
              !(plan.is_paired && plan.has_sizes()))
            rest.push_back(plan.lists[i].name + " = " +
                           plan.members[m].values[i]);
        const std::string name = join(rest);
        auto              curve =
          std::find_if(curves.begin(), curves.end(), [&name](const auto &c) {
            return c.name == name;
          });
        if (curve == curves.end())
          curve = curves.insert(curve, {name, {}});
        curve->members.push_back(m);
      }
    if (plan.has_sizes())
      for (StudyCurve &curve : curves)
        std::stable_sort(curve.members.begin(),
                         curve.members.end(),
                         [&plan](const unsigned int a, const unsigned int b) {
                           return size_of(plan, a) > size_of(plan, b);
                         });
    return curves;
  }


  double
  size_of(const StudyPlan &plan, const unsigned int member)
  {
    if (!plan.has_sizes())
      return unknown;
    const StudyList &list = plan.lists[plan.refined_list];
    return list
      .sizes[list.position(plan.members[member].values[plan.refined_list])];
  }


  StudyOrder
  fit_order(const std::vector<double> &sizes, const std::vector<double> &errors)
  {
    std::vector<std::pair<double, double>> points;
    for (unsigned int i = 0; i < sizes.size(); ++i)
      if (sizes[i] > 0. && errors[i] > 0.)
        points.emplace_back(std::log(sizes[i]), std::log(errors[i]));
    std::sort(points.rbegin(), points.rend());
    if (points.size() < 2 || points.front().first == points.back().first)
      return {unknown, {}};
    double x = 0., y = 0., xx = 0., xy = 0.;
    for (const auto &[size, error] : points)
      {
        x += size / points.size();
        y += error / points.size();
      }
    for (const auto &[size, error] : points)
      {
        xx += (size - x) * (size - x);
        xy += (size - x) * (error - y);
      }
    StudyOrder result{xy / xx, {}};
    for (std::size_t i = 0; i + 1 < points.size(); ++i)
      if (points[i + 1].first < points[i].first)
        result.steps.push_back((points[i + 1].second - points[i].second) /
                               (points[i + 1].first - points[i].first));
    return result;
  }


  StudyLimit
  richardson_limit(const std::array<double, 3> &sizes,
                   const std::array<double, 3> &values)
  {
    const double ratio = (values[0] - values[1]) / (values[1] - values[2]);
    // grows with the order
    const auto of_order = [&sizes](const double order) {
      return (std::pow(sizes[0] / sizes[2], order) -
              std::pow(sizes[1] / sizes[2], order)) /
             (std::pow(sizes[1] / sizes[2], order) - 1.);
    };
    double low = 0.05, high = 20.;
    if (!(ratio > of_order(low) && ratio < of_order(high)))
      return {unknown, unknown};
    for (unsigned int i = 0; i < 100; ++i)
      (of_order(0.5 * (low + high)) < ratio ? low : high) = 0.5 * (low + high);
    return {values[2] + (values[2] - values[1]) /
                          (std::pow(sizes[1] / sizes[2], low) - 1.),
            low};
  }


  std::vector<bool>
  pareto_front(const std::vector<double> &seconds,
               const std::vector<double> &errors)
  {
    std::vector<bool> result;
    for (unsigned int i = 0; i < seconds.size(); ++i)
      {
        bool is_on_it = !std::isnan(seconds[i]) && !std::isnan(errors[i]);
        for (unsigned int j = 0; j < seconds.size(); ++j)
          is_on_it =
            is_on_it && !(seconds[j] <= seconds[i] && errors[j] <= errors[i] &&
                          (seconds[j] < seconds[i] || errors[j] < errors[i]));
        result.push_back(is_on_it);
      }
    return result;
  }


  int
  cheapest(const std::vector<double> &seconds,
           const std::vector<double> &errors,
           const double               tolerance)
  {
    int best = -1;
    for (unsigned int i = 0; i < seconds.size(); ++i)
      if (errors[i] <= tolerance && !std::isnan(seconds[i]) &&
          (best < 0 || seconds[i] < seconds[best]))
        best = i;
    return best;
  }


  std::vector<StudyChoice>
  study_choices(const StudyPlan &plan, const StudyTable &table)
  {
    std::vector<StudyChoice> result;
    for (unsigned int list = 0; list < plan.lists.size(); ++list)
      for (unsigned int v = 1; v < plan.lists[list].values.size(); ++v)
        {
          StudyChoice            choice{list, v, 0, unknown, {}};
          MeanRatio              seconds;
          std::vector<MeanRatio> errors(plan.quantities.size());
          for (unsigned int a = 0; a < plan.members.size(); ++a)
            for (unsigned int b = 0; b < plan.members.size(); ++b)
              {
                auto other  = plan.members[b].values;
                other[list] = plan.lists[list].values[0];
                if (plan.members[b].values[list] !=
                      plan.lists[list].values[v] ||
                    plan.members[a].values != other)
                  continue;
                choice.n_pairs += table.is_done(a) && table.is_done(b);
                seconds.add(table.seconds(b) / table.seconds(a));
                for (unsigned int q = 0; q < errors.size(); ++q)
                  errors[q].add(table.error(b, q) / table.error(a, q));
              }
          choice.seconds = seconds.value();
          for (const MeanRatio &error : errors)
            choice.errors.push_back(error.value());
          if (choice.n_pairs > 0)
            result.push_back(choice);
        }
    return result;
  }
} // namespace emmy
