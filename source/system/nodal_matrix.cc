#include <emmy/math/node_numbers.h>
#include <emmy/system/nodal_matrix.h>

#include <algorithm>
#include <cmath>
#include <cstring>

// vectors stay within this file
#pragma GCC diagnostic ignored "-Wpsabi"

namespace emmy
{
  namespace
  {
    /** What kernels work on; the rows of a graph. */
    template <int dim>
    struct Rows
    {
      const NodeGraph<dim> &graph;
      const double         *values;
      unsigned int          n_nodes;
    };

    template <int dim>
    EMMY_INLINE typename NodeNumbers<dim>::type
    read(const double *x, const unsigned int node)
    {
      return read_node<dim>(x + std::size_t(NodalMatrix<dim>::stride) * node);
    }

    template <int dim>
    EMMY_INLINE void
    write(const typename NodeNumbers<dim>::type &value,
          double                                *x,
          const unsigned int                     node)
    {
      std::memcpy(x + std::size_t(NodalMatrix<dim>::stride) * node,
                  &value,
                  sizeof value);
    }

    template <int dim>
    EMMY_INLINE void
    multiply_rows(const Rows<dim> &rows, const double *x, double *result)
    {
      for (unsigned int node = 0; node < rows.n_nodes; ++node)
        {
          const auto                      row    = rows.graph.row(node);
          const double                   *values = rows.values + row.first;
          typename NodeNumbers<dim>::type even{}, odd{};
          unsigned int                    k = 0;
          for (; k + 1 < row.n; k += 2) // two sums, as one waits
            {
              even += values[k] * read<dim>(x, row.nodes[k]);
              odd += values[k + 1] * read<dim>(x, row.nodes[k + 1]);
            }
          if (k < row.n)
            even += values[k] * read<dim>(x, row.nodes[k]);
          write<dim>(even + odd, result, node);
        }
    }

    /** Note where the nodes of a row stand. */
    template <class Row>
    void
    mark(const Row &row, std::vector<std::size_t> &place_of_node)
    {
      for (unsigned int k = 0; k < row.n; ++k)
        place_of_node[row.nodes[k]] = row.first + k;
    }

    template <int dim>
    EMMY_INLINE void
    sweep_rows(const Rows<dim> &rows,
               const double    *inverse,
               const double    *r,
               double          *z)
    {
      for (unsigned int node = 0; node < rows.n_nodes; ++node)
        {
          const auto                      row    = rows.graph.row(node);
          const double                   *values = rows.values + row.first;
          typename NodeNumbers<dim>::type sum    = read<dim>(r, node);
          for (unsigned int k = 0; k < row.n && row.nodes[k] < node; ++k)
            sum -= values[k] * read<dim>(z, row.nodes[k]);
          write<dim>(sum * read<dim>(inverse, node), z, node);
        }
      for (unsigned int node = rows.n_nodes; node-- > 0;)
        {
          const auto                      row    = rows.graph.row(node);
          const double                   *values = rows.values + row.first;
          typename NodeNumbers<dim>::type sum{};
          for (unsigned int k = row.n; k-- > 0 && row.nodes[k] > node;)
            if (row.nodes[k] < rows.n_nodes)
              sum += values[k] * read<dim>(z, row.nodes[k]);
          write<dim>(read<dim>(z, node) - sum * read<dim>(inverse, node),
                     z,
                     node);
        }
    }
  } // namespace

  namespace nodal_kernels
  {
    // no templates: those have no clones
    EMMY_CLONES void
    multiply(const Rows<2> &rows, const double *x, double *result)
    {
      multiply_rows(rows, x, result);
    }
    EMMY_CLONES void
    multiply(const Rows<3> &rows, const double *x, double *result)
    {
      multiply_rows(rows, x, result);
    }
    EMMY_CLONES void
    sweep(const Rows<2> &rows,
          const double  *inverse,
          const double  *r,
          double        *z)
    {
      sweep_rows(rows, inverse, r, z);
    }
    EMMY_CLONES void
    sweep(const Rows<3> &rows,
          const double  *inverse,
          const double  *r,
          double        *z)
    {
      sweep_rows(rows, inverse, r, z);
    }
  } // namespace nodal_kernels

  template <int dim>
  void
  NodalMatrix<dim>::reinit(const std::shared_ptr<const ActiveGrid<dim>> &active)
  {
    const NodeGraph<dim> &graph = active->graph();
    if (this->active != active)
      {
        diagonals.resize(graph.n_nodes());
        for (unsigned int node = 0; node < graph.n_nodes(); ++node)
          {
            const auto row = graph.row(node);
            diagonals[node] =
              row.first +
              (std::lower_bound(row.nodes, row.nodes + row.n, node) -
               row.nodes);
          }
        place_of_node.resize(graph.n_nodes());
      }
    this->active = active;
    values.assign(graph.n_pairs(), 0.);
    marked_by.assign(graph.n_nodes(), dealii::numbers::invalid_unsigned_int);
  }

  template <int dim>
  void
  NodalMatrix<dim>::add(const unsigned int               *nodes,
                        const dealii::FullMatrix<double> &block)
  {
    const unsigned int n = block.m();
    for (unsigned int a = 0; a < n; ++a)
      {
        const auto row = active->graph().row(nodes[a]);
        for (unsigned int k = 0; k < row.n; ++k)
          {
            place_of_node[row.nodes[k]] = row.first + k;
            marked_by[row.nodes[k]]     = nodes[a];
          }
        // nodes that do not meet have nothing in common
        for (unsigned int b = 0; b < n; ++b)
          if (marked_by[nodes[b]] == nodes[a])
            values[place_of_node[nodes[b]]] += block(a, b);
      }
  }

