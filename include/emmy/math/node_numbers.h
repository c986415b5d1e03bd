#ifndef emmy_math_node_numbers_h
#define emmy_math_node_numbers_h

#include <emmy/math/lanes.h>

#include <cstring>

namespace emmy
{
  /**
   * The numbers of a node, one for each direction, side by side in a register;
   * in space one more, which does not matter.
   */
  template <int dim>
  struct NodeNumbers;
  /** In the plane. */
  template <>
  struct NodeNumbers<2>
  {
    /** The compiler's vector. */
    typedef double type __attribute__((vector_size(16)));
  };
  /** In space. */
  template <>
  struct NodeNumbers<3>
  {
    /** The compiler's vector. */
    typedef double type __attribute__((vector_size(32)));
  };

  /** Of a node; in space one more behind them is read. */
  template <int dim>
  EMMY_INLINE typename NodeNumbers<dim>::type
  read_node(const double *numbers)
  {
    typename NodeNumbers<dim>::type result;
    std::memcpy(&result, numbers, sizeof result);
    return result;
  }
} // namespace emmy

#endif
