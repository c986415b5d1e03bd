#include <emmy/effects/cell_matrix.h>
#include <emmy/math/lanes.h>

#include <algorithm>

// vectors stay within this file
#pragma GCC diagnostic ignored "-Wpsabi"

namespace emmy
{
  namespace
  {
    /** As many points as have their products in the first-level cache. */
    constexpr unsigned int most_points = 8;

    template <int dim>
    constexpr unsigned int width = (dim == 2) ? 4 : 8;

    /** Points and nodes as plain arrays, as CellMatrix has them. */
    struct Arrays
    {
      unsigned int  n_points, n_padded;
      const double *slopes, *tangents, *volumes;
      double       *products, *sum;
    };

    template <int dim>
    EMMY_INLINE void
    find_products(const Arrays &arrays)
    {
      using Nodes          = typename LanesOf<width<dim>>::type;
      const unsigned int n = arrays.n_padded / width<dim>;
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

    /** Some nodes a at a time: their sums stay in registers. */
    template <int dim>
    EMMY_INLINE void
    add_products(const Arrays &arrays)
    {
      using Nodes                    = typename LanesOf<width<dim>>::type;
      constexpr unsigned int at_once = 4;
      const unsigned int     n       = arrays.n_padded / width<dim>;
      const auto *products = reinterpret_cast<const Nodes *>(arrays.products);
      auto       *sum      = reinterpret_cast<Nodes *>(arrays.sum);
      for (int i = 0; i < dim; ++i)
        for (int j = 0; j < dim; ++j)
          for (unsigned int b = 0; b < n; ++b)
            for (unsigned int a = 0; a < arrays.n_padded; a += at_once)
              {
                Nodes *target =
                  sum + ((i * dim + j) * arrays.n_padded + a) * n + b;
                Nodes of_node[at_once];
                for (unsigned int r = 0; r < at_once; ++r)
                  of_node[r] = target[r * n];
                for (unsigned int q = 0; q < arrays.n_points; ++q)
                  for (int J = 0; J < dim; ++J)
                    {
                      const Nodes product =
                        products[((q * dim * dim + i * dim + J) * dim + j) * n +
                                 b];
                      const double *slope =
                        arrays.slopes + (q * dim + J) * arrays.n_padded + a;
                      for (unsigned int r = 0; r < at_once; ++r)
                        of_node[r] += slope[r] * product;
                    }
                for (unsigned int r = 0; r < at_once; ++r)
                  target[r * n] = of_node[r];
              }
    }
  } // namespace

  namespace cell_matrix_kernels
  {
    // no templates: those have no clones
    EMMY_CLONES void
    add_in_plane(const Arrays &arrays)
    {
      find_products<2>(arrays);
      add_products<2>(arrays);
    }
    EMMY_CLONES void
    add_in_space(const Arrays &arrays)
    {
      find_products<3>(arrays);
      add_products<3>(arrays);
    }
  } // namespace cell_matrix_kernels

  template <int dim>
  void
  CellMatrix<dim>::reinit(const unsigned int n_nodes)
  {
    this->n_nodes = n_nodes;
    n_padded      = (n_nodes + width<dim> - 1) / width<dim> * width<dim>;
    sum.resize_fast(dim * dim * n_padded * n_padded);
    std::fill(sum.begin(), sum.end(), 0.);
    slopes.resize_fast(most_points * dim * n_padded);
    std::fill(slopes.begin(), slopes.end(), 0.);
    products.resize_fast(most_points * dim * dim * dim * n_padded);
  }

  template <int dim>
  void
  CellMatrix<dim>::add(const Points &points)
  {
    for (unsigned int begin = 0; begin < points.batch.n_points;
         begin += most_points)
      {
        const unsigned int n =
          std::min(most_points, points.batch.n_points - begin);
        for (unsigned int a = 0; a < n_nodes; ++a)
          for (unsigned int L = 0; L < dim; ++L)
            {
              const double *slope =
                points.stencils.gradient(points.group, a, L) + points.first +
                begin;
              for (unsigned int q = 0; q < n; ++q)
                slopes[(q * dim + L) * n_padded + a] = slope[q];
            }
        const Arrays arrays{n,
                            n_padded,
                            slopes.data(),
                            points.batch.tangent[begin].begin_raw(),
                            points.volumes + begin,
                            products.data(),
                            sum.data()};
        if constexpr (dim == 2)
          cell_matrix_kernels::add_in_plane(arrays);
        else
          cell_matrix_kernels::add_in_space(arrays);
      }
  }

  template class CellMatrix<2>;
  template class CellMatrix<3>;
} // namespace emmy
