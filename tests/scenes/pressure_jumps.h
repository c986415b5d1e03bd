#pragma once

#include <deal.II/base/numbers.h>
#include <deal.II/base/point.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace emmy::test
{
  /** A cell of the plane, by its numbers along x and y. */
  using Cell = std::pair<int, int>;

  inline dealii::Point<2>
  centre_of(const Cell &cell, const double h)
  {
    return {(cell.first + 0.5) * h, (cell.second + 0.5) * h};
  }

  /**
   * How much pressures of two cells differ that touch: the largest difference,
   * where it is, and the share of pairs that differ by less than a fifth of the
   * larger pressure.
   */
  struct Jumps
  {
    double           largest = 0., share = 0.;
    dealii::Point<2> place;
  };

  /** Of cells that have a pressure. */
  inline Jumps
  jumps_of(const std::map<Cell, double> &pressures, const double h)
  {
    Jumps        result;
    unsigned int n = 0, n_small = 0;
    for (const auto &[cell, a] : pressures)
      for (const Cell &next : {Cell(cell.first + 1, cell.second),
                               Cell(cell.first, cell.second + 1)})
        if (const auto other = pressures.find(next); other != pressures.end())
          {
            const double b = other->second, jump = std::abs(a - b);
            if (jump > result.largest)
              {
                result.largest = jump;
                result.place   = centre_of(cell, h);
              }
            ++n;
            n_small += jump < 0.2 * std::max(std::abs(a), std::abs(b));
          }
    result.share = double(n_small) / n;
    return result;
  }

  /**
   * The pressure under a footing on weightless clay that flows, over its
   * undrained strength, after Prandtl: x from the middle of the footing over
   * half its width, depth likewise. A wedge below the footing, a fan around its
   * edge, a wedge that is pushed aside; NaN where the clay need not flow.
   */
  inline double
  prandtl_pressure(const double x, const double depth)
  {
    using dealii::numbers::PI;
    const double dx = x - 1., angle = std::atan2(depth, dx);
    if (x + depth <= 1.)
      return 1. + PI;
    if (angle < PI / 4. && dx + depth <= 2.)
      return 1.;
    if (angle >= PI / 4. && angle <= 3. * PI / 4. &&
        std::hypot(dx, depth) <= std::sqrt(2.))
      return 1. + 2. * (angle - PI / 4.);
    return std::numeric_limits<double>::quiet_NaN();
  }
} // namespace emmy::test
