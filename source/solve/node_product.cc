#include <emmy/math/node_numbers.h>
#include <emmy/solve/met_nodes.h>
#include <emmy/solve/node_product.h>

#include <Epetra_CrsMatrix.h>

#include <algorithm>

// vectors stay within this file
#pragma GCC diagnostic ignored "-Wpsabi"

namespace emmy
{
  namespace
  {
    using dealii::types::global_dof_index;

    /** What kernels work on. */
    template <int dim>
    struct Product
    {
      unsigned int         n_nodes;
      const std::size_t   *first;
      const unsigned int  *nodes;
      const double *const *rows;
      const double        *x;
      double              *y;
    };

    /**
     * The rows of a node at once, where they are near, as in the plane: fewer
     * instructions than one after the other.
     */
    template <int dim>
    EMMY_INLINE void
    multiply_nodes(const Product<dim> &at)
    {
      using Numbers = typename NodeNumbers<dim>::type;
      for (unsigned int node = 0; node < at.n_nodes; ++node)
        {
          const unsigned int *const neighbours = at.nodes + at.first[node];
          const std::size_t         n    = at.first[node + 1] - at.first[node];
          const double *const      *rows = at.rows + dim * node;
          Numbers                   sums[dim]{};
          for (std::size_t k = 0; k + 1 < n; ++k)
            {
              const Numbers x = read_node<dim>(at.x + dim * neighbours[k]);
              for (unsigned int c = 0; c < dim; ++c)
                sums[c] += read_node<dim>(rows[c] + dim * k) * x;
            }
          for (unsigned int c = 0; c < dim; ++c)
            {
              double sum = 0.;
              for (unsigned int d = 0; d < dim; ++d)
                sum += sums[c][d];
              // behind the last block there may be nothing to read
              for (unsigned int d = 0; n > 0 && d < dim; ++d)
                sum += rows[c][dim * (n - 1) + d] *
                       at.x[dim * neighbours[n - 1] + d];
              at.y[dim * node + c] = sum;
            }
        }
    }

    /**
     * One row after the other, as they lie in memory: processors foresee one
     * stream of numbers, and three that are 600 bytes apart come at half its
     * speed.
     */
    template <int dim>
    EMMY_INLINE void
    multiply_rows(const Product<dim> &at)
    {
      using Numbers                = typename NodeNumbers<dim>::type;
      constexpr unsigned int ahead = 1024 / sizeof(double);
      constexpr std::size_t  pair  = 2;
      for (unsigned int node = 0; node < at.n_nodes; ++node)
        {
          const unsigned int *const nodes = at.nodes + at.first[node];
          const std::size_t         n     = at.first[node + 1] - at.first[node];
          for (unsigned int c = 0; c < dim; ++c)
            {
              const double *const row = at.rows[dim * node + c];
              Numbers             sums[2]{};
              std::size_t         k = 0;
              // behind the last block there may be nothing to read
              for (; k + pair < n; k += pair)
                {
                  __builtin_prefetch(row + dim * k + ahead);
                  sums[0] += read_node<dim>(row + dim * k) *
                             read_node<dim>(at.x + dim * nodes[k]);
                  sums[1] += read_node<dim>(row + dim * (k + 1)) *
                             read_node<dim>(at.x + dim * nodes[k + 1]);
                }
              double sum = 0.;
              for (unsigned int d = 0; d < dim; ++d)
                sum += sums[0][d] + sums[1][d];
              for (; k < n; ++k)
                for (unsigned int d = 0; d < dim; ++d)
                  sum += row[dim * k + d] * at.x[dim * nodes[k] + d];
              at.y[dim * node + c] = sum;
            }
        }
    }
  } // namespace

  namespace product_kernels
  {
    // no templates: those have no clones
    EMMY_CLONES void
    multiply(const Product<2> &at)
    {
      multiply_nodes<2>(at);
    }
    EMMY_CLONES void
    multiply(const Product<3> &at)
    {
      multiply_rows<3>(at);
    }
  } // namespace product_kernels

