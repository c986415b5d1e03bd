#ifndef emmy_math_lane_points_h
#define emmy_math_lane_points_h

#include <emmy/math/four_numbers.h>

#include <algorithm>
#include <cstddef>

namespace emmy
{
  /** Which point of a batch stands in each lane. */
  struct LanePoints
  {
    std::size_t of_lane[n_lanes]; ///< behind the last point it is repeated

    /** Points from @p first on, of so many. */
    LanePoints(const std::size_t first, const std::size_t n_points)
    {
      for (std::size_t lane = 0; lane < n_lanes; ++lane)
        of_lane[lane] = std::min(first + lane, n_points - 1);
    }
  };

  /** Columns to rows, rows to columns. */
  EMMY_INLINE void
  transpose_lanes(Lanes &a, Lanes &b, Lanes &c, Lanes &d)
  {
    static_assert(n_lanes == 4, "one number of each of four points");
    const Lanes even_ab = __builtin_shuffle(a, b, Order{0, 4, 2, 6}),
                odd_ab  = __builtin_shuffle(a, b, Order{1, 5, 3, 7}),
                even_cd = __builtin_shuffle(c, d, Order{0, 4, 2, 6}),
                odd_cd  = __builtin_shuffle(c, d, Order{1, 5, 3, 7});
    a = __builtin_shuffle(even_ab, even_cd, Order{0, 1, 4, 5});
    b = __builtin_shuffle(odd_ab, odd_cd, Order{0, 1, 4, 5});
    c = __builtin_shuffle(even_ab, even_cd, Order{2, 3, 6, 7});
    d = __builtin_shuffle(odd_ab, odd_cd, Order{2, 3, 6, 7});
  }

  /**
   * The @p n numbers that each point has one after the other, at least four,
   * side by side. For functions with clones.
   * @param numbers of the batch's first point; those of the next one stand @p n
   *   behind
   */
  template <unsigned int n>
  EMMY_INLINE void
  read_points(const double *numbers, const LanePoints &points, Lanes *to)
  {
    static_assert(n >= n_lanes, "whole registers are read");
    const double *const a  = numbers + points.of_lane[0] * n,
                        *b = numbers + points.of_lane[1] * n,
                        *c = numbers + points.of_lane[2] * n,
                        *d = numbers + points.of_lane[3] * n;
    const auto read        = [=](const unsigned int k) {
      Lanes x[n_lanes] = {read_together<Lanes>(a + k),
                          read_together<Lanes>(b + k),
                          read_together<Lanes>(c + k),
                          read_together<Lanes>(d + k)};
      transpose_lanes(x[0], x[1], x[2], x[3]);
      to[k]     = x[0];
      to[k + 1] = x[1];
      to[k + 2] = x[2];
      to[k + 3] = x[3];
    };
    for (unsigned int k = 0; k + n_lanes <= n; k += n_lanes)
      read(k);
    // some once more, where no whole register is left
    if (n % n_lanes > 0)
      read(n - n_lanes);
  }

  /** The way back. Lanes of the same point must have the same numbers. */
  template <unsigned int n>
  EMMY_INLINE void
  write_points(const Lanes *from, const LanePoints &points, double *numbers)
  {
    static_assert(n >= n_lanes, "whole registers are written");
    double *const a  = numbers + points.of_lane[0] * n,
                  *b = numbers + points.of_lane[1] * n,
                  *c = numbers + points.of_lane[2] * n,
                  *d = numbers + points.of_lane[3] * n;
    const auto write = [=](const unsigned int k) {
      Lanes x[n_lanes] = {from[k], from[k + 1], from[k + 2], from[k + 3]};
      transpose_lanes(x[0], x[1], x[2], x[3]);
      write_together(x[0], a + k);
      write_together(x[1], b + k);
      write_together(x[2], c + k);
      write_together(x[3], d + k);
    };
    for (unsigned int k = 0; k + n_lanes <= n; k += n_lanes)
      write(k);
    if (n % n_lanes > 0)
      write(n - n_lanes);
  }
} // namespace emmy

#endif
