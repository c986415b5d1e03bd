#ifndef emmy_math_four_numbers_h
#define emmy_math_four_numbers_h

#include <emmy/math/lanes.h>

#include <cstring>

namespace emmy
{
  /** Numbers of an array that are worked on together. */
  constexpr unsigned int n_together = 4;
  /** These, in a register where it is wide enough. */
  using FourNumbers = LanesOf<n_together>::type;

  /** These, or one, from anywhere in an array. */
  template <class Numbers = FourNumbers>
  EMMY_INLINE Numbers
  read_together(const double *numbers)
  {
    Numbers result;
    std::memcpy(&result, numbers, sizeof result);
    return result;
  }

  /** Put four anywhere in an array. */
  EMMY_INLINE void
  write_together(const FourNumbers &numbers, double *to)
  {
    std::memcpy(to, &numbers, sizeof numbers);
  }
} // namespace emmy

#endif