  NodeProduct::NodeProduct(const unsigned int n_components)
    : n(n_components)
  {}

  NodeProduct::~NodeProduct() = default;

  void
  NodeProduct::set(const Matrix &new_matrix)
  {
    matrix                          = &new_matrix;
    const Epetra_CrsMatrix &entries = matrix->trilinos_matrix();
    if (!graph || graph->DataPtr() != entries.Graph().DataPtr())
      {
        // a copy shares what it has: no other pattern can have its place
        graph = std::make_unique<const Epetra_CrsGraph>(entries.Graph());
        has_blocks =
          dealii::Utilities::MPI::min(find_blocks() ? 1 : 0,
                                      matrix->get_mpi_communicator()) == 1;
        exchange = NodeExchange();
        if (has_blocks)
          {
            const auto others = met_on_others(*graph, n);
            values.assign(n * (n_owned + others.size()) + 1, 0.);
            exchange = exchange_with_others(*matrix, n, others);
          }
      }
    rows.resize(entries.NumMyRows());
    for (int row = 0; row < entries.NumMyRows(); ++row)
      rows[row] = entries[row];
  }

  std::vector<unsigned int>
  NodeProduct::nodes_of_columns() const
  {
    const std::vector<global_dof_index> others  = met_on_others(*graph, n);
    const Epetra_BlockMap              &columns = graph->ColMap();
    std::vector<unsigned int>           result(columns.NumMyElements());
    for (unsigned int j = 0; j < result.size(); ++j)
      {
        const int own = graph->RowMap().LID(columns.GID(j));
        result[j]     = own >= 0 ? own / n
                                 : n_owned + (std::lower_bound(others.begin(),
                                                           others.end(),
                                                           columns.GID(j) / n) -
                                          others.begin());
      }
    return result;
  }

  bool
  NodeProduct::find_blocks()
  {
    first.assign(1, 0);
    nodes.clear();
    const int n_rows = graph->NumMyRows();
    n_owned          = n_rows / n;
    if ((n != 2 && n != 3) || n_rows % n != 0 || !graph->RowMap().LinearMap())
      return false;
    const std::vector<unsigned int> node_of = nodes_of_columns();
    const int *const unknown_of = graph->ColMap().MyGlobalElements();
    for (unsigned int node = 0; node < n_owned; ++node)
      {
        int length, *columns;
        graph->ExtractMyRowView(n * node, length, columns);
        if (length % n != 0)
          return false;
        for (unsigned int c = 1; c < n; ++c)
          {
            int length_of_other, *columns_of_other;
            graph->ExtractMyRowView(n * node + c,
                                    length_of_other,
                                    columns_of_other);
            if (length_of_other != length ||
                !std::equal(columns, columns + length, columns_of_other))
              return false;
          }
        for (const int *column = columns; column < columns + length;
             column += n)
          {
            if (unknown_of[*column] % n != 0)
              return false;
            for (unsigned int c = 1; c < n; ++c)
              if (unknown_of[column[c]] != unknown_of[*column] + int(c))
                return false;
            nodes.push_back(node_of[*column]);
          }
        first.push_back(nodes.size());
      }
    return true;
  }

  void
  NodeProduct::vmult(Vector &y, const Vector &x) const
  {
    if (!has_blocks)
      return matrix->vmult(y, x);
    std::copy(x.begin(), x.end(), values.begin());
    exchange.update(values.data(), n, values.data() + n * n_owned);
    const auto multiply = [&](auto product) {
      product = {n_owned,
                 first.data(),
                 nodes.data(),
                 rows.data(),
                 values.data(),
                 y.begin()};
      product_kernels::multiply(product);
    };
    if (n == 2)
      multiply(Product<2>());
    else
      multiply(Product<3>());
  }

  double
  NodeProduct::residual(Vector &r, const Vector &x, const Vector &b) const
  {
    vmult(r, x);
    auto in = b.begin();
    for (double &entry : r)
      entry = *in++ - entry;
    return r.l2_norm();
  }
} // namespace emmy
