#include <emmy/solve/block_ilu.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_Map.h>

#include <algorithm>
#include <cmath>

namespace emmy
{
  namespace
  {
    constexpr unsigned int none = dealii::numbers::invalid_unsigned_int;

    /** C -= A B. */
    template <int n>
    void
    subtract_product(const std::array<float, n * n> &A,
                     const std::array<float, n * n> &B,
                     std::array<float, n * n>       &C)
    {
      for (int j = 0; j < n; ++j)
        for (int k = 0; k < n; ++k)
          for (int i = 0; i < n; ++i)
            C[n * j + i] -= A[n * k + i] * B[n * j + k];
    }

    /** y -= A x. */
    template <int n>
    void
    subtract_product(const std::array<float, n * n> &A,
                     const float                    *x,
                     float                          *y)
    {
      for (int k = 0; k < n; ++k)
        for (int i = 0; i < n; ++i)
          y[i] -= A[n * k + i] * x[k];
    }

    /**
     * The inverse of a block whose entries are of the size of one, by
     * elimination with pivots; a pivot that vanishes is held off zero.
     */
    template <int n>
    std::array<float, n * n>
    inverse(const std::array<float, n * n> &block)
    {
      constexpr double smallest_pivot = 1e-6;

      std::array<std::array<double, 2 * n>, n> rows{};
      for (int i = 0; i < n; ++i)
        {
          for (int j = 0; j < n; ++j)
            rows[i][j] = block[n * j + i];
          rows[i][n + i] = 1.;
        }
      for (int k = 0; k < n; ++k)
        {
          int best = k;
          for (int i = k + 1; i < n; ++i)
            if (std::abs(rows[i][k]) > std::abs(rows[best][k]))
              best = i;
          std::swap(rows[k], rows[best]);
          double pivot = rows[k][k];
          if (!(std::abs(pivot) > smallest_pivot))
            pivot = std::copysign(smallest_pivot, pivot);
          for (double &entry : rows[k])
            entry /= pivot;
          for (int i = 0; i < n; ++i)
            if (i != k)
              {
                const double factor = rows[i][k];
                for (int j = k; j < 2 * n; ++j)
                  rows[i][j] -= factor * rows[k][j];
              }
        }
      std::array<float, n * n> result;
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
          result[n * j + i] = static_cast<float>(rows[i][n + j]);
      return result;
    }
  } // namespace

  template <int n>
  void
  BlockIlu<n>::make(const Matrix &matrix)
  {
    AssertThrow(matrix.local_size() % n == 0,
                dealii::ExcMessage("A rank has a part of a node."));
    copy(matrix);
    factorise();
  }

  template <int n>
  void
  BlockIlu<n>::copy(const Matrix &matrix)
  {
    const Epetra_CrsMatrix &entries = matrix.trilinos_matrix();
    const Epetra_Map       &ours    = entries.RowMap();
    const Epetra_Map       &others  = entries.ColMap();
    const unsigned int      n_nodes = entries.NumMyRows() / n;

    std::vector<unsigned int> unknown(others.NumMyElements());
    for (unsigned int j = 0; j < unknown.size(); ++j)
      unknown[j] = ours.LID(others.GID(j)); // -1 becomes none

    first.assign(1, 0);
    columns.clear();
    blocks.clear();
    diagonal.resize(n_nodes);
    scale.assign(n * n_nodes, 1.);
    std::vector<unsigned int> place(n_nodes, none);
    int                       length, *row;
    double                   *values;
    for (unsigned int node = 0; node < n_nodes; ++node)
      {
        for (int i = 0; i < n; ++i)
          {
            entries.ExtractMyRowView(n * node + i, length, values, row);
            for (int k = 0; k < length; ++k)
              {
                const unsigned int j = unknown[row[k]];
                if (j == none)
                  continue;
                if (place[j / n] == none)
                  {
                    place[j / n] = 0;
                    columns.push_back(j / n);
                  }
                if (j == n * node + i && values[k] != 0.)
                  scale[j] = 1. / std::sqrt(std::abs(values[k]));
              }
          }
        if (place[node] == none)
          columns.push_back(node);
        std::sort(columns.begin() + first.back(), columns.end());
        for (unsigned int k = first.back(); k < columns.size(); ++k)
          {
            place[columns[k]] = none;
            if (columns[k] == node)
              diagonal[node] = k;
          }
        first.push_back(columns.size());
      }

    blocks.assign(columns.size(), Block{});
    for (unsigned int node = 0; node < n_nodes; ++node)
      {
        for (unsigned int k = first[node]; k < first[node + 1]; ++k)
          place[columns[k]] = k;
        for (int i = 0; i < n; ++i)
          {
            entries.ExtractMyRowView(n * node + i, length, values, row);
            for (int k = 0; k < length; ++k)
              {
                const unsigned int j = unknown[row[k]];
                if (j != none)
                  blocks[place[j / n]][n * (j % n) + i] = static_cast<float>(
                    values[k] * scale[n * node + i] * scale[j]);
              }
          }
      }
  }

