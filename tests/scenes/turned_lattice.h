#ifndef emmy_tests_scenes_turned_lattice_h
#define emmy_tests_scenes_turned_lattice_h

#include <deal.II/base/point.h>

#include <cmath>
#include <stdexcept>
#include <vector>

namespace emmy
{
  namespace test
  {
    /**
     * As many points of a lattice turned by an angle as the upright lattice has
     * in a box.
     */
    inline std::vector<dealii::Point<2>>
    turned_lattice(const dealii::Point<2> &lower,
                   const dealii::Point<2> &upper,
                   const double            spacing,
                   const double            angle)
    {
      const auto   n = std::size_t(std::round(
        (upper[0] - lower[0]) * (upper[1] - lower[1]) / spacing / spacing));
      const double c = std::cos(angle), s = std::sin(angle);
      const int    reach = int(std::ceil(upper.distance(lower) / spacing)) + 1;
      for (int attempt = 0; attempt < 10000; ++attempt)
        {
          const double shift_x = (attempt % 100) / 100. * spacing,
                       shift_y = (attempt / 100) / 100. * spacing;
          std::vector<dealii::Point<2>> points;
          for (int i = -reach; i <= reach; ++i)
            for (int j = -reach; j <= reach; ++j)
              {
                const double x = i * spacing + shift_x,
                             y = j * spacing + shift_y;
                const dealii::Point<2> p(lower[0] + c * x - s * y,
                                         lower[1] + s * x + c * y);
                if (p[0] > lower[0] && p[0] < upper[0] && p[1] > lower[1] &&
                    p[1] < upper[1])
                  points.push_back(p);
              }
          if (points.size() == n)
            return points;
        }
      throw std::runtime_error("no turned lattice has as many points");
    }
  } // namespace test
} // namespace emmy

#endif
