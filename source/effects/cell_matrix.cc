#include <emmy/effects/cell_matrix.h>
#include <emmy/effects/node_lanes.h>

#include <algorithm>

// vectors stay within this file
#pragma GCC diagnostic ignored "-Wpsabi"

namespace emmy
{
  namespace
  {
    template <int dim>
    EMMY_INLINE void
    find_products(const CellArrays &arrays)
    {
      using Nodes          = typename LanesOf<node_lanes<dim>>::type;
      const unsigned int n = arrays.n_padded / node_lanes<dim>;
      const auto *slopes   = reinterpret_cast<const Nodes *>(arrays.slopes);
      auto       *products = reinterpret_cast<Nodes *>(arrays.products);
      for (unsigned int q = 0; q < arrays.n_points; ++q)
        for (unsigned int b = 0; b < n; ++b)
          {
            Nodes slope[dim];
            for (int L = 0; L < dim; ++L)
              slope[L] = arrays.volumes[q] * slopes[(q * dim + L) * n + b];
            // of row iJ and column jL
            const double *tangent = arrays.tangents + q * dim * dim * dim * dim;
            for (int iJj = 0; iJj < dim * dim * dim; ++iJj)
              {
                Nodes product = tangent[dim * iJj] * slope[0];
                for (int L = 1; L < dim; ++L)
                  product += tangent[dim * iJj + L] * slope[L];
                products[(q * dim * dim * dim + iJj) * n + b] = product;
              }
          }
    }

    template <int dim>
    EMMY_INLINE void
    add_products(const CellArrays &arrays)
    {
      const unsigned int n = arrays.n_padded;
      add_node_products<dim, dim>(
        arrays.n_points,
        arrays.n_nodes,
        n,
        arrays.is_first,
        [&](const int q, const int, const int J, const int) {
          return arrays.slopes + (q * dim + J) * n;
        },
        [&](const int q, const int i, const int J, const int j) {
          return arrays.products +
                 ((q * dim * dim + i * dim + J) * dim + j) * n;
        },
        arrays.sum);
    }
  } // namespace

  namespace cell_matrix_kernels
  {
    // no templates: those have no clones
    EMMY_CLONES void
    add_in_plane(const CellArrays &arrays)
    {
      find_products<2>(arrays);
      add_products<2>(arrays);
    }
    EMMY_CLONES void
    add_in_space(const CellArrays &arrays)
    {
      find_products<3>(arrays);
      add_products<3>(arrays);
    }
  } // namespace cell_matrix_kernels

  template <int dim>
  void
  add_cell_products(const CellArrays &arrays)
  {
    if constexpr (dim == 2)
      cell_matrix_kernels::add_in_plane(arrays);
    else
      cell_matrix_kernels::add_in_space(arrays);
  }

  template <int dim>
  void
  CellMatrix<dim>::reinit(const unsigned int n_nodes)
  {
    this->n_nodes = n_nodes;
    n_padded      = padded<dim>(n_nodes);
    sum.resize_fast(dim * dim * n_padded * n_padded);
    is_empty = true;
    slopes.resize_fast(most_points_at_once * dim * n_padded);
    products.resize_fast(most_points_at_once * dim * dim * dim * n_padded);
  }

  template <int dim>
  void
  CellMatrix<dim>::add(const Points &points)
  {
    for (unsigned int begin = 0; begin < points.n_points;
         begin += most_points_at_once)
      {
        const unsigned int n =
          std::min(most_points_at_once, points.n_points - begin);
        for (unsigned int a = 0; a < n_nodes; ++a)
          for (unsigned int L = 0; L < dim; ++L)
            {
              const double *slope =
                points.stencils.gradient(points.group, a, L) + points.first +
                begin;
              for (unsigned int q = 0; q < n; ++q)
                slopes[(q * dim + L) * n_padded + a] = slope[q];
            }
        for (unsigned int row = 0; row < n * dim; ++row)
          for (unsigned int a = n_nodes; a < n_padded; ++a)
            slopes[row * n_padded + a] = 0.;
        add_cell_products<dim>(
          {n,
           n_nodes,
           n_padded,
           is_empty,
           slopes.data(),
           points.batch.tangent[points.in_batch + begin].begin_raw(),
           points.volumes + begin,
           products.data(),
           sum.data()});
        is_empty = false;
      }
  }

  template void
  add_cell_products<2>(const CellArrays &);
  template void
  add_cell_products<3>(const CellArrays &);
  template class CellMatrix<2>;
  template class CellMatrix<3>;
} // namespace emmy
