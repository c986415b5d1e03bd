#include <emmy/effects/node_products.h>
#include <emmy/effects/point_rows.h>

// vectors stay within this file
#pragma GCC diagnostic ignored "-Wpsabi"

namespace emmy
{
  namespace
  {
    /** Of nodes, in a register that PointRows counts. */
    template <int dim>
    constexpr unsigned int fours = node_lanes<dim> / nodes_at_once;

    /** The sum over the lanes. */
    EMMY_INLINE double
    sum_of(const LanesOf<4>::type &x)
    {
      return (x[0] + x[1]) + (x[2] + x[3]);
    }

    template <int dim>
    EMMY_INLINE void
    motion(PointRows<dim> &point)
    {
      using Nodes                  = FourNodes;
      constexpr int      n_weights = dim + 1;
      const unsigned int n         = point.n_padded / nodes_at_once;
      const auto        *u         = reinterpret_cast<const Nodes *>(point.u);
      const auto         sums      = [&](const double *row, double *result) {
        const auto *of_node = reinterpret_cast<const Nodes *>(row);
        Nodes       sum[dim]{};
        for (Bits bits{point.registers}; bits; ++bits)
          for (unsigned int a = *bits * fours<dim>;
               a < (*bits + 1) * fours<dim>;
               ++a)
            for (int c = 0; c < dim; ++c)
              sum[c] += of_node[a] * u[c * n + a];
        for (int c = 0; c < dim; ++c)
          result[c] = sum_of(sum[c]);
      };
      sums(point.weights, point.Su);
      for (unsigned int k = 0; k < point.n_used; ++k)
        for (int l = 0; l < n_weights; ++l)
          sums(point.weights_by_q +
                 (point.used[k] * n_weights + l) * point.n_padded,
               point.motion_by_q[k][l]);
    }

    /** With so many coordinates of the place. */
    template <int dim, int n_used>
    EMMY_INLINE void
    rows(const PointRows<dim> &point)
    {
      using Nodes                  = FourNodes;
      constexpr int      n_weights = dim + 1;
      const unsigned int n         = point.n_padded / nodes_at_once;
      const auto        *u         = reinterpret_cast<const Nodes *>(point.u);
      const auto *weights = reinterpret_cast<const Nodes *>(point.weights);
      const auto *by_q    = reinterpret_cast<const Nodes *>(point.weights_by_q);
      auto       *result  = reinterpret_cast<Nodes *>(point.by_motion);
      auto       *share   = reinterpret_cast<Nodes *>(point.share);
      auto       *diagonal = reinterpret_cast<Nodes *>(point.diagonal);

      double w_by_q[n_used][dim], T_by_q[n_used][dim][dim];
      for (int k = 0; k < n_used; ++k)
        for (int i = 0; i < dim; ++i)
          {
            w_by_q[k][i] = point.consistent * point.motion_by_q[k][0][i];
            for (int J = 0; J < dim; ++J)
              {
                double sum = 0.;
                for (int c = 0; c < dim; ++c)
                  for (int d = 0; d < dim; ++d)
                    sum += point.tangent[i * dim + J][c * dim + d] *
                           point.motion_by_q[k][1 + d][c];
                T_by_q[k][i][J] = sum;
              }
          }

      for (Bits bits{point.registers}; bits; ++bits)
        for (unsigned int a = *bits * fours<dim>; a < (*bits + 1) * fours<dim>;
             ++a)
          {
            Nodes weight[n_weights], force_by_q[n_used][dim];
            for (int l = 0; l < n_weights; ++l)
              weight[l] = weights[l * n + a];
            for (int k = 0; k < n_used; ++k)
              {
                const Nodes *here = by_q + point.used[k] * n_weights * n + a;
                for (int i = 0; i < dim; ++i)
                  {
                    Nodes sum =
                      here[0] * (point.lumped * u[i * n + a] + point.w[i]) +
                      w_by_q[k][i] * weight[0];
                    for (int J = 0; J < dim; ++J)
                      sum += point.T[i][J] * here[(1 + J) * n] +
                             T_by_q[k][i][J] * weight[1 + J];
                    force_by_q[k][i] = sum;
                  }
              }
            diagonal[a] += point.on_diagonal * weight[0] + point.least;
            for (int i = 0; i < dim; ++i)
              for (int k = 0; k < n_used; ++k)
                share[i * n + a] += point.shift[k] * force_by_q[k][i];
            for (int i = 0; i < dim; ++i)
              for (int l = 0; l < n_weights; ++l)
                for (int j = 0; j < dim; ++j)
                  {
                    // where places stay a sum of the weights
                    Nodes sum =
                      (l == 0 && i == j ? point.consistent : 0.) * weight[0];
                    if (l > 0)
                      for (int J = 0; J < dim; ++J)
                        sum += point.tangent[i * dim + J][j * dim + l - 1] *
                               weight[1 + J];
                    // the position alone does not follow L
                    if (l == 0 || n_used > dim)
                      for (int k = 0; k < n_used; ++k)
                        sum += point.by_motion_of_q[k][j][l] * force_by_q[k][i];
                    result[((i * n_weights + l) * dim + j) * n + a] = sum;
                  }
          }
    }

