// What studies conclude from their runs: quantities of a ledger, distances of
// paths, orders, limits, the Pareto front, against closed forms.

#include <emmy/study/study_analysis.h>
#include <emmy/study/study_quantity.h>

#include <cmath>
#include <fstream>
#include <functional>

#include "../check.h"

using namespace emmy;
using test::check;
using test::check_close;

namespace
{
  using Three = std::array<double, 3>;

  /** A ledger with so many equal steps to time 2. */
  LedgerHistory
  ledger(const unsigned int                          n_steps,
         const std::function<double(const double t)> y,
         const std::string                          &more_columns = "",
         const std::string                          &more_values  = "")
  {
    const std::string name = "analysis-ledger.csv";
    std::ofstream     file(name);
    file.precision(17);
    file << "step,time,tip_x,tip_y" << more_columns << '\n';
    for (unsigned int step = 0; step <= n_steps; ++step)
      {
        const double t = 2. * step / n_steps;
        file << step << ',' << t << ',' << 3. * t << ',' << y(t) << more_values
             << '\n';
      }
    file.close();
    return LedgerHistory(name);
  }


  StudyQuantity
  quantity(const std::string &words)
  {
    StudyQuantity result;
    check(StudyQuantity::parse(words, result), "read: " + words);
    return result;
  }


  void
  test_quantities()
  {
    // largest at 0.7, where no row is; -1 at the end
    const auto parabola = [](const double t) {
      return 0.69 - (t - 0.7) * (t - 0.7);
    };
    const LedgerHistory run = ledger(20, parabola);
    check_close(quantity("tip_y").value(run),
                parabola(2.),
                1e-14,
                "the last value");
    check_close(quantity("tip_y to 0.31").value(run),
                parabola(0.3),
                1e-14,
                "the last value in time");
    check_close(quantity("largest tip_y").value(run),
                parabola(2.),
                1e-14,
                "the largest in size");
    check_close(quantity("largest tip_y to 1.45").value(run),
                parabola(0.7),
                1e-14,
                "the largest in size, in time");
    check_close(
      quantity("time of largest tip_y from 0 to 1").value(ledger(23, parabola)),
      0.7,
      1e-12,
      "a parabola's vertex is found between rows");
    check(std::isnan(quantity("tip_y from 3").value(run)), "no row, no value");
    check(quantity("time  of   largest tip_y").name() ==
            "time_of_largest_tip_y",
          "a quantity's name");
    StudyQuantity ignored;
    for (const char *wrong : {"",
                              "smallest tip_y",
                              "tip_y from here",
                              "tip_y tip_x",
                              "tip_y from 2 to 1",
                              "largest time of tip_y"})
      check(!StudyQuantity::parse(wrong, ignored),
            std::string("refused: ") + wrong);
    check_close(quantity("time of largest tip_y from 1 to 1.5").value(run),
                1.,
                1e-12,
                "at an end of the part there is no vertex");
    check_close(quantity("tip_y to 0.2999999999").value(ledger(20, parabola)),
                parabola(0.3),
                1e-14,
                "times are compared with slack");
    check(quantity("path of tip from 7").path(run).range() == 0.,
          "no row, no range");
    check(quantity("path of tip").is_in(run), "a particle is there");
    check(!quantity("largest tip").is_in(run), "a particle is no column");
  }


  void
  test_paths()
  {
    const auto      still = [](const double) { return 0.; };
    const auto      line  = [](const double t) { return 4. * t; };
    const StudyPath a     = quantity("path of tip").path(ledger(10, line));
    const StudyPath b     = quantity("path of tip").path(ledger(7, line));
    check(a.components.size() == 2, "a path in the plane");
    check_close(distance(a, b),
                0.,
                1e-14,
                "straight paths are equal whatever the rows");
    check_close(a.range(), 8., 1e-14, "the range of a path");
    // mean square of 4 t over t = 0, 0.2, ..., 2
    const StudyPath c = quantity("path of tip").path(ledger(10, still));
    check_close(distance(a, c),
                std::sqrt(16. * 0.04 * 385. / 11.),
                1e-13,
                "root mean square");
    check_close(distance(a, c), distance(c, a), 0., "distances are symmetric");
  }


  void
  test_energies()
  {
    const LedgerHistory run = ledger(
      2,
      [](const double) { return 0.; },
      ",kinetic_energy,strain_energy,plastic_dissipation,load_work",
      ",2,3,1,4");
    check_close(run.column("total_energy").back(), 5., 0., "total energy");
    check_close(run.column("lost_energy").back(), 3., 0., "lost energy");
    check_close(run.column("lost_share").back(), 0.6, 1e-15, "lost share");
  }


  void
  test_orders_and_limits()
  {
    const std::vector<double> sizes{0.8, 0.5, 0.3, 0.1};
    for (const double order : {0.5, 1., 2., 3.7})
      {
        std::vector<double>   errors;
        std::array<double, 3> values;
        for (const double size : sizes)
          errors.push_back(0.3 * std::pow(size, order));
        const StudyOrder fit = fit_order(sizes, errors);
        check_close(fit.fitted, order, 1e-12, "order of a power");
        check(fit.steps.size() == 3, "an order per step");
        for (const double step : fit.steps)
          check_close(step, order, 1e-12, "order of a step");
        for (unsigned int i = 0; i < 3; ++i)
          values[i] = 5. - errors[i + 1];
        const StudyLimit limit =
          richardson_limit(Three{{sizes[1], sizes[2], sizes[3]}}, values);
        check_close(limit.value, 5., 1e-9, "Richardson's limit");
        check_close(limit.order, order, 1e-8, "Richardson's order");
      }
    check(fit_order({1., 1., 0.5}, {4., 4., 1.}).steps ==
            std::vector<double>({2.}),
          "equal sizes have no order");
    check(std::isnan(fit_order({1., 0.5}, {1e-3, 0.}).fitted),
          "an error of zero has no order");
    check(std::isnan(
            richardson_limit(Three{{4., 2., 1.}}, Three{{1., 2., 4.}}).value),
          "differences that grow have no limit");
    check(std::isnan(
            richardson_limit(Three{{4., 2., 1.}}, Three{{1., 2., 1.5}}).value),
          "an oscillation has no limit");
  }


  void
  test_front()
  {
    const double              none = std::nan("");
    const std::vector<double> seconds{1., 2., 3., 4., 5., 0.5, none};
    const std::vector<double> errors{0.5, 0.1, 0.2, 0.01, none, none, 0.001};
    check(pareto_front(seconds, errors) ==
            std::vector<bool>({true, true, false, true, false, false, false}),
          "the front");
    check(cheapest(seconds, errors, 0.3) == 1, "the cheapest");
    check(cheapest(seconds, errors, 0.05) == 3, "a finer one");
    check(cheapest(seconds, errors, 0.005) == -1, "none");
  }
} // namespace

int
main()
{
  test_quantities();
  test_paths();
  test_energies();
  test_orders_and_limits();
  test_front();
  return test::report();
}
