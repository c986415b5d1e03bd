#ifndef emmy_effects_node_lanes_h
#define emmy_effects_node_lanes_h

#include <emmy/math/lanes.h>

#include <cstdint>
#include <vector>

namespace emmy
{
  /** As many points as have their rows in the first-level cache. */
  constexpr unsigned int most_points_at_once = 8;

  /** Nodes a whose sums stay in registers. */
  constexpr unsigned int nodes_at_once = 4;

  /**
   * Which of some points reach which nodes of a neighbourhood: a bit for each
   * point, by fours of nodes.
   */
  class Reach
  {
  public:
    /** No point, of so many nodes, whole fours. */
    void
    reinit(const unsigned int n_nodes)
    {
      of_fours.assign(n_nodes / nodes_at_once, 0);
    }
    /** Point q reaches a node. */
    void
    add(const unsigned int q, const unsigned int node)
    {
      of_fours[node / nodes_at_once] |= 1u << q;
    }
    /** A bit for each register of that many nodes, if point q reaches one. */
    template <unsigned int n_lanes>
    std::uint64_t
    registers(const unsigned int q) const
    {
      std::uint64_t result = 0;
      for (unsigned int k = 0; k < of_fours.size(); ++k)
        result |= std::uint64_t(of_fours[k] >> q & 1)
                  << (k * nodes_at_once / n_lanes);
      return result;
    }
    /** Those that reach any of @p n nodes from one on, both whole fours. */
    unsigned int
    points(const unsigned int node, const unsigned int n = nodes_at_once) const
    {
      unsigned int result = 0;
      for (unsigned int k = node; k < node + n; k += nodes_at_once)
        result |= of_fours[k / nodes_at_once];
      return result;
    }

  private:
    std::vector<unsigned char> of_fours;
  };

  /** The bits that are set, one after the other: for (Bits k{bits}; k; ++k). */
  struct Bits
  {
    std::uint64_t bits; ///< those that are left

    /** Whether there are any. */
    EMMY_INLINE explicit operator bool() const
    {
      return bits != 0;
    }
    /** The first of them. */
    EMMY_INLINE unsigned int
    operator*() const
    {
      return __builtin_ctzll(bits);
    }
    /** Go on to the next one. */
    EMMY_INLINE void
    operator++()
    {
      bits &= bits - 1;
    }
  };

  /**
   * sum(i, j, a, b) += sum over points q and terms l of
   * left(q, i, l, j)[a] right(q, i, l, j)[b], at
   * [((i dim + j) n_padded + a) n_padded + b], for all a and a full register
   * of b from @p b on. For functions with clones.
   *
   * @param reach    points that do not reach a node are passed over there
   * @param is_first whether the sum is to begin with these: what stands there
   *   is not read
   * @param left,right rows over nodes, aligned to lanes; right from b on
   */
  template <int dim, int n_terms, class Left, class Right>
  EMMY_INLINE void
  add_node_products(const Reach       &reach,
                    const unsigned int n_nodes,
                    const unsigned int b,
                    const bool         is_first,
                    const Left        &left,
                    const Right       &right,
                    double            *sum)
  {
    using Nodes                 = typename LanesOf<node_lanes<dim>>::type;
    const unsigned int n_padded = padded<dim>(n_nodes);
    const unsigned int of_b     = reach.points(b, node_lanes<dim>);
    for (unsigned int a = 0; a < n_nodes; a += nodes_at_once)
      {
        unsigned int points[most_points_at_once], n_points = 0;
        for (Bits q{of_b & reach.points(a)}; q; ++q)
          points[n_points++] = *q;
        if (n_points == 0 && !is_first)
          continue;
        for (unsigned int i = 0; i < dim; ++i)
          for (unsigned int j = 0; j < dim; ++j)
            {
              double *target =
                sum + ((i * dim + j) * n_padded + a) * n_padded + b;
              Nodes of_node[nodes_at_once];
              for (unsigned int r = 0; r < nodes_at_once; ++r)
                if (is_first)
                  of_node[r] = Nodes{};
                else
                  of_node[r] =
                    *reinterpret_cast<const Nodes *>(target + r * n_padded);
              for (unsigned int k = 0; k < n_points; ++k)
                for (unsigned int l = 0; l < n_terms; ++l)
                  {
                    const double *of_a = left(points[k], i, l, j) + a;
                    const Nodes   of_b = *reinterpret_cast<const Nodes *>(
                      right(points[k], i, l, j));
                    for (unsigned int r = 0; r < nodes_at_once; ++r)
                      of_node[r] += of_a[r] * of_b;
                  }
              for (unsigned int r = 0; r < nodes_at_once; ++r)
                *reinterpret_cast<Nodes *>(target + r * n_padded) = of_node[r];
            }
      }
  }
} // namespace emmy

#endif
