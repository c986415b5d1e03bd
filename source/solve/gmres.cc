#include <emmy/math/four_numbers.h>
#include <emmy/solve/gmres.h>

#include <algorithm>
#include <cmath>

// vectors stay within this file
#pragma GCC diagnostic ignored "-Wpsabi"

namespace emmy
{
  namespace
  {
    /** Entries that are read together, which a cache holds. */
    constexpr std::size_t block_length = 1024;

    /** Less than this part left: what was taken out is inexact (Daniel,
     * Gragg, Kaufman, Stewart 1976). */
    constexpr double little = 0.7;

    /** A part that is round-off. */
    constexpr double nothing = 1e-13;

    /** A rotation that turns (a, b) to (r, 0), and applied to others. */
    struct Rotation
    {
      double c = 1., s = 0.;

      Rotation(const double a, const double b)
      {
        const double r = std::hypot(a, b);
        if (r > 0.)
          {
            c = a / r;
            s = b / r;
          }
      }

      void
      turn(double &a, double &b) const
      {
        const double old = a;
        a                = c * old + s * b;
        b                = c * b - s * old;
      }
    };
  } // namespace

  namespace gmres_kernels
  {
    EMMY_CLONES double
    product(const double *a, const double *b, const std::size_t n)
    {
      // two sums, as one alone waits for each addition
      FourNumbers sums[2]{};
      std::size_t i = 0;
      for (; i + 2 * n_together <= n; i += 2 * n_together)
        for (unsigned int k = 0; k < 2; ++k)
          sums[k] += read_together(a + i + k * n_together) *
                     read_together(b + i + k * n_together);
      sums[0] += sums[1];
      double result = (sums[0][0] + sums[0][1]) + (sums[0][2] + sums[0][3]);
      for (; i < n; ++i)
        result += a[i] * b[i];
      return result;
    }

    /** sum += amount v */
    EMMY_CLONES void
    add(const double amount, const double *v, const std::size_t n, double *sum)
    {
      for (std::size_t i = 0; i < n; ++i)
        sum[i] += amount * v[i];
    }
  } // namespace gmres_kernels

  bool
  Gmres::solve(Vector            &x,
               const Vector      &b,
               const double       goal,
               const unsigned int most)
  {
    this->most      = most;
    n_iterations    = 0;
    broken          = false;
    x               = 0.;
    Vector residual = b;
    double norm     = b.l2_norm();
    while (norm > goal && n_iterations < most && !broken)
      {
        if (n_iterations > 0) // after a restart
          norm = matrix.residual(residual, x, b);
        if (norm > goal)
          norm = run(x, residual, norm, goal);
        broken = broken || !std::isfinite(norm);
      }
    broken = broken || !std::isfinite(norm);
    return !broken && norm <= goal;
  }

  double
  Gmres::run(Vector &x, Vector &residual, const double norm, const double goal)
  {
    Vector                           preconditioned = residual, &w = residual;
    std::vector<std::vector<double>> columns; // of the triangle
    std::vector<Rotation>            rotations;
    std::vector<double>              right{norm};
    const std::size_t                n_local = residual.locally_owned_size();
    const auto                       keep    = [&](const double length) {
      if (vectors.size() == n_vectors)
        vectors.emplace_back(n_local);
      std::transform(w.begin(),
                     w.end(),
                     vectors[n_vectors].begin(),
                     [&](const double entry) { return entry / length; });
      ++n_vectors;
    };
    n_vectors = 0;
    keep(norm);
    while (columns.size() < restart && n_iterations < most)
      {
        std::copy(vectors[n_vectors - 1].begin(),
                  vectors[n_vectors - 1].end(),
                  w.begin());
        preconditioner.vmult(preconditioned, w);
        matrix.vmult(w, preconditioned);
        ++n_iterations;
        std::vector<double> column = take_out(w);
        const double        rest   = column.back();
        if (!std::isfinite(rest))
          {
            broken = true;
            return rest;
          }
        double square = 0.;
        for (const double amount : column)
          square += amount * amount;
        const double least   = nothing * std::sqrt(square);
        const bool   is_last = rest <= least; // nothing new comes any more
        for (std::size_t j = 0; j < rotations.size(); ++j)
          rotations[j].turn(column[j], column[j + 1]);
        const std::size_t last = rotations.size();
        if (is_last && std::abs(column[last]) <= least) // a singular matrix
          {
            broken = true;
            break;
          }
        rotations.emplace_back(column[last], column[last + 1]);
        rotations.back().turn(column[last], column[last + 1]);
        right.push_back(0.);
        rotations.back().turn(right[last], right[last + 1]);
        columns.push_back(column);
        if (std::abs(right.back()) <= goal || is_last)
          break;
        keep(rest);
      }

    std::vector<double> y(columns.size());
    for (std::size_t i = columns.size(); i-- > 0;)
      {
        y[i] = right[i];
        for (std::size_t j = i + 1; j < columns.size(); ++j)
          y[i] -= columns[j][i] * y[j];
        y[i] /= columns[i][i];
      }
    add_combination(y, x);
    return std::abs(right.back());
  }

  std::vector<double>
  Gmres::take_out(Vector &w) const
  {
    const std::size_t   n_local = w.locally_owned_size();
    double *const       entries = w.begin();
    std::vector<double> amounts(n_vectors + 1, 0.);
    double              rest = 0.; // its square
    for (const bool is_second : {false, true})
      {
        std::vector<double> sums(n_vectors + 1, 0.);
        for (std::size_t i = 0; i < n_local; i += block_length)
          {
            const std::size_t n = std::min(block_length, n_local - i);
            for (unsigned int j = 0; j < n_vectors; ++j)
              sums[j] +=
                gmres_kernels::product(vectors[j].data() + i, entries + i, n);
            sums.back() += gmres_kernels::product(entries + i, entries + i, n);
          }
        dealii::Utilities::MPI::sum(sums, w.get_mpi_communicator(), sums);
        rest = sums.back();
        for (unsigned int j = 0; j < n_vectors; ++j)
          {
            amounts[j] += sums[j];
            rest -= sums[j] * sums[j];
          }
        for (std::size_t i = 0; i < n_local; i += block_length)
          {
            const std::size_t n = std::min(block_length, n_local - i);
            for (unsigned int j = 0; j < n_vectors; ++j)
              gmres_kernels::add(-sums[j],
                                 vectors[j].data() + i,
                                 n,
                                 entries + i);
          }
        if (is_second || rest >= little * little * sums.back())
          break;
      }
    amounts.back() = rest > 0. || std::isnan(rest) ? std::sqrt(rest) : 0.;
    return amounts;
  }

  void
  Gmres::add_combination(const std::vector<double> &y, Vector &x)
  {
    Vector            sum = x, change = x;
    double *const     entries = sum.begin();
    const std::size_t n_local = sum.locally_owned_size();
    std::fill(sum.begin(), sum.end(), 0.);
    for (std::size_t i = 0; i < n_local; i += block_length)
      {
        const std::size_t n = std::min(block_length, n_local - i);
        for (std::size_t j = 0; j < y.size(); ++j)
          gmres_kernels::add(y[j], vectors[j].data() + i, n, entries + i);
      }
    preconditioner.vmult(change, sum);
    x += change;
  }
} // namespace emmy