  template <int dim>
  void
  NodalMatrix<dim>::add_times(const std::vector<double> &v,
                              std::vector<double>       &result) const
  {
    const NodeGraph<dim> &graph = active->graph();
    for (unsigned int node = 0; node < graph.n_nodes(); ++node)
      {
        const auto    row      = graph.row(node);
        const double *entry    = values.data() + row.first;
        double        sum[dim] = {};
        for (unsigned int k = 0; k < row.n; ++k)
          for (unsigned int c = 0; c < dim; ++c)
            sum[c] += entry[k] * v[dim * row.nodes[k] + c];
        for (unsigned int c = 0; c < dim; ++c)
          result[dim * node + c] += sum[c];
      }
  }

  template <int dim>
  void
  NodalMatrix<dim>::multiply(const std::vector<double> &x,
                             std::vector<double>       &result) const
  {
    const NodeGraph<dim> &graph = active->graph();
    nodal_kernels::multiply(Rows<dim>{graph, values.data(), graph.n_nodes()},
                            x.data(),
                            result.data());
  }

  template <int dim>
  void
  NodalMatrix<dim>::sweep(const std::vector<double> &inverse,
                          const std::vector<double> &r,
                          std::vector<double>       &result) const
  {
    // what is not owned stays out
    std::fill(result.begin() + stride * active->n_owned_nodes(),
              result.end(),
              0.);
    nodal_kernels::sweep(Rows<dim>{active->graph(),
                                   values.data(),
                                   active->n_owned_nodes()},
                         inverse.data(),
                         r.data(),
                         result.data());
  }

  template <int dim>
  void
  NodalMatrix<dim>::vmult(Vector &result, const Vector &v) const
  {
    const std::vector<double> local = active->to_local(v);
    std::vector<double>       product(local.size());
    add_times(local, product);
    result = 0.;
    active->add(product, result);
  }

  template <int dim>
  double
  NodalMatrix<dim>::residual(Vector &r, const Vector &v, const Vector &b) const
  {
    Vector product = active->make_vector();
    vmult(product, v);
    r = b;
    r -= product;
    return r.l2_norm();
  }

  template <int dim>
  double
  NodalMatrix<dim>::matrix_norm_square(const Vector &v) const
  {
    Vector product = active->make_vector();
    vmult(product, v);
    return product * v;
  }

  template <int dim>
  void
  NodalMatrix<dim>::add_to(Matrix                    &matrix,
                           const double               factor,
                           const Conditions           conditions,
                           const std::vector<double> &damping) const
  {
    const NodeGraph<dim> &graph = active->graph();
    RowValues             row_values;
    for (unsigned int node = 0; node < graph.n_nodes(); ++node)
      {
        const auto row = graph.row(node);
        row_values.assign(values.begin() + row.first,
                          values.begin() + row.first + row.n);
        if (!damping.empty() && row.n > 0)
          row_values[diagonals[node] - row.first] += damping[node];
        for (double &value : row_values)
          value *= factor;
        add_row(matrix, node, row_values, conditions);
      }
  }

  template <int dim>
  void
  NodalMatrix<dim>::add_row(Matrix            &matrix,
                            const unsigned int node,
                            const RowValues   &row_values,
                            const Conditions   conditions) const
  {
    const NodeGraph<dim> &graph = active->graph();
    const auto            row   = graph.row(node);
    if (conditions == Conditions::worked_in &&
        !std::all_of(row.nodes,
                     row.nodes + row.n,
                     [&](const unsigned int other) {
                       return graph.has_no_condition(other);
                     }))
      {
        mark(row, place_of_node);
        for (unsigned int c = 0; c < dim; ++c)
          add_row_with_conditions(matrix, node, row_values, c);
        return;
      }
    for (unsigned int c = 0; c < dim; ++c)
      {
        double *entries = graph.entries_of(unknown<dim>(node, c), matrix);
        for (unsigned int k = 0; k < row.n; ++k)
          entries[graph.place(row.first + k, c)] += row_values[k];
      }
  }

  template <int dim>
  void
  NodalMatrix<dim>::add_row_with_conditions(Matrix            &matrix,
                                            const unsigned int node,
                                            const RowValues   &row_values,
                                            const unsigned int component) const
  {
    const NodeGraph<dim> &graph = active->graph();
    const auto            row   = graph.row(node);
    const unsigned int    i     = unknown<dim>(node, component);
    // C^T A C: followers hand over to their roots; the node's own row is marked
    graph.for_each_root(i, [&](const unsigned int root_i, const double w) {
      const bool is_own = root_i == i;
      if (!is_own)
        mark(graph.row(root_i / dim), place_of_node);
      double *entries = graph.entries_of(root_i, matrix);
      for (unsigned int k = 0; k < row.n; ++k)
        {
          const unsigned int j = unknown<dim>(row.nodes[k], component);
          if (is_own && graph.is_free(j))
            entries[graph.place(row.first + k, component)] += row_values[k];
          else if (row_values[k] != 0.)
            graph.for_each_root(j,
                                [&](const unsigned int root_j, const double v) {
                                  const std::size_t pair =
                                    place_of_node[root_j / dim];
                                  entries[graph.place(pair, component)] +=
                                    w * v * row_values[k];
                                });
        }
      if (!is_own)
        mark(row, place_of_node);
    });
    // an equation without couplings, of the size of the others
    if (!graph.is_free(i))
      graph.entries_of(i, matrix)[graph.place(diagonals[node], component)] +=
        std::abs(row_values[diagonals[node] - row.first]);
  }

  template class NodalMatrix<2>;
  template class NodalMatrix<3>;
} // namespace emmy
