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
   * Rows over nodes, aligned to lanes: of point q, direction i, term l and
   * component j at first + q by_point + i by_direction + l by_term +
   * j by_component. Steps that are zero or known when it is compiled cost
   * nothing.
   */
  struct NodeRows
  {
    const double *first;                                         ///< of all
    std::size_t   by_point, by_direction, by_term, by_component; ///< steps

    /** That of a point and direction. */
    EMMY_INLINE const double *
    of(const unsigned int q, const unsigned int i) const
    {
      return first + q * by_point + i * by_direction;
    }
  };

  /**
   * sum(i, j, a, b) += sum over points q and terms l of
   * left(q, i, l, j)[a] right(q, i, l, j)[b], row after row, at
   * [((a dim + i) n_padded + b) dim + j], for all a and the four b from @p b
   * on. For functions with clones.
   *
   * @param reach    points that do not reach a node are passed over there
   * @param is_first whether the sum is to begin with these: what stands there
   *   is not read
   * @param left,right right from b on
   */
  template <int dim, int n_terms>
  EMMY_INLINE void
  add_products_of_nodes(const Reach       &reach,
                        const unsigned int n_nodes,
                        const unsigned int b,
                        const bool         is_first,
                        const NodeRows    &left,
                        const NodeRows    &right,
                        double            *sum)
  {
    const std::size_t n_padded = padded<dim>(n_nodes);
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
              {
                const double *of_a = left.of(points[k], i) + a;
                const double *of_b = right.of(points[k], i);
                for (unsigned int l = 0; l < n_terms; ++l)
                  for (unsigned int r = 0; r < nodes_at_once; ++r)
                    for (unsigned int j = 0; j < dim; ++j)
                      of_nodes[r][j] +=
                        of_a[l * left.by_term + j * left.by_component + r] *
                        *reinterpret_cast<const FourNodes *>(
                          of_b + l * right.by_term + j * right.by_component);
              }
            double *to = sum + ((a * dim + i) * n_padded + b) * dim;
            for (unsigned int r = 0; r < nodes_at_once; ++r)
              write_by_node(of_nodes[r],
                            !is_first,
                            to + r * dim * n_padded * dim);
          }
      }
  }
} // namespace emmy

#endif
