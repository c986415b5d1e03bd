#ifndef emmy_effects_node_lanes_h
#define emmy_effects_node_lanes_h

#include <emmy/math/lanes.h>

#include <array>

namespace emmy
{
  /** As many points as have their rows in the first-level cache. */
  constexpr unsigned int most_points_at_once = 8;

  /**
   * What add_node_products() does for i and j, so many nodes from a on and
   * registers of nodes from b on: their sums stay in registers.
   */
  template <int          dim,
            int          n_terms,
            unsigned int n_a,
            unsigned int n_b,
            class Left,
            class Right>
  EMMY_INLINE void
  add_node_block(const unsigned int                 n_points,
                 const unsigned int                 n_padded,
                 const bool                         is_first,
                 const std::array<unsigned int, 4> &ijab,
                 const Left                        &left,
                 const Right                       &right,
                 double                            *sum)
  {
    using Nodes             = typename LanesOf<node_lanes<dim>>::type;
    const auto [i, j, a, b] = ijab;
    double    *target = sum + ((i * dim + j) * n_padded + a) * n_padded + b;
    const auto at     = [&](const unsigned int r, const unsigned int w) {
      return reinterpret_cast<Nodes *>(target + r * n_padded +
                                       w * node_lanes<dim>);
    };
    Nodes of_node[n_a][n_b];
    for (unsigned int r = 0; r < n_a; ++r)
      for (unsigned int w = 0; w < n_b; ++w)
        if (is_first)
          of_node[r][w] = Nodes{};
        else
          of_node[r][w] = *at(r, w);
    for (unsigned int q = 0; q < n_points; ++q)
      for (unsigned int l = 0; l < n_terms; ++l)
        {
          const double *of_a = left(q, i, l, j) + a;
          const double *of_b = right(q, i, l, j) + b;
          for (unsigned int r = 0; r < n_a; ++r)
            for (unsigned int w = 0; w < n_b; ++w)
              of_node[r][w] += of_a[r] * *reinterpret_cast<const Nodes *>(
                                           of_b + w * node_lanes<dim>);
        }
    for (unsigned int r = 0; r < n_a; ++r)
      for (unsigned int w = 0; w < n_b; ++w)
        *at(r, w) = of_node[r][w];
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
    constexpr unsigned int two  = 2 * node_lanes<dim>;
    const bool             wide = n_padded % two == 0;
    for (unsigned int i = 0; i < dim; ++i)
      for (unsigned int j = 0; j < dim; ++j)
        for (unsigned int b = 0; b < n_padded; b += wide ? two : two / 2)
          for (unsigned int a = 0; a < n_nodes;)
            if (!wide)
              {
                add_node_block<dim, n_terms, 4, 1>(n_points,
                                                   n_padded,
                                                   is_first,
                                                   {{i, j, a, b}},
                                                   left,
                                                   right,
                                                   sum);
                a += 4;
              }
            else if (a + 3 <= n_padded)
              {
                add_node_block<dim, n_terms, 3, 2>(n_points,
                                                   n_padded,
                                                   is_first,
                                                   {{i, j, a, b}},
                                                   left,
                                                   right,
                                                   sum);
                a += 3;
              }
            else
              {
                add_node_block<dim, n_terms, 1, 2>(n_points,
                                                   n_padded,
                                                   is_first,
                                                   {{i, j, a, b}},
                                                   left,
                                                   right,
                                                   sum);
                a += 1;
              }
  }
} // namespace emmy

#endif
