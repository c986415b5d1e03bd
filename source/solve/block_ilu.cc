#include <emmy/solve/block_ilu.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_Import.h>
#include <Epetra_Map.h>
#include <Epetra_Vector.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace emmy
{
  namespace
  {
    constexpr unsigned int none = dealii::numbers::invalid_unsigned_int;

    /**
     * Four numbers side by side. Columns of three are read with one more number
     * behind them, which does not matter.
     */
    typedef float Four __attribute__((vector_size(16)));

    inline Four
    read(const float *values)
    {
      Four result;
      std::memcpy(&result, values, sizeof result);
      return result;
    }

    /**
     * A sum of products of blocks with vectors of a node: one register for
     * each column, in the plane one for both.
     */
    template <int n>
    class NodeSum;

    template <>
    class NodeSum<2>
    {
    public:
      void
      add(const float *A, const float *x)
      {
        columns += read(A) * Four{x[0], x[0], x[1], x[1]};
      }
      float
      operator[](const int i) const
      {
        return columns[i] + columns[2 + i];
      }

    private:
      Four columns{};
    };

    template <>
    class NodeSum<3>
    {
    public:
      void
      add(const float *A, const float *x)
      {
        first += read(A) * x[0];
        second += read(A + 3) * x[1];
        third += read(A + 6) * x[2];
      }
      float
      operator[](const int i) const
      {
        return first[i] + second[i] + third[i];
      }

    private:
      Four first{}, second{}, third{};
    };

    /** C += A B. */
    template <int n>
    void
    add_product(const float *a, const float *b, float *c)
    {
      if constexpr (n == 2)
        {
          const Four sum =
            read(c) +
            Four{a[0], a[1], a[0], a[1]} * Four{b[0], b[0], b[2], b[2]} +
            Four{a[2], a[3], a[2], a[3]} * Four{b[1], b[1], b[3], b[3]};
          std::memcpy(c, &sum, sizeof sum);
        }
      else
        {
          const Four columns[3] = {read(a), read(a + 3), read(a + 6)};
          Four       sums[3];
          for (int j = 0; j < 3; ++j)
            sums[j] = read(c + 3 * j) + columns[0] * b[3 * j] +
                      columns[1] * b[3 * j + 1] + columns[2] * b[3 * j + 2];
          // the fourth number of a column is the first of the next
          for (int j = 0; j < 3; ++j)
            std::memcpy(c + 3 * j,
                        &sums[j],
                        j < 2 ? sizeof(Four) : 3 * sizeof(float));
        }
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

    /** The nodes of other ranks that rows of this one meet, in order. */
    template <int n>
    std::vector<int>
    met_on_others(const Epetra_CrsMatrix &entries)
    {
      const Epetra_Map &met = entries.ColMap();
      std::vector<int>  result;
      for (int j = 0; j < met.NumMyElements(); ++j)
        if (!entries.RowMap().MyGID(met.GID(j)))
          result.push_back(met.GID(j) / n);
      std::sort(result.begin(), result.end());
      result.erase(std::unique(result.begin(), result.end()), result.end());
      return result;
    }

    void
    check_exchange(const int code)
    {
      AssertThrow(code >= 0,
                  dealii::ExcMessage("Epetra's exchange failed with " +
                                     std::to_string(code)));
    }

    /** The unknowns of these nodes. */
    template <int n>
    Epetra_Map
    unknowns_of(const std::vector<int> &nodes, const Epetra_Map &all)
    {
      std::vector<int> unknowns;
      for (const int node : nodes)
        for (int i = 0; i < n; ++i)
          unknowns.push_back(n * node + i);
      return {
        -1, static_cast<int>(unknowns.size()), unknowns.data(), 0, all.Comm()};
    }

    /**
     * The rows of this rank's nodes between those of the nodes of others that
     * they meet, all in the order of the whole matrix. Columns are counted
     * likewise; those further away are left out.
     */
    template <int n>
    class Rows
    {
    public:
      /**
       * @param met nodes of others
       * @param rows_of_met their unknowns
       * @param others where their rows come from, or nullptr
       */
      Rows(const Epetra_CrsMatrix &entries,
           const std::vector<int> &met,
           const Epetra_Map       &rows_of_met,
           const Epetra_Import    *others)
        : entries(entries)
        , begin(n * (std::lower_bound(met.begin(),
                                      met.end(),
                                      entries.RowMap().MinMyGID() / n) -
                     met.begin()))
        , end(begin + entries.NumMyRows())
        , n_nodes(entries.NumMyRows() / n + met.size())
        , column(entries.ColMap().NumMyElements())
      {
        const auto place_of = [&](const int unknown) {
          const int own = entries.RowMap().LID(unknown);
          if (own >= 0)
            return begin + own;
          const auto node =
            std::lower_bound(met.begin(), met.end(), unknown / n);
          if (node == met.end() || *node != unknown / n)
            return none;
          const unsigned int place = n * (node - met.begin()) + unknown % n;
          return place < begin ? place : place + end - begin;
        };
        for (unsigned int j = 0; j < column.size(); ++j)
          column[j] = place_of(entries.ColMap().GID(j));
        if (others == nullptr)
          return;
        Epetra_CrsMatrix rows(Copy, rows_of_met, 0);
        check_exchange(rows.Import(entries, *others, Insert));
        for (int i = 0; i < rows.NumMyRows(); ++i)
          {
            int     length, *unknowns;
            double *of_row;
            rows.ExtractGlobalRowView(rows.GRID(i), length, of_row, unknowns);
            for (int k = 0; k < length; ++k)
              other_columns.push_back(place_of(unknowns[k]));
            values.insert(values.end(), of_row, of_row + length);
            first.push_back(values.size());
          }
      }

      /** Calls entry(column, value) for those of the unknown i. */
      template <typename Entry>
      void
      for_each(const unsigned int i, const Entry &entry) const
      {
        if (i >= begin && i < end)
          {
            int     length, *in_row;
            double *of_row;
            entries.ExtractMyRowView(i - begin, length, of_row, in_row);
            for (int k = 0; k < length; ++k)
              if (column[in_row[k]] != none)
                entry(column[in_row[k]], of_row[k]);
            return;
          }
        const unsigned int other = i < begin ? i : i - (end - begin);
        for (std::size_t k = first[other]; k < first[other + 1]; ++k)
          if (other_columns[k] != none)
            entry(other_columns[k], values[k]);
      }

    private:
      const Epetra_CrsMatrix &entries;

    public:
      /** Of this rank's unknowns. */
      const unsigned int begin, end;
      const unsigned int n_nodes;

    private:
      std::vector<unsigned int> column, other_columns;
      std::vector<double>       values;
      std::vector<std::size_t>  first = {0};
    };
  } // namespace

  template <int n>
  BlockIlu<n>::BlockIlu() = default;

  template <int n>
  BlockIlu<n>::~BlockIlu() = default;

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
    const std::vector<int>  met     = met_on_others<n>(entries);
    AssertThrow(entries.RowMap().LinearMap(),
                dealii::ExcMessage("Unknowns of ranks are not in order."));
    const Epetra_Map rows_of_met = unknowns_of<n>(met, entries.RowMap());
    if (entries.Comm().NumProc() > 1)
      {
        others = std::make_unique<Epetra_Import>(rows_of_met, entries.RowMap());
        from_others = std::make_unique<Epetra_Vector>(rows_of_met);
      }
    const Rows<n>      rows(entries, met, rows_of_met, others.get());
    const unsigned int n_nodes = rows.n_nodes;
    begin                      = rows.begin;
    end                        = rows.end;

    std::vector<unsigned int> first(1, 0), pattern, place(n_nodes, none);
    scale.assign(n * n_nodes, 1.);
    for (unsigned int node = 0; node < n_nodes; ++node)
      {
        place[node] = 0; // whatever the matrix has
        pattern.push_back(node);
        for (int i = 0; i < n; ++i)
          rows.for_each(n * node + i,
                        [&](const unsigned int j, const double value) {
                          if (place[j / n] == none)
                            {
                              place[j / n] = 0;
                              pattern.push_back(j / n);
                            }
                          if (j == n * node + i && value != 0.)
                            scale[j] = 1. / std::sqrt(std::abs(value));
                        });
        std::sort(pattern.begin() + first.back(), pattern.end());
        for (unsigned int k = first.back(); k < pattern.size(); ++k)
          place[pattern[k]] = none;
        first.push_back(pattern.size());
      }
    arrange(first, pattern);

    for (unsigned int node = 0; node < n_nodes; ++node)
      {
        for (unsigned int k = lower[node]; k < lower[node + 1]; ++k)
          place[columns[k]] = k;
        for (unsigned int k = upper[node]; k < upper_end(node); ++k)
          place[columns[k]] = k;
        for (int i = 0; i < n; ++i)
          rows.for_each(n * node + i,
                        [&](const unsigned int j, const double value) {
                          blocks[place[j / n]][n * (j % n) + i] =
                            static_cast<float>(value * scale[n * node + i] *
                                               scale[j]);
                        });
      }
  }

  template <int n>
  void
  BlockIlu<n>::arrange(const std::vector<unsigned int> &first,
                       const std::vector<unsigned int> &pattern)
  {
    const unsigned int n_nodes = first.size() - 1;
    columns.clear();
    lower.assign(1, 0);
    upper.resize(n_nodes);
    const auto diagonal_of = [&](const unsigned int node) {
      return std::lower_bound(pattern.begin() + first[node],
                              pattern.begin() + first[node + 1],
                              node);
    };
    for (unsigned int node = 0; node < n_nodes; ++node)
      {
        columns.insert(columns.end(),
                       pattern.begin() + first[node],
                       diagonal_of(node));
        lower.push_back(columns.size());
      }
    for (unsigned int node = n_nodes; node-- > 0;)
      {
        upper[node] = columns.size();
        columns.insert(columns.end(),
                       diagonal_of(node),
                       pattern.begin() + first[node + 1]);
      }
    // one more: something to read behind the last
    blocks.assign(columns.size() + 1, Block{});
  }

  template <int n>
  void
  BlockIlu<n>::factorise()
  {
    const unsigned int        n_nodes = upper.size();
    std::vector<unsigned int> place(n_nodes, none);
    for (unsigned int i = 0; i < n_nodes; ++i)
      {
        const auto set_places = [&](const bool are_known) {
          for (unsigned int k = lower[i]; k < lower[i + 1]; ++k)
            place[columns[k]] = are_known ? k : none;
          for (unsigned int k = upper[i]; k < upper_end(i); ++k)
            place[columns[k]] = are_known ? k : none;
        };
        set_places(true);
        for (unsigned int k = lower[i]; k < lower[i + 1]; ++k)
          {
            // L_ij = A_ij / U_jj, and its products with the row j of U
            const unsigned int           j = columns[k];
            std::array<float, n * n + 1> product{};
            add_product<n>(blocks[k].data(),
                           blocks[upper[j]].data(),
                           product.data());
            for (float &entry : product)
              entry *= -1.f;
            std::copy_n(product.begin(), n * n, blocks[k].begin()); // -L_ij
            for (unsigned int l = upper[j] + 1; l < upper_end(j); ++l)
              if (place[columns[l]] != none)
                add_product<n>(product.data(),
                               blocks[l].data(),
                               blocks[place[columns[l]]].data());
          }
        blocks[upper[i]] = inverse<n>(blocks[upper[i]]);
        set_places(false);
      }
    work.resize(n * n_nodes);
  }

  template <int n>
  double
  BlockIlu<n>::substitute(const Vector &r) const
  {
    const unsigned int n_nodes = upper.size();
    const double      *in      = r.begin();
    if (others != nullptr)
      check_exchange(from_others->Import(r.trilinos_vector(), *others, Insert));
    const auto scaled = [&](const unsigned int i) {
      return scale[i] * (i < begin ? (*from_others)[i]
                         : i < end ? in[i - begin]
                                   : (*from_others)[i - (end - begin)]);
    };
    // single precision has no room for very large and very small numbers
    double largest = 0.;
    for (unsigned int i = 0; i < n * n_nodes; ++i)
      largest = std::max(largest, std::abs(scaled(i)));
    const double size = largest > 0. ? largest : 1.;
    for (unsigned int i = 0; i < n * n_nodes; ++i)
      work[i] = static_cast<float>(scaled(i) / size);

    for (unsigned int i = 0; i < n_nodes; ++i)
      {
        NodeSum<n> sum;
        for (unsigned int k = lower[i]; k < lower[i + 1]; ++k)
          sum.add(blocks[k].data(), &work[n * columns[k]]);
        for (int m = 0; m < n; ++m)
          work[n * i + m] += sum[m];
      }
    for (unsigned int i = n_nodes; i-- > 0;)
      {
        NodeSum<n> sum, result;
        for (unsigned int k = upper[i] + 1; k < upper_end(i); ++k)
          sum.add(blocks[k].data(), &work[n * columns[k]]);
        for (int m = 0; m < n; ++m)
          work[n * i + m] -= sum[m];
        result.add(blocks[upper[i]].data(), &work[n * i]);
        for (int m = 0; m < n; ++m)
          work[n * i + m] = result[m];
      }
    return size;
  }

  template <int n>
  void
  BlockIlu<n>::vmult(Vector &z, const Vector &r) const
  {
    const double size = substitute(r);
    double      *out  = z.begin();
    for (unsigned int i = begin; i < end; ++i)
      out[i - begin] = work[i] * scale[i] * size;
  }

  template <int n>
  void
  BlockIlu<n>::vmult_add(Vector &z, const Vector &r) const
  {
    const double size = substitute(r);
    double      *out  = z.begin();
    for (unsigned int i = begin; i < end; ++i)
      out[i - begin] += work[i] * scale[i] * size;
  }

  template class BlockIlu<2>;
  template class BlockIlu<3>;
} // namespace emmy