  template <int n>
  void
  BlockIlu<n>::factorise()
  {
    const unsigned int        n_nodes = diagonal.size();
    std::vector<unsigned int> place(n_nodes, none);
    for (unsigned int i = 0; i < n_nodes; ++i)
      {
        for (unsigned int k = first[i]; k < first[i + 1]; ++k)
          place[columns[k]] = k;
        for (unsigned int k = first[i]; k < diagonal[i]; ++k)
          {
            // L_ij = A_ij / U_jj, and its products with the row j of U
            const unsigned int j = columns[k];
            Block              product{};
            subtract_product<n>(blocks[k], blocks[diagonal[j]], product);
            blocks[k] = product; // -L_ij
            for (unsigned int l = diagonal[j] + 1; l < first[j + 1]; ++l)
              if (place[columns[l]] != none)
                {
                  Block &target = blocks[place[columns[l]]];
                  for (int c = 0; c < n; ++c)
                    for (int m = 0; m < n; ++m)
                      for (int r = 0; r < n; ++r)
                        target[n * c + r] +=
                          product[n * m + r] * blocks[l][n * c + m];
                }
          }
        blocks[diagonal[i]] = inverse<n>(blocks[diagonal[i]]);
        for (unsigned int k = first[i]; k < first[i + 1]; ++k)
          place[columns[k]] = none;
      }
    work.resize(n * n_nodes);
  }

  template <int n>
  double
  BlockIlu<n>::substitute(const Vector &r) const
  {
    const unsigned int n_nodes = diagonal.size();
    const double      *in      = r.begin();
    // single precision has no room for very large and very small numbers
    double largest = 0.;
    for (unsigned int i = 0; i < n * n_nodes; ++i)
      largest = std::max(largest, std::abs(in[i] * scale[i]));
    const double size = largest > 0. ? largest : 1.;
    for (unsigned int i = 0; i < n * n_nodes; ++i)
      work[i] = static_cast<float>(in[i] * scale[i] / size);

    for (unsigned int i = 0; i < n_nodes; ++i)
      {
        std::array<float, n> y;
        std::copy_n(&work[n * i], n, y.begin());
        for (unsigned int k = first[i]; k < diagonal[i]; ++k)
          for (int c = 0; c < n; ++c)
            for (int m = 0; m < n; ++m)
              y[m] += blocks[k][n * c + m] * work[n * columns[k] + c];
        std::copy_n(y.begin(), n, &work[n * i]);
      }
    for (unsigned int i = n_nodes; i-- > 0;)
      {
        std::array<float, n> y;
        std::copy_n(&work[n * i], n, y.begin());
        for (unsigned int k = diagonal[i] + 1; k < first[i + 1]; ++k)
          subtract_product<n>(blocks[k], &work[n * columns[k]], y.data());
        for (int m = 0; m < n; ++m)
          {
            float sum = 0.f;
            for (int c = 0; c < n; ++c)
              sum += blocks[diagonal[i]][n * c + m] * y[c];
            work[n * i + m] = sum;
          }
      }
    return size;
  }

  template <int n>
  void
  BlockIlu<n>::vmult(Vector &z, const Vector &r) const
  {
    const double size = substitute(r);
    double      *out  = z.begin();
    for (unsigned int i = 0; i < work.size(); ++i)
      out[i] = work[i] * scale[i] * size;
  }

  template <int n>
  void
  BlockIlu<n>::vmult_add(Vector &z, const Vector &r) const
  {
    const double size = substitute(r);
    double      *out  = z.begin();
    for (unsigned int i = 0; i < work.size(); ++i)
      out[i] += work[i] * scale[i] * size;
  }

  template class BlockIlu<2>;
  template class BlockIlu<3>;
} // namespace emmy
