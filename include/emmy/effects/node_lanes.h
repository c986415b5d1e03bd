#ifndef emmy_effects_node_lanes_h
#define emmy_effects_node_lanes_h

#include <emmy/math/lanes.h>

namespace emmy
{
  /** As many points as have their rows in the first-level cache. */
  constexpr unsigned int most_points_at_once = 8;

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
    using Nodes = typename LanesOf<node_lanes<dim>>::type;
    // some nodes a at a time: their sums stay in registers
    constexpr unsigned int at_once = 4;
    for (unsigned int i = 0; i < dim; ++i)
      for (unsigned int j = 0; j < dim; ++j)
        for (unsigned int b = 0; b < n_padded; b += node_lanes<dim>)
          for (unsigned int a = 0; a < n_nodes; a += at_once)
            {
              double *target =
                sum + ((i * dim + j) * n_padded + a) * n_padded + b;
              Nodes of_node[at_once];
              for (unsigned int r = 0; r < at_once; ++r)
                if (is_first)
                  of_node[r] = Nodes{};
                else
                  of_node[r] =
                    *reinterpret_cast<const Nodes *>(target + r * n_padded);
              for (unsigned int q = 0; q < n_points; ++q)
                for (unsigned int l = 0; l < n_terms; ++l)
                  {
                    const double *of_a = left(q, i, l, j) + a;
                    const Nodes   of_b =
                      *reinterpret_cast<const Nodes *>(right(q, i, l, j) + b);
                    for (unsigned int r = 0; r < at_once; ++r)
                      of_node[r] += of_a[r] * of_b;
                  }
              for (unsigned int r = 0; r < at_once; ++r)
                *reinterpret_cast<Nodes *>(target + r * n_padded) = of_node[r];
            }
  }
} // namespace emmy

#endif
