#include <emmy/effects/cell_matrix.h>
#include <emmy/effects/node_products.h>
#include <emmy/math/lane_points.h>

#include <algorithm>

// vectors stay within this file
#pragma GCC diagnostic ignored "-Wpsabi"

namespace emmy
{
  namespace
  {
    /** Points and nodes as plain arrays, as CellMatrix has them. */
    struct Arrays
    {
      const Reach  &reach;
      unsigned int  n_nodes;
      bool          is_first;
      const double *slopes, *tangents, *volumes;
      double       *products, *sum;
    };

    /** Of the four nodes from b on. */
    template <int dim>
    EMMY_INLINE void
    find_products(const Arrays &arrays, const unsigned int b)
    {
      const std::size_t n = padded<dim>(arrays.n_nodes);
      for (Bits bits{arrays.reach.points(b)}; bits; ++bits)
        {
          const unsigned int q = *bits;
          FourNodes          slope[dim];
          for (int L = 0; L < dim; ++L)
            slope[L] =
              arrays.volumes[q] * *reinterpret_cast<const FourNodes *>(
                                    arrays.slopes + (q * dim + L) * n + b);
          // of row iJ and column jL
          const double *tangent = arrays.tangents + q * dim * dim * dim * dim;
          auto *products = reinterpret_cast<FourNodes *>(arrays.products) +
                           q * dim * dim * dim;
          for (int iJj = 0; iJj < dim * dim * dim; ++iJj)
            {
              FourNodes product = tangent[dim * iJj] * slope[0];
              for (int L = 1; L < dim; ++L)
                product += tangent[dim * iJj + L] * slope[L];
              products[iJj] = product;
            }
        }
    }

    template <int dim>
    EMMY_INLINE void
    add_all(const Arrays &arrays)
    {
      const std::size_t n = padded<dim>(arrays.n_nodes);
      for (unsigned int b = 0; b < n; b += nodes_at_once)
        {
          find_products<dim>(arrays, b);
          add_products_of_nodes<dim, dim>(arrays.reach,
                                          arrays.n_nodes,
                                          b,
                                          arrays.is_first,
                                          {arrays.slopes, dim * n, 0, n, 0},
                                          {arrays.products,
                                           dim * dim * dim * nodes_at_once,
                                           dim * dim * nodes_at_once,
                                           dim * nodes_at_once,
                                           nodes_at_once},
                                          arrays.sum);
        }
    }
  } // namespace

  namespace cell_matrix_kernels
  {
    // no templates: those have no clones
    EMMY_CLONES void
    add_in_plane(const Arrays &arrays)
    {
      add_all<2>(arrays);
    }
    EMMY_CLONES void
    add_in_space(const Arrays &arrays)
    {
      add_all<3>(arrays);
    }
  } // namespace cell_matrix_kernels

  template <int dim>
  void
  CellMatrix<dim>::reinit(const unsigned int n_nodes)
  {
    this->n_nodes = n_nodes;
    n_padded      = padded<dim>(n_nodes);
    sum.resize_fast(dim * dim * n_padded * n_padded);
    is_empty = true;
    slopes.resize_fast(most_points_at_once * dim * n_padded);
    products.resize_fast(most_points_at_once * dim * dim * dim *
                         node_lanes<dim>);
  }

  template <int dim>
  void
  CellMatrix<dim>::add(const NeighbourPoints<dim> &here,
                       const StressBatch<dim>     &batch,
                       const double               *volumes)
  {
    reach.reinit(n_padded);
    const unsigned int n = here.points.size();
    std::fill_n(slopes.begin(), n * dim * n_padded, 0.);
    for (unsigned int k = 0; k < n;)
      {
        const auto &[group, q] = here.points[k];
        unsigned int n_points  = 1;
        while (k + n_points < n && here.points[k + n_points].group == group &&
               here.points[k + n_points].q == q + n_points)
          ++n_points;
        add_slopes(here, *group, q, k, n_points);
        k += n_points;
      }
    const Arrays arrays{reach,
                        n_nodes,
                        is_empty,
                        slopes.data(),
                        batch.tangent[here.at].begin_raw(),
                        volumes + here.at,
                        products.data(),
                        sum.data()};
    if constexpr (dim == 2)
      cell_matrix_kernels::add_in_plane(arrays);
    else
      cell_matrix_kernels::add_in_space(arrays);
    is_empty = false;
  }

  template <int dim>
  void
  CellMatrix<dim>::add_slopes(const NeighbourPoints<dim> &here,
                              const Group                &group,
                              const unsigned int          q,
                              const unsigned int          k,
                              const unsigned int          n_points)
  {
    const unsigned int *places = here.around.places(group);
    const auto          row = [&](const unsigned int i, const unsigned int L) {
      return &slopes[((k + i) * dim + L) * n_padded];
    };
    // four nodes of four points, where these nodes stand together
    const unsigned int n_whole = n_points / n_lanes * n_lanes;
    unsigned int       a       = 0;
    for (; n_whole > 0 && a + n_lanes <= group.n_nodes; a += n_lanes)
      {
        if (places[a + 1] != places[a] + 1 || places[a + 2] != places[a] + 2 ||
            places[a + 3] != places[a] + 3)
          break;
        for (unsigned int i = 0; i < n_whole; i += n_lanes)
          for (unsigned int L = 0; L < dim; ++L)
            {
              Lanes x[n_lanes];
              for (unsigned int r = 0; r < n_lanes; ++r)
                x[r] = read_together<Lanes>(
                  here.stencils.gradient(group, a + r, L) + q + i);
              transpose_lanes(x[0], x[1], x[2], x[3]);
              for (unsigned int r = 0; r < n_lanes; ++r)
                write_together(x[r], row(i + r, L) + places[a]);
            }
      }
    const unsigned int n_done = a; // of n_whole points
    for (unsigned int i = 0; i < n_points; ++i)
      for (a = i < n_whole ? n_done : 0; a < group.n_nodes; ++a)
        for (unsigned int L = 0; L < dim; ++L)
          row(i, L)[places[a]] = here.stencils.gradient(group, a, L)[q + i];
    for (a = 0; a < group.n_nodes; ++a)
      reach.add(k, n_points, places[a]);
  }

  template class CellMatrix<2>;
  template class CellMatrix<3>;
} // namespace emmy
