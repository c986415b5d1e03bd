#include <emmy/system/block_sum.h>

#include <algorithm>

namespace emmy
{
  template <int dim>
  void
  ComponentBlocks::copy_to(dealii::FullMatrix<double> &matrix) const
  {
    matrix.reinit(dim * n_nodes, dim * n_nodes, true);
    for (unsigned int i = 0; i < dim; ++i)
      for (unsigned int j = 0; j < dim; ++j)
        for (unsigned int a = 0; a < n_nodes; ++a)
          {
            const double *of_node = values + i * by_i + j * by_j + a * by_a;
            double       *row     = &matrix(dim * a + i, 0);
            for (unsigned int b = 0; b < n_nodes; ++b)
              row[dim * b + j] = of_node[b];
          }
  }

  template <int dim>
  BlockSum<dim>::BlockSum(const NodeGraph<dim> &graph, Matrix &matrix)
    : graph(graph)
    , matrix(matrix)
    , index_of(graph.n_nodes(), dealii::numbers::invalid_unsigned_int)
  {}

  template <int dim>
  void
  BlockSum<dim>::add(const unsigned int *nodes, const ComponentBlocks &blocks)
  {
    const unsigned int n     = blocks.n_nodes;
    unsigned int       n_new = 0;
    for (unsigned int a = 0; a < n; ++a)
      if (index_of[nodes[a]] == dealii::numbers::invalid_unsigned_int)
        ++n_new;
    if (members.size() + n_new > room)
      flush();
    if (members.empty())
      {
        room = std::max(most_nodes, n);
        sum.assign(dim * dim * room * room, 0.);
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
    for (unsigned int i = 0; i < dim; ++i)
      for (unsigned int j = 0; j < dim; ++j)
        for (unsigned int a = 0; a < n; ++a)
          {
            double *row = &sum[((i * dim + j) * room + indices[a]) * room];
            const double *values = blocks.values + i * blocks.by_i +
                                   j * blocks.by_j + a * blocks.by_a;
            for (unsigned int b = 0; b < n; ++b)
              row[indices[b]] += values[b];
          }
  }

  template <int dim>
  void
  BlockSum<dim>::flush()
  {
    if (members.empty())
      return;
    graph.add(members.data(),
              ComponentBlocks{sum.data(),
                              static_cast<unsigned int>(members.size()),
                              dim * room * room,
                              room * room,
                              room},
              matrix);
    for (const unsigned int node : members)
      index_of[node] = dealii::numbers::invalid_unsigned_int;
    members.clear();
  }

  template void
  ComponentBlocks::copy_to<2>(dealii::FullMatrix<double> &) const;
  template void
  ComponentBlocks::copy_to<3>(dealii::FullMatrix<double> &) const;
  template class BlockSum<2>;
  template class BlockSum<3>;
} // namespace emmy
