#include <emmy/effects/node_lanes.h>
#include <emmy/effects/point_rows.h>

// vectors stay within this file
#pragma GCC diagnostic ignored "-Wpsabi"

namespace emmy
{
  namespace
  {
    template <int dim>
    EMMY_INLINE void
    force_by_q(const PointRows<dim> &point)
    {
      using Nodes                  = typename LanesOf<node_lanes<dim>>::type;
      constexpr int      n_weights = dim + 1;
      const unsigned int n         = point.n_padded / node_lanes<dim>;
      const auto        *u         = reinterpret_cast<const Nodes *>(point.u);
      const auto *weights = reinterpret_cast<const Nodes *>(point.weights);
      const auto *by_q    = reinterpret_cast<const Nodes *>(point.weights_by_q);
      auto       *result  = reinterpret_cast<Nodes *>(point.force_by_q);
      for (unsigned int a = 0; a < n; ++a)
        for (unsigned int k = 0; k < point.n_used; ++k)
          {
            Nodes here[n_weights];
            for (int l = 0; l < n_weights; ++l)
              here[l] = by_q[(k * n_weights + l) * n + a];
            for (int i = 0; i < dim; ++i)
              {
                Nodes sum =
                  here[0] * (point.lumped * u[i * n + a] + point.w[i]);
                sum += point.w_by_q[k][i] * weights[a];
                for (int J = 0; J < dim; ++J)
                  sum += point.T[i][J] * here[1 + J] +
                         point.T_by_q[k][i][J] * weights[(1 + J) * n + a];
                result[(k * dim + i) * n + a] = sum;
              }
          }
    }

    template <int dim>
    EMMY_INLINE void
    by_motion(const PointRows<dim> &point)
    {
      using Nodes                  = typename LanesOf<node_lanes<dim>>::type;
      constexpr int      n_weights = dim + 1;
      const unsigned int n         = point.n_padded / node_lanes<dim>;
      const auto *weights = reinterpret_cast<const Nodes *>(point.weights);
      const auto *force   = reinterpret_cast<const Nodes *>(point.force_by_q);
      auto       *result  = reinterpret_cast<Nodes *>(point.by_motion);
      for (unsigned int a = 0; a < n; ++a)
        for (int i = 0; i < dim; ++i)
          for (int l = 0; l < n_weights; ++l)
            for (int j = 0; j < dim; ++j)
              {
                // where places stay a sum of the weights
                Nodes sum =
                  (l == 0 && i == j ? point.consistent : 0.) * weights[a];
                if (l > 0)
                  for (int J = 0; J < dim; ++J)
                    sum += point.tangent[i * dim + J][j * dim + l - 1] *
                           weights[(1 + J) * n + a];
                for (unsigned int k = 0; k < point.n_used; ++k)
                  sum += point.by_motion_of_q[k][j][l] *
                         force[(k * dim + i) * n + a];
                result[((i * n_weights + l) * dim + j) * n + a] = sum;
              }
    }

    template <int dim>
    EMMY_INLINE void
    products(const unsigned int n_points,
             const unsigned int n,
             const double      *by_motion,
             const double      *weights,
             double            *sum)
    {
      constexpr int n_weights = dim + 1;
      add_node_products<dim, n_weights>(
        n_points,
        n,
        [&](const int q, const int i, const int l, const int j) {
          return by_motion + (((q * dim + i) * n_weights + l) * dim + j) * n;
        },
        [&](const int q, const int, const int l, const int) {
          return weights + (q * n_weights + l) * n;
        },
        sum);
    }
  } // namespace

  // no templates: those have no clones
  namespace point_rows_kernels
  {
#define KERNELS(dim)                                            \
  EMMY_CLONES void find_force_by_q(const PointRows<dim> &point) \
  {                                                             \
    force_by_q<dim>(point);                                     \
  }                                                             \
  EMMY_CLONES void find_by_motion(const PointRows<dim> &point)  \
  {                                                             \
    by_motion<dim>(point);                                      \
  }
    KERNELS(2)
    KERNELS(3)
#undef KERNELS

    EMMY_CLONES void
    add_in_plane(const unsigned int n_points,
                 const unsigned int n,
                 const double      *by_motion,
                 const double      *weights,
                 double            *sum)
    {
      products<2>(n_points, n, by_motion, weights, sum);
    }
    EMMY_CLONES void
    add_in_space(const unsigned int n_points,
                 const unsigned int n,
                 const double      *by_motion,
                 const double      *weights,
                 double            *sum)
    {
      products<3>(n_points, n, by_motion, weights, sum);
    }
  } // namespace point_rows_kernels

  template <int dim>
  void
  PointRows<dim>::find_force_by_q() const
  {
    point_rows_kernels::find_force_by_q(*this);
  }

  template <int dim>
  void
  PointRows<dim>::find_by_motion() const
  {
    point_rows_kernels::find_by_motion(*this);
  }

  template <int dim>
  void
  add_products(const unsigned int n_points,
               const unsigned int n_padded,
               const double      *by_motion,
               const double      *weights,
               double            *sum)
  {
    if constexpr (dim == 2)
      point_rows_kernels::add_in_plane(
        n_points, n_padded, by_motion, weights, sum);
    else
      point_rows_kernels::add_in_space(
        n_points, n_padded, by_motion, weights, sum);
  }

#define INSTANTIATE(dim)                              \
  template struct PointRows<dim>;                     \
  template void add_products<dim>(const unsigned int, \
                                  const unsigned int, \
                                  const double *,     \
                                  const double *,     \
                                  double *);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
