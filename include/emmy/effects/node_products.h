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

  /** Places in two registers. */
  typedef long long Order __attribute__((vector_size(32)));

  /**
   * Numbers of four nodes, register by component, to node by component, at
   * @p to; added to what stands there, if so asked. For functions with clones.
   */
  EMMY_INLINE void
  write_by_node(const FourNodes (&x)[2], const bool is_sum, double *to)
  {
    FourNodes      *nodes      = reinterpret_cast<FourNodes *>(to);
    const FourNodes by_node[2] = {
      __builtin_shuffle(x[0], x[1], Order{0, 4, 1, 5}),
      __builtin_shuffle(x[0], x[1], Order{2, 6, 3, 7})};
    for (int k = 0; k < 2; ++k)
      nodes[k] = is_sum ? nodes[k] + by_node[k] : by_node[k];
  }
  /** In space. */
  EMMY_INLINE void
  write_by_node(const FourNodes (&x)[3], const bool is_sum, double *to)
  {
    FourNodes *nodes = reinterpret_cast<FourNodes *>(to);
    const auto xy    = __builtin_shuffle(x[0], x[1], Order{0, 4, 4, 1}),
               yz    = __builtin_shuffle(x[1], x[2], Order{1, 5, 1, 2}),
               yx    = __builtin_shuffle(x[0], x[1], Order{0, 3, 7, 0});
    const FourNodes by_node[3] = {
      __builtin_shuffle(xy, x[2], Order{0, 1, 4, 3}),
      __builtin_shuffle(yz, x[0], Order{0, 1, 6, 3}),
      __builtin_shuffle(yx, x[2], Order{6, 1, 2, 7})};
    for (int k = 0; k < 3; ++k)
      nodes[k] = is_sum ? nodes[k] + by_node[k] : by_node[k];
  }

  /**
   * sum(i, j, a, b) += sum over points q and terms l of
   * left(q, i, l, j)[a] right(q, i, l, j)[b], row after row, at
   * [((a dim + i) n_padded + b) dim + j], for all a and the four b from @p b
   * on. For functions with clones.
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
            // these stay in registers
            FourNodes of_nodes[nodes_at_once][dim]{};
            for (unsigned int k = 0; k < n_points; ++k)
              for (unsigned int l = 0; l < n_terms; ++l)
                for (unsigned int j = 0; j < dim; ++j)
                  {
                    const double   *of_a = left(points[k], i, l, j) + a;
                    const FourNodes of_b = *reinterpret_cast<const FourNodes *>(
                      right(points[k], i, l, j));
                    for (unsigned int r = 0; r < nodes_at_once; ++r)
                      of_nodes[r][j] += of_a[r] * of_b;
                  }
            for (unsigned int r = 0; r < nodes_at_once; ++r)
              write_by_node(of_nodes[r],
                            !is_first,
                            sum + (((a + r) * dim + i) * n_padded + b) * dim);
          }
      }
  }
} // namespace emmy

#endif
