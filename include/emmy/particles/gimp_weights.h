#ifndef emmy_particles_gimp_weights_h
#define emmy_particles_gimp_weights_h

#include <emmy/particles/tails.h>

#include <algorithm>
#include <cmath>

namespace emmy
{
  /** Below this half-length, relative to h, a particle is a point. */
  inline constexpr double smallest_half_length = 1e-6;

  /**
   * Domains are taken this much smaller, relatively, both to find the cells
   * and to weight the nodes: domains that should just touch a face must not
   * reach across it by round-off.
   */
  inline constexpr double shrinkage = 1.5e-8;

  /** A shape function in one direction and its derivative with respect to x. */
  struct Weight
  {
    /** 1, and 1/m. */
    double value, slope;
  };

  /**
   * The hat functions of a row of nodes, averaged over a particle's domain
   * (Bardenhagen and Kober 2004), for a half-length of any size. In each cell
   * the hats are linear, so the average over the part of the domain in that
   * cell is the value at the part's centre; the parts are weighted with their
   * share of the domain. This form has no cases, and keeps sum S = 1, sum S' =
   * 0, sum S x = x to round-off, however small the domain.
   *
   * @param x       position of the particle, from the lower end of the first
   *                overlapped cell, m
   * @param l       half-length of the domain, m; 0: the hats at x, which lies
   *                in the first cell
   * @param h       cell size, m
   * @param n_cells how many cells the domain overlaps
   * @param weights gets those of the n_cells + 1 nodes
   * @param beyond_lower,beyond_upper whether the domain goes a hair beyond
   *   these cells; the hats of the outermost ones are continued there
   */
  inline void
  gimp_weights(const double       x,
               const double       l,
               const double       h,
               const unsigned int n_cells,
               Weight            *weights,
               const bool         beyond_lower = false,
               const bool         beyond_upper = false)
  {
    if (n_cells == 1)
      {
        weights[0] = {1. - x / h, -1. / h};
        weights[1] = {x / h, 1. / h};
        return;
      }
    for (unsigned int i = 0; i <= n_cells; ++i)
      weights[i] = {0., 0.};
    double share_left = 1.;
    for (unsigned int cell = 0; cell < n_cells; ++cell)
      {
        const double low =
          cell == 0 && beyond_lower ? x - l : std::max(x - l, cell * h);
        const double high   = cell + 1 == n_cells && beyond_upper
                                ? x + l
                                : std::min(x + l, (cell + 1) * h);
        const double center = 0.5 * (low + high);
        const double share =
          cell + 1 == n_cells
            ? share_left
            : std::min(share_left, std::max(0., high - low) / (2. * l));
        share_left -= share;
        const double xi = center / h - cell;
        weights[cell].value += share * (1. - xi);
        weights[cell].slope -= share / h;
        weights[cell + 1].value += share * xi;
        weights[cell + 1].slope += share / h;
      }
  }

  /** Cells of a row that a box overlaps, counted from the grid's lower side. */
  struct Overlap
  {
    /** Nodes of the grid, along one direction. */
    unsigned int first, last;
    /** Whether the box ends a hair further. */
    bool   beyond_lower, beyond_upper;
    double tails; ///< least share of an outermost node, about; or 1
  };

  /**
   * @param below   from the grid's lower side to the particle, m
   * @param l       half-length as used, m
   * @param h       cell size, m
   * @param n_cells of the row
   */
  inline Overlap
  overlap_along(const double       below,
                const double       l,
                const double       h,
                const unsigned int n_cells)
  {
    const double n_last = n_cells - 1;
    const double first  = std::floor((below - l) / h);
    const double last   = l == 0. ? first : std::ceil((below + l) / h) - 1.;
    Overlap      result;
    result.first        = std::min(n_last, std::max(0., first));
    result.last         = std::min(n_last, std::max(first, last));
    result.beyond_lower = result.beyond_upper = false;
    result.tails                              = 1.;
    // of the node behind the part of the box in an outermost cell
    const auto share = [&](const double part) {
      return part > 0. ? part * part / (4. * l * h) : 0.;
    };
    if (result.last > result.first)
      {
        const double lower = share((result.first + 1) * h - (below - l));
        if (lower < least_share)
          {
            ++result.first;
            result.beyond_lower = true;
          }
        else
          result.tails = lower;
      }
    if (result.last > result.first)
      {
        const double upper = share(below + l - result.last * h);
        if (upper < least_share)
          {
            --result.last;
            result.beyond_upper = true;
          }
        else
          result.tails = std::min(result.tails, upper);
      }
    return result;
  }

  /** The half-length of a box in one direction as it is used. */
  struct UsedLength
  {
    double value; ///< m
    /** Changes with position and half-length, 1/m. */
    double by_x, by_l;
  };

  /**
   * @param l     half-length, m
   * @param h     cell size, m
   * @param below from the grid's lower side to the particle, m
   * @param above from there to the upper side, m
   */
  inline UsedLength
  used_half_length(const double l,
                   const double h,
                   const double below,
                   const double above)
  {
    UsedLength used{(1. - shrinkage) * l, 0., 1. - shrinkage};
    if ((1. - shrinkage) * h < used.value)
      used = {(1. - shrinkage) * h, 0., 0.};
    if (below < used.value)
      used = {below, 1., 0.};
    if (above < used.value)
      used = {above, -1., 0.};
    if (used.value < smallest_half_length * h)
      used = {0., 0., 0.};
    return used;
  }
} // namespace emmy

#endif
