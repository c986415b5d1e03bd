#ifndef emmy_tests_performance_core_speed_h
#define emmy_tests_performance_core_speed_h

// What one core can do: multiplications and additions, and bytes of memory.

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <vector>

namespace core_speed
{
  /** Numbers side by side, and as many of them as hide the time of each. */
  template <int width>
  struct Lanes
  {
    typedef double type __attribute__((vector_size(8 * width)));
  };
  constexpr unsigned int n_sums = 12;

  /** a = a * b + c on numbers that stay in registers. */
  template <int width>
  inline __attribute__((always_inline)) double
  multiply_and_add(const std::size_t n)
  {
    typename Lanes<width>::type a[n_sums];
    for (unsigned int i = 0; i < n_sums; ++i)
      a[i] = typename Lanes<width>::type{} + (1. + 1e-3 * i);
    for (std::size_t k = 0; k < n; ++k)
      for (unsigned int i = 0; i < n_sums; ++i)
        a[i] = a[i] * 0.999999999 + 1e-9;
    double sum = 0.;
    for (unsigned int i = 0; i < n_sums; ++i)
      for (int lane = 0; lane < width; ++lane)
        sum += a[i][lane];
    return sum;
  }

  /** The same in the registers that the processor has, and their width. */
  struct Registers
  {
    double (*run)(const std::size_t);
    int width;
  };
#if defined(__x86_64__)
  inline __attribute__((target("avx512f"))) double
  run_512(const std::size_t n)
  {
    return multiply_and_add<8>(n);
  }
  inline __attribute__((target("avx2,fma"))) double
  run_256(const std::size_t n)
  {
    return multiply_and_add<4>(n);
  }
  inline Registers
  widest()
  {
    if (__builtin_cpu_supports("avx512f"))
      return {run_512, 8};
    if (__builtin_cpu_supports("fma"))
      return {run_256, 4};
    return {multiply_and_add<2>, 2};
  }
#else
  inline Registers
  widest()
  {
    return {multiply_and_add<2>, 2};
  }
#endif

  inline double
  now()
  {
    return std::chrono::duration<double>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
  }

  /** 1e9 multiplications and additions a second, on one core. */
  inline double
  peak_gflops()
  {
    const Registers registers = widest();
    double          best      = 0.;
    volatile double sink      = 0.;
    for (int i = 0; i < 5; ++i)
      {
        constexpr std::size_t n     = 20000000;
        const double          begin = now();
        sink                        = sink + registers.run(n);
        best =
          std::max(best, 2e-9 * n_sums * registers.width * n / (now() - begin));
      }
    return best;
  }

  /** 1e9 bytes a second of a = b + s c, on one core. */
  inline double
  triad_bandwidth()
  {
    constexpr std::size_t n = 10000000;
    std::vector<double>   a(n, 1.), b(n, 2.), c(n, 3.);
    double                best = 0.;
    for (int i = 0; i < 5; ++i)
      {
        const double begin = now();
        for (std::size_t k = 0; k < n; ++k)
          a[k] = b[k] + 0.5 * c[k];
        best = std::max(best, 3e-9 * sizeof(double) * n / (now() - begin));
        std::swap(a, b);
      }
    return best;
  }
} // namespace core_speed

#endif
