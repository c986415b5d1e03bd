#ifndef emmy_effects_node_products_h
#define emmy_effects_node_products_h

#include <emmy/effects/node_lanes.h>

namespace emmy
{
  /**
   * Nodes in one register: no more, as the compiler sends sums in wider ones
   * through memory where the processor has none so wide.
   */
  using FourNodes = LanesOf<nodes_at_once>::type;

  /**
   * sum(i, j, a, b) += sum over points q and terms l of
   * left(q, i, l, j)[a] right(q, i, l, j)[b], at
   * [((i dim + j) n_padded + a) n_padded + b], for all a and the four b from
   * @p b on. For functions with clones.
   *
   * @param reach    points that do not reach a node are passed over there
   * @param is_first whether the sum is to begin with these: what stands there
   *   is not read
   * @param left,right rows over nodes, aligned to lanes; right from b on
   */
  template <int dim, int n_terms, class Left, class Right>
  EMMY_INLINE void
  add_products_of_nodes(const Reach       &reach,
                        const unsigned int n_nodes,
                        const unsigned int b,
                        const bool         is_first,
                        const Left        &left,
                        const Right       &right,
                        double            *sum)
  {
    const unsigned int n_padded = padded<dim>(n_nodes);
    for (unsigned int a = 0; a < n_nodes; a += nodes_at_once)
      {
        unsigned int points[most_points_at_once], n_points = 0;
        for (Bits q{reach.points(b) & reach.points(a)}; q; ++q)
          points[n_points++] = *q;
        if (n_points == 0 && !is_first)
          continue;
        for (unsigned int i = 0; i < dim; ++i)
          {
            const auto target = [&](const unsigned int j,
                                    const unsigned int r) {
              return reinterpret_cast<FourNodes *>(
                sum + ((i * dim + j) * n_padded + a + r) * n_padded + b);
            };
            // these stay in registers
            FourNodes of_nodes[dim][nodes_at_once];
            for (unsigned int j = 0; j < dim; ++j)
              for (unsigned int r = 0; r < nodes_at_once; ++r)
                if (is_first)
                  of_nodes[j][r] = FourNodes{};
                else
                  of_nodes[j][r] = *target(j, r);
            for (unsigned int k = 0; k < n_points; ++k)
              for (unsigned int l = 0; l < n_terms; ++l)
                for (unsigned int j = 0; j < dim; ++j)
                  {
                    const double   *of_a = left(points[k], i, l, j) + a;
                    const FourNodes of_b = *reinterpret_cast<const FourNodes *>(
                      right(points[k], i, l, j));
                    for (unsigned int r = 0; r < nodes_at_once; ++r)
                      of_nodes[j][r] += of_a[r] * of_b;
                  }
            for (unsigned int j = 0; j < dim; ++j)
              for (unsigned int r = 0; r < nodes_at_once; ++r)
                *target(j, r) = of_nodes[j][r];
          }
      }
  }
} // namespace emmy

#endif
