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
      add(q, 1, node);
    }
    /** @p n points from q on reach a node. */
    void
    add(const unsigned int q, const unsigned int n, const unsigned int node)
    {
      of_fours[node / nodes_at_once] |= ((1u << n) - 1) << q;
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
} // namespace emmy

#endif
