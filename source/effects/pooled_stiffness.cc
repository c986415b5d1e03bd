#include <emmy/effects/node_lanes.h>
#include <emmy/effects/pooled_stiffness.h>

#include <algorithm>

namespace emmy
{
  template <int dim>
  PooledStiffness<dim>::PooledStiffness(const NodeGraph<dim> &graph,
                                        Matrix               &matrix)
    : graph(graph)
    , matrix(matrix)
    , index_of(graph.n_nodes(), dealii::numbers::invalid_unsigned_int)
    , tangents(most_points_at_once * dim * dim * dim * dim)
    , volumes(most_points_at_once)
  {}

  template <int dim>
  void
  PooledStiffness<dim>::take_in(const unsigned int *nodes, const unsigned int n)
  {
    unsigned int n_new = 0;
    for (unsigned int a = 0; a < n; ++a)
      if (index_of[nodes[a]] == dealii::numbers::invalid_unsigned_int)
        ++n_new;
    if (members.size() + n_new > room)
      flush();
    if (members.empty())
      {
        room     = std::max(most_nodes, n);
        n_padded = padded<dim>(room);
        // rows of nodes are read four at a time
        sum.resize_fast(dim * dim * n_padded * n_padded);
        slopes.resize_fast(most_points_at_once * dim * n_padded);
        products.resize_fast(most_points_at_once * dim * dim * dim * n_padded);
        is_empty = true;
      }
    indices.resize(n);
    for (unsigned int a = 0; a < n; ++a)
      {
        unsigned int &index = index_of[nodes[a]];
        if (index == dealii::numbers::invalid_unsigned_int)
          {
            index = members.size();
            members.push_back(nodes[a]);
          }
        indices[a] = index;
      }
  }

  template <int dim>
  void
  PooledStiffness<dim>::add(const unsigned int                     *nodes,
                            const typename CellMatrix<dim>::Points &points)
  {
    constexpr unsigned int n_tangent = dim * dim * dim * dim;
    const unsigned int     n         = points.group.n_nodes;
    take_in(nodes, n);
    for (unsigned int q = 0; q < points.n_points; ++q)
      {
        if (n_waiting == most_points_at_once)
          work_off(room); // more nodes may come
        double *rows = &slopes[n_waiting * dim * n_padded];
        std::fill_n(rows, dim * n_padded, 0.);
        for (unsigned int a = 0; a < n; ++a)
          for (unsigned int L = 0; L < dim; ++L)
            rows[L * n_padded + indices[a]] =
              points.stencils.gradient(points.group, a, L)[points.first + q];
        std::copy_n(points.batch.tangent[points.in_batch + q].begin_raw(),
                    n_tangent,
                    &tangents[n_waiting * n_tangent]);
        volumes[n_waiting++] = points.volumes[q];
      }
  }

  template <int dim>
  void
  PooledStiffness<dim>::work_off(const unsigned int n_nodes)
  {
    add_cell_products<dim>({n_waiting,
                            n_nodes,
                            n_padded,
                            is_empty,
                            slopes.data(),
                            tangents.data(),
                            volumes.data(),
                            products.data(),
                            sum.data()});
    is_empty  = false;
    n_waiting = 0;
  }

  template <int dim>
  void
  PooledStiffness<dim>::flush()
  {
    if (members.empty())
      return;
    const unsigned int n = members.size();
    work_off(n);
    graph.add(members.data(),
              ComponentBlocks{sum.data(),
                              n,
                              dim * n_padded * n_padded,
                              n_padded * n_padded,
                              n_padded},
              matrix);
    for (const unsigned int node : members)
      index_of[node] = dealii::numbers::invalid_unsigned_int;
    members.clear();
  }

  template class PooledStiffness<2>;
  template class PooledStiffness<3>;
} // namespace emmy
