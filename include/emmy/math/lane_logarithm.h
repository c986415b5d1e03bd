#ifndef emmy_math_lane_logarithm_h
#define emmy_math_lane_logarithm_h

#include <emmy/math/lanes.h>

#include <cstring>
#include <limits>

namespace emmy
{
  /**
   * ln(1 + x) of normal numbers 1 + x > 0, NaN of others, to some units in the
   * last digit, however small x is. For functions with clones, in files without
   * fused multiplications and additions: then the bits are the same on all
   * instruction sets.
   *
   * With 1 + x = 2^k m and m between sqrt(1/2) and sqrt(2) it is
   * k ln 2 + 2 artanh((m - 1)/(m + 1)), by the series of artanh, whose first
   * dropped term is below 1e-18. What 1 + x has lost of x, relative to 1 + x,
   * is added.
   */
  EMMY_INLINE void
  log_one_plus(const Lanes &x, Lanes &result)
  {
    typedef unsigned long long Integers
      __attribute__((vector_size(sizeof(Lanes))));
    // ln 2: all digits of k high_part stand in a double
    constexpr double high_part = 0x1.62e42fefa38p-1,
                     low_part  = 0x1.ef35793c7673p-45;
    const Lanes sum            = 1. + x;
    const Lanes lost           = (x - (sum - 1.)) / sum;

    // m from sqrt(1/2) on shall have the exponent of 1. What processors have
    // for integers: no signed shifts, no conversion; so these go up by 1024
    Integers bits;
    std::memcpy(&bits, &sum, sizeof bits);
    const Integers shifted  = bits + ((1024ull << 52) - 0x3fe6a09e667f3bcdull);
    const Integers up       = shifted >> 52;
    const Integers mantissa = bits - ((up - 1024ull) << 52);
    const Integers in_last  = up + 0x4330000000000000ull; // of 2^52
    Lanes          m, k;
    std::memcpy(&m, &mantissa, sizeof m);
    std::memcpy(&k, &in_last, sizeof k);
    k -= 0x1p52 + 1024.;

    const Lanes f = m - 1., s = f / (2. + f), z = s * s;
    Lanes       series = z / 23. + 1. / 21.;
    series             = series * z + 1. / 19.;
    series             = series * z + 1. / 17.;
    series             = series * z + 1. / 15.;
    series             = series * z + 1. / 13.;
    series             = series * z + 1. / 11.;
    series             = series * z + 1. / 9.;
    series             = series * z + 1. / 7.;
    series             = series * z + 1. / 5.;
    series             = series * z + 1. / 3.;
    // 2 artanh s = f - s (f - 2 z series): the first term has no error
    const Lanes rest = s * (f - 2. * z * series);
    result           = k * high_part + (f - (rest - (k * low_part + lost)));
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    result                = sum > 0. ? result : Lanes{} + none;
  }
} // namespace emmy

#endif
