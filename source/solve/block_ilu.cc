#include <emmy/math/lanes.h>
#include <emmy/solve/block_ilu.h>
#include <emmy/solve/overlap_rows.h>

#include <algorithm>
#include <cmath>
#include <cstring>

// vectors stay within this file
#pragma GCC diagnostic ignored "-Wpsabi"

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

    EMMY_INLINE Four
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
      EMMY_INLINE void
      add(const float *A, const float *x)
      {
        columns += read(A) * Four{x[0], x[0], x[1], x[1]};
      }
      EMMY_INLINE float
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
      EMMY_INLINE void
      add(const float *A, const float *x)
      {
        first += read(A) * x[0];
        second += read(A + 3) * x[1];
        third += read(A + 6) * x[2];
      }
      EMMY_INLINE float
      operator[](const int i) const
      {
        return first[i] + second[i] + third[i];
      }

    private:
      Four first{}, second{}, third{};
    };

    /** The arrays of BlockIlu. */
    template <int n>
    struct Factors
    {
      unsigned int        n_nodes, n_blocks;
      const unsigned int *lower, *upper, *columns;
      const float        *blocks;
      float              *work;
    };

    /** From r to U^-1 L^-1 r. */
    template <int n>
    EMMY_INLINE void
    substitute_all(const Factors<n> &of)
    {
      for (unsigned int i = 0; i < of.n_nodes; ++i)
        {
          NodeSum<n> sum;
          for (unsigned int k = of.lower[i]; k < of.lower[i + 1]; ++k)
            sum.add(of.blocks + n * n * std::size_t(k),
                    of.work + n * of.columns[k]);
          for (int m = 0; m < n; ++m)
            of.work[n * i + m] += sum[m];
        }
      for (unsigned int i = of.n_nodes; i-- > 0;)
        {
          const unsigned int end = i > 0 ? of.upper[i - 1] : of.n_blocks;
          NodeSum<n>         sum, result;
          for (unsigned int k = of.upper[i] + 1; k < end; ++k)
            sum.add(of.blocks + n * n * std::size_t(k),
                    of.work + n * of.columns[k]);
          for (int m = 0; m < n; ++m)
            of.work[n * i + m] -= sum[m];
          result.add(of.blocks + n * n * std::size_t(of.upper[i]),
                     of.work + n * i);
          for (int m = 0; m < n; ++m)
            of.work[n * i + m] = result[m];
        }
    }

    /** A block whose products with others are added, in registers. */
    template <int n>
    class LeftBlock;

    template <>
    class LeftBlock<2>
    {
    public:
      EMMY_INLINE explicit LeftBlock(const Four columns)
        : first{columns[0], columns[1], columns[0], columns[1]}
        , second{columns[2], columns[3], columns[2], columns[3]}
      {}
      EMMY_INLINE explicit LeftBlock(const float *block)
        : LeftBlock(read(block))
      {}
      EMMY_INLINE Four
      times(const float *b) const
      {
        return first * Four{b[0], b[0], b[2], b[2]} +
               second * Four{b[1], b[1], b[3], b[3]};
      }
      /** To minus the product with b, which @p block takes too. */
      EMMY_INLINE void
      multiply(const float *b, float *block)
      {
        const Four product = -times(b);
        std::memcpy(block, &product, sizeof product);
        *this = LeftBlock(product);
      }
      /** c += its product with b */
      EMMY_INLINE void
      add_product(const float *b, float *c) const
      {
        const Four sum = read(c) + times(b);
        std::memcpy(c, &sum, sizeof sum);
      }

    private:
      Four first, second; ///< columns, twice
    };

    template <>
    class LeftBlock<3>
    {
    public:
      EMMY_INLINE explicit LeftBlock(const float *block)
        : first(read(block))
        , second(read(block + 3))
        , third(read(block + 6))
      {}
      EMMY_INLINE Four
      times(const float *b) const
      {
        return first * b[0] + second * b[1] + third * b[2];
      }
      /** To minus the product with b, which @p block takes too. */
      EMMY_INLINE void
      multiply(const float *b, float *block)
      {
        const Four products[3] = {-times(b), -times(b + 3), -times(b + 6)};
        first                  = products[0];
        second                 = products[1];
        third                  = products[2];
        write(first, second, third, block);
      }
      /** c += its product with b */
      EMMY_INLINE void
      add_product(const float *b, float *c) const
      {
        write(read(c) + times(b),
              read(c + 3) + times(b + 3),
              read(c + 6) + times(b + 6),
              c);
      }

    private:
      /** The fourth number of a column is the first of the next. */
      EMMY_INLINE static void
      write(const Four &a, const Four &b, const Four &c, float *block)
      {
        std::memcpy(block, &a, sizeof a);
        std::memcpy(block + 3, &b, sizeof b);
        for (int i = 0; i < 3; ++i)
          block[6 + i] = c[i];
      }

      Four first, second, third; ///< columns
    };

    /**
     * To the inverse of a block whose entries are of the size of one, by
     * elimination with pivots; a pivot that vanishes is held off zero.
     */
    template <int n>
    void
    invert(float *block)
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
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
          block[n * j + i] = static_cast<float>(rows[i][n + j]);
    }
    /** The arrays of BlockIlu while they are made. */
    template <int n>
    struct Elimination
    {
      unsigned int        n_nodes, n_blocks;
      const unsigned int *lower, *upper, *columns;
      float              *blocks;
      unsigned int       *place; ///< by node; none
    };

    template <int n>
    EMMY_INLINE void
    eliminate_all(const Elimination<n> &of)
    {
      const auto block = [&](const unsigned int k) {
        return of.blocks + n * n * std::size_t(k);
      };
      const auto upper_end = [&](const unsigned int i) {
        return i > 0 ? of.upper[i - 1] : of.n_blocks;
      };
      for (unsigned int i = 0; i < of.n_nodes; ++i)
        {
          const auto set_places = [&](const bool are_known) {
            for (unsigned int k = of.lower[i]; k < of.lower[i + 1]; ++k)
              of.place[of.columns[k]] = are_known ? k : none;
            for (unsigned int k = of.upper[i]; k < upper_end(i); ++k)
              of.place[of.columns[k]] = are_known ? k : none;
          };
          set_places(true);
          for (unsigned int k = of.lower[i]; k < of.lower[i + 1]; ++k)
            {
              // L_ij = A_ij / U_jj, and its products with the row j of U
              const unsigned int j = of.columns[k];
              LeftBlock<n>       left(block(k));
              left.multiply(block(of.upper[j]), block(k)); // -L_ij
              for (unsigned int l = of.upper[j] + 1; l < upper_end(j); ++l)
                if (of.place[of.columns[l]] != none)
                  left.add_product(block(l), block(of.place[of.columns[l]]));
            }
          invert<n>(block(of.upper[i]));
          set_places(false);
        }
    }
  } // namespace

  namespace ilu_kernels
  {
    // no templates: those have no clones
    EMMY_CLONES void
    substitute(const Factors<2> &of)
    {
      substitute_all(of);
    }
    EMMY_CLONES void
    substitute(const Factors<3> &of)
    {
      substitute_all(of);
    }
    EMMY_CLONES void
    eliminate(const Elimination<2> &of)
    {
      eliminate_all(of);
    }
    EMMY_CLONES void
    eliminate(const Elimination<3> &of)
    {
      eliminate_all(of);
    }
  } // namespace ilu_kernels

  template <int n>
  BlockIlu<n>::BlockIlu()
    : rows(std::make_unique<OverlapRows<n>>())
  {}

  template <int n>
  BlockIlu<n>::~BlockIlu() = default;

  template <int n>
  void
  BlockIlu<n>::make(const Matrix &matrix)
  {
    if (rows->read(matrix))
      find_pattern();
    copy();
    factorise();
  }

  template <int n>
  void
  BlockIlu<n>::find_pattern()
  {
    const unsigned int        n_nodes = rows->n_nodes();
    std::vector<unsigned int> first(1, 0), pattern;
    std::vector<char>         is_met(n_nodes, false);
    for (unsigned int node = 0; node < n_nodes; ++node)
      {
        is_met[node] = true; // whatever the matrix has
        pattern.push_back(node);
        for (int i = 0; i < n; ++i)
          if (!rows->is_like_last(n * node + i))
            rows->for_each(n * node + i, [&](const unsigned int j, double) {
              if (!is_met[j / n])
                pattern.push_back(j / n);
              is_met[j / n] = true;
            });
        std::sort(pattern.begin() + first.back(), pattern.end());
        for (unsigned int k = first.back(); k < pattern.size(); ++k)
          is_met[pattern[k]] = false;
        first.push_back(pattern.size());
      }
    arrange(first, pattern);
  }

  template <int n>
  void
  BlockIlu<n>::copy()
  {
    const unsigned int n_nodes = rows->n_nodes();
    scale.assign(n * n_nodes, 1.);
    for (unsigned int i = 0; i < n * n_nodes; ++i)
      if (rows->diagonal(i) != 0.)
        scale[i] = 1. / std::sqrt(std::abs(rows->diagonal(i)));

    if (blocks.capacity() <= columns.size())
      blocks = std::vector<Block>(); // else old and new would stand together
    // one more: something to read behind the last
    blocks.assign(columns.size() + 1, Block{});
    std::vector<unsigned int> place(n_nodes, none);
    for (unsigned int node = 0; node < n_nodes; ++node)
      {
        for (unsigned int k = lower[node]; k < lower[node + 1]; ++k)
          place[columns[k]] = k;
        for (unsigned int k = upper[node]; k < upper_end(node); ++k)
          place[columns[k]] = k;
        for (int i = 0; i < n; ++i)
          {
            const double of_row = scale[n * node + i];
            rows->for_each(n * node + i,
                           [&](const unsigned int j, const double value) {
                             blocks[place[j / n]][n * (j % n) + i] =
                               static_cast<float>(value * of_row * scale[j]);
                           });
          }
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
  }

  template <int n>
  void
  BlockIlu<n>::factorise()
  {
    const unsigned int        n_nodes = upper.size();
    std::vector<unsigned int> place(n_nodes, none);
    ilu_kernels::eliminate(
      Elimination<n>{n_nodes,
                     static_cast<unsigned int>(columns.size()),
                     lower.data(),
                     upper.data(),
                     columns.data(),
                     blocks.front().data(),
                     place.data()});
    work.resize(n * n_nodes);
  }

  template <int n>
  double
  BlockIlu<n>::substitute(const Vector &r) const
  {
    const unsigned int n_nodes = upper.size(), begin = rows->begin(),
                       end            = rows->end();
    const double *const        in     = r.begin();
    const std::vector<double> &others = rows->of_others(r);
    const auto                 scaled = [&](const unsigned int i) {
      return scale[i] * (i < begin ? others[i]
                                         : i < end ? in[i - begin]
                                                   : others[i - (end - begin)]);
    };
    // single precision has no room for very large and very small numbers
    double largest = 0.;
    for (unsigned int i = 0; i < n * n_nodes; ++i)
      largest = std::max(largest, std::abs(scaled(i)));
    const double size = largest > 0. ? largest : 1.;
    for (unsigned int i = 0; i < n * n_nodes; ++i)
      work[i] = static_cast<float>(scaled(i) / size);

    ilu_kernels::substitute(
      Factors<n>{n_nodes,
                 static_cast<unsigned int>(columns.size()),
                 lower.data(),
                 upper.data(),
                 columns.data(),
                 blocks.front().data(),
                 work.data()});
    return size;
  }

  template <int n>
  void
  BlockIlu<n>::vmult(Vector &z, const Vector &r) const
  {
    const double size = substitute(r);
    double      *out  = z.begin();
    for (unsigned int i = rows->begin(); i < rows->end(); ++i)
      out[i - rows->begin()] = work[i] * scale[i] * size;
  }

  template <int n>
  void
  BlockIlu<n>::vmult_add(Vector &z, const Vector &r) const
  {
    const double size = substitute(r);
    double      *out  = z.begin();
    for (unsigned int i = rows->begin(); i < rows->end(); ++i)
      out[i - rows->begin()] += work[i] * scale[i] * size;
  }

  template class BlockIlu<2>;
  template class BlockIlu<3>;
} // namespace emmy