    template <int dim>
    EMMY_INLINE void
    products(const Reach       &reach,
             const unsigned int n_nodes,
             const bool         is_first,
             const double      *by_motion,
             const double      *weights,
             double            *sum)
    {
      constexpr int     n_weights = dim + 1;
      const std::size_t n         = padded<dim>(n_nodes);
      for (unsigned int b = 0; b < n; b += nodes_at_once)
        add_products_of_nodes<dim, n_weights>(
          reach,
          n_nodes,
          b,
          is_first,
          {by_motion,
           dim * n_weights * dim * n,
           n_weights * dim * n,
           dim * n,
           n},
          {weights + b, n_weights * n, 0, n, 0},
          sum);
    }
  } // namespace

  // no templates: those have no clones
  namespace point_rows_kernels
  {
#define KERNELS(dim)                                        \
  EMMY_CLONES void find_motion(PointRows<dim> &point)       \
  {                                                         \
    motion<dim>(point);                                     \
  }                                                         \
  EMMY_CLONES void in_one_cell(const PointRows<dim> &point) \
  {                                                         \
    rows<dim, dim>(point);                                  \
  }                                                         \
  EMMY_CLONES void across_one(const PointRows<dim> &point)  \
  {                                                         \
    rows<dim, dim + 1>(point);                              \
  }                                                         \
  EMMY_CLONES void across_two(const PointRows<dim> &point)  \
  {                                                         \
    rows<dim, dim + 2>(point);                              \
  }
    KERNELS(2)
    KERNELS(3)
#undef KERNELS
    EMMY_CLONES void
    across_three(const PointRows<3> &point)
    {
      rows<3, 6>(point);
    }

    EMMY_CLONES void
    add_in_plane(const Reach       &reach,
                 const unsigned int n_nodes,
                 const bool         is_first,
                 const double      *by_motion,
                 const double      *weights,
                 double            *sum)
    {
      products<2>(reach, n_nodes, is_first, by_motion, weights, sum);
    }
    EMMY_CLONES void
    add_in_space(const Reach       &reach,
                 const unsigned int n_nodes,
                 const bool         is_first,
                 const double      *by_motion,
                 const double      *weights,
                 double            *sum)
    {
      products<3>(reach, n_nodes, is_first, by_motion, weights, sum);
    }
  } // namespace point_rows_kernels

  template <int dim>
  void
  PointRows<dim>::find_motion()
  {
    point_rows_kernels::find_motion(*this);
  }

  template <int dim>
  void
  PointRows<dim>::find_rows() const
  {
    if (n_used == dim)
      point_rows_kernels::in_one_cell(*this);
    else if (n_used == dim + 1)
      point_rows_kernels::across_one(*this);
    else if (n_used == dim + 2)
      point_rows_kernels::across_two(*this);
    else if constexpr (dim == 3)
      point_rows_kernels::across_three(*this);
  }

  template <int dim>
  void
  add_products(const Reach       &reach,
               const unsigned int n_nodes,
               const bool         is_first,
               const double      *by_motion,
               const double      *weights,
               double            *sum)
  {
    if constexpr (dim == 2)
      point_rows_kernels::add_in_plane(
        reach, n_nodes, is_first, by_motion, weights, sum);
    else
      point_rows_kernels::add_in_space(
        reach, n_nodes, is_first, by_motion, weights, sum);
  }

#define INSTANTIATE(dim)                              \
  template struct PointRows<dim>;                     \
  template void add_products<dim>(const Reach &,      \
                                  const unsigned int, \
                                  const bool,         \
                                  const double *,     \
                                  const double *,     \
                                  double *);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
