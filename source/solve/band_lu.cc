#include <deal.II/base/exceptions.h>

#include <emmy/solve/band_lu.h>

#include <algorithm>
#include <cmath>

namespace emmy
{
  void
  BandLu::reinit(const unsigned int n, const unsigned int width)
  {
    this->width = width;
    entries.assign(std::size_t(3 * width + 1) * n, 0.);
    factors.resize(std::size_t(width) * n);
    exchanged.resize(n);
    ends.resize(n);
    for (unsigned int i = 0; i < n; ++i)
      ends[i] = std::min(n, i + width + 1);
  }

  void
  BandLu::exchange(const unsigned int k, const unsigned int last)
  {
    unsigned int best = k;
    for (unsigned int i = k + 1; i < last; ++i)
      if (std::abs(row(i)[k]) > std::abs(row(best)[k]))
        best = i;
    AssertThrow(std::abs(row(best)[k]) > 0.,
                dealii::ExcMessage("The matrix is singular."));
    exchanged[k] = best;
    if (best == k)
      return;
    std::swap_ranges(row(k) + k,
                     row(k) + std::max(ends[k], ends[best]),
                     row(best) + k);
    std::swap(ends[k], ends[best]);
  }

  void
  BandLu::factorise()
  {
    const unsigned int n = ends.size();
    for (unsigned int k = 0; k < n; ++k)
      {
        const unsigned int last = std::min(n, k + width + 1);
        exchange(k, last);
        const double *const pivot_row = row(k);
        for (unsigned int i = k + 1; i < last; ++i)
          {
            double *const target = row(i);
            const double  factor = target[k] / pivot_row[k];
            factors[std::size_t(width) * k + i - k - 1] = factor;
            if (factor == 0.)
              continue;
            for (unsigned int j = k + 1; j < ends[k]; ++j)
              target[j] -= factor * pivot_row[j];
            ends[i] = std::max(ends[i], ends[k]);
          }
      }
  }

  void
  BandLu::solve(double *x) const
  {
    const unsigned int n = ends.size();
    for (unsigned int k = 0; k < n; ++k)
      {
        std::swap(x[k], x[exchanged[k]]);
        const double        x_k    = x[k];
        const double *const factor = &factors[std::size_t(width) * k];
        const unsigned int  last   = std::min(n, k + width + 1);
        for (unsigned int i = k + 1; i < last; ++i)
          x[i] -= factor[i - k - 1] * x_k;
      }
    for (unsigned int k = n; k-- > 0;)
      {
        const double *const of_row = row(k);
        // four sums, as one alone waits for each addition
        double       sums[4] = {0., 0., 0., 0.};
        unsigned int j       = k + 1;
        for (; j + 4 <= ends[k]; j += 4)
          for (unsigned int l = 0; l < 4; ++l)
            sums[l] += of_row[j + l] * x[j + l];
        for (; j < ends[k]; ++j)
          sums[0] += of_row[j] * x[j];
        x[k] = (x[k] - (sums[0] + sums[1]) - (sums[2] + sums[3])) / of_row[k];
      }
  }
} // namespace emmy
