#ifndef emmy_effects_node_lanes_h
#define emmy_effects_node_lanes_h

#include <emmy/math/lanes.h>

namespace emmy
{
  /** As many points as have their rows in the first-level cache. */
  constexpr unsigned int most_points_at_once = 8;

  /**
   * The same as add_node_products(), with the sums of so many nodes a and
   * registers of nodes b at a time, which stay in registers. Rows of the sum
   * and of left have room for nodes up to a multiple of at_once.
   */
  template <int          dim,
            int          n_terms,
            unsigned int at_once,
            unsigned int wide,
            class Left,
            class Right>
  EMMY_INLINE void
  add_node_blocks(const unsigned int n_points,
                  const unsigned int n_nodes,
                  const unsigned int n_padded,
                  const bool         is_first,
                  const Left        &left,
                  const Right       &right,
                  double            *sum)
  {
    using Nodes = typename LanesOf<node_lanes<dim>>::type;
    for (unsigned int i = 0; i < dim; ++i)
      for (unsigned int j = 0; j < dim; ++j)
        for (unsigned int b = 0; b < n_padded; b += wide * node_lanes<dim>)
          for (unsigned int a = 0; a < n_nodes; a += at_once)
            {
              double *target =
                sum + ((i * dim + j) * n_padded + a) * n_padded + b;
              const auto at = [&](const unsigned int r, const unsigned int w) {
                return reinterpret_cast<Nodes *>(target + r * n_padded +
                                                 w * node_lanes<dim>);
              };
              Nodes of_node[at_once][wide];
              for (unsigned int r = 0; r < at_once; ++r)
                for (unsigned int w = 0; w < wide; ++w)
                  if (is_first)
                    of_node[r][w] = Nodes{};
                  else
                    of_node[r][w] = *at(r, w);
              for (unsigned int q = 0; q < n_points; ++q)
                for (unsigned int l = 0; l < n_terms; ++l)
                  {
                    const double *of_a = left(q, i, l, j) + a;
                    const double *of_b = right(q, i, l, j) + b;
                    for (unsigned int r = 0; r < at_once; ++r)
                      for (unsigned int w = 0; w < wide; ++w)
                        of_node[r][w] +=
                          of_a[r] * *reinterpret_cast<const Nodes *>(
                                      of_b + w * node_lanes<dim>);
                  }
              for (unsigned int r = 0; r < at_once; ++r)
                for (unsigned int w = 0; w < wide; ++w)
                  *at(r, w) = of_node[r][w];
            }
  }

  /**
   * sum(i, j, a, b) += sum over points q and terms l of
   * left(q, i, l, j)[a] right(q, i, l, j)[b], at
   * [((i dim + j) n_padded + a) n_padded + b]. For functions with clones.
   *
   * @param is_first whether the sum is to begin with these: what stands there
   *   is not read
   * @param left,right rows over nodes, aligned to lanes
   */
  template <int dim, int n_terms, class Left, class Right>
  EMMY_INLINE void
  add_node_products(const unsigned int n_points,
                    const unsigned int n_nodes,
                    const unsigned int n_padded,
                    const bool         is_first,
                    const Left        &left,
                    const Right       &right,
                    double            *sum)
  {
    // where rows are long, two registers of each are in use at a time
    if (n_padded % (2 * node_lanes<dim>) == 0)
      add_node_blocks<dim, n_terms, 3, 2>(
        n_points, n_nodes, n_padded, is_first, left, right, sum);
    else
      add_node_blocks<dim, n_terms, 4, 1>(
        n_points, n_nodes, n_padded, is_first, left, right, sum);
  }
} // namespace emmy

#endif
