#include <emmy/base/unknown.h>
#include <emmy/math/lanes.h>
#include <emmy/system/block_adder.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace emmy
{
  namespace
  {
    /** Two numbers side by side, which every x86-64 can add at once. */
    typedef double TwoNumbers __attribute__((vector_size(16)));

    /** Add the numbers of a node to others. */
    template <int dim>
    EMMY_INLINE void
    add_node(const double *from, double *to)
    {
      TwoNumbers first, sum;
      std::memcpy(&first, from, sizeof first);
      std::memcpy(&sum, to, sizeof sum);
      sum += first;
      if constexpr (dim == 3)
        to[2] += from[2];
      std::memcpy(to, &sum, sizeof sum);
    }
  } // namespace

  template <int dim>
  void
  BlockAdder<dim>::add(const unsigned int    *nodes,
                       const ComponentBlocks &blocks,
                       Matrix                &matrix)
  {
    const unsigned int n = blocks.n_nodes;
    set_nodes(nodes, n);
    find_places(matrix);
    row.resize(dim * with_roots.size());
    share_of_row.resize(row.size());
    const auto size_of = [&](const unsigned int a, const unsigned int i) {
      return std::abs(blocks.at(i, i, a)[a * blocks.by_b]);
    };
    double mean = 0.;
    if (!bound.empty())
      for (unsigned int a = 0; a < n; ++a)
        for (unsigned int i = 0; i < dim; ++i)
          mean += size_of(a, i) / (dim * n);
    for (unsigned int a = 0; a < n; ++a)
      for (unsigned int i = 0; i < dim; ++i)
        {
          const unsigned int here = unknown<dim>(nodes[a], i);
          if (graph.is_free(here))
            {
              add_row(a, i, row_of(blocks, a, i), matrix);
              continue;
            }
          const double *of_follower = nullptr;
          for (const Share &share : shares)
            if (share.from == dim * a + i)
              {
                if (!of_follower)
                  of_follower = row_of(blocks, a, i);
                for (unsigned int k = 0; k < row.size(); ++k)
                  share_of_row[k] = share.weight * of_follower[k];
                add_row(share.to / dim, i, share_of_row.data(), matrix);
              }
          // an equation without couplings, of the size of the others
          const Place diagonal = places[a * with_roots.size() + a];
          if (diagonal != CliquePlaces<dim>::none)
            graph.entries_of(here, matrix)[dim * diagonal + i] +=
              size_of(a, i) != 0. ? size_of(a, i) : mean;
        }
  }

  template <int dim>
  void
  BlockAdder<dim>::add_components(const unsigned int               *nodes,
                                  const dealii::FullMatrix<double> &nodal,
                                  Matrix                           &matrix)
  {
    const unsigned int n = nodal.m();
    with_roots.assign(nodes, nodes + n);
    find_places(matrix);
    for (unsigned int a = 0; a < n; ++a)
      for (unsigned int c = 0; c < dim; ++c)
        {
          double *entries = graph.entries_of(unknown<dim>(nodes[a], c), matrix);
          for (unsigned int b = 0; b < n; ++b)
            if (places[a * n + b] != CliquePlaces<dim>::none)
              entries[dim * places[a * n + b] + c] += nodal(a, b);
        }
  }

  template <int dim>
  void
  BlockAdder<dim>::set_nodes(const unsigned int *nodes, const unsigned int n)
  {
    with_roots.assign(nodes, nodes + n);
    shares.clear();
    bound.clear();
    if (!std::all_of(nodes, nodes + n, [&](const unsigned int node) {
          return graph.has_no_condition(node);
        }))
      add_roots(n);
  }

  template <int dim>
  void
  BlockAdder<dim>::add_roots(const unsigned int n_nodes)
  {
    for (unsigned int a = 0; a < n_nodes; ++a)
      for (unsigned int c = 0; c < dim; ++c)
        {
          const unsigned int i = unknown<dim>(with_roots[a], c);
          if (graph.is_free(i))
            continue;
          bound.push_back(dim * a + c);
          graph.for_each_root(
            i, [&](const unsigned int root, const double weight) {
              const auto place =
                std::find(with_roots.begin(), with_roots.end(), root / dim);
              const unsigned int at = place - with_roots.begin();
              if (place == with_roots.end())
                with_roots.push_back(root / dim);
              shares.push_back({dim * a + c, dim * at + c, weight});
            });
        }
  }

  template <int dim>
  void
  BlockAdder<dim>::find_places(Matrix &matrix)
  {
    places = clique_places.find(with_roots);
    // entries come from memory meanwhile
    const Place *place = places;
    for (const unsigned int node : with_roots)
      {
        const double *rows[dim];
        for (unsigned int i = 0; i < dim; ++i)
          rows[i] = graph.entries_of(unknown<dim>(node, i), matrix);
        for (unsigned int b = 0; b < with_roots.size(); ++b, ++place)
          if (*place != CliquePlaces<dim>::none)
            for (const double *entries : rows)
              __builtin_prefetch(entries + dim * *place, 1);
      }
  }

  template <int dim>
  const double *
  BlockAdder<dim>::row_of(const ComponentBlocks &blocks,
                          const unsigned int     a,
                          const unsigned int     i)
  {
    const double *values = blocks.at(i, 0, a);
    if (bound.empty() && blocks.by_j == 1 && blocks.by_b == dim)
      return values;
    if (blocks.by_j == 1 && blocks.by_b == dim)
      std::copy_n(values, dim * blocks.n_nodes, row.begin());
    else
      for (unsigned int b = 0; b < blocks.n_nodes; ++b)
        for (unsigned int j = 0; j < dim; ++j)
          row[dim * b + j] = values[j * blocks.by_j + b * blocks.by_b];
    std::fill(row.begin() + dim * blocks.n_nodes, row.end(), 0.);
    for (const Share &share : shares)
      row[share.to] += share.weight * row[share.from];
    for (const unsigned int column : bound)
      row[column] = 0.;
    return row.data();
  }

  template <int dim>
  void
  BlockAdder<dim>::add_row(const unsigned int a,
                           const unsigned int i,
                           const double      *values,
                           Matrix            &matrix) const
  {
    const unsigned int n    = with_roots.size();
    const Place *const here = places + a * n;
    double *entries = graph.entries_of(unknown<dim>(with_roots[a], i), matrix);
    for (unsigned int b = 0; b < n; ++b)
      if (here[b] != CliquePlaces<dim>::none)
        add_node<dim>(values + dim * b, entries + dim * here[b]);
  }

  template class BlockAdder<2>;
  template class BlockAdder<3>;
} // namespace emmy
