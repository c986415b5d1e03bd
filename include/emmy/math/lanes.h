#ifndef emmy_math_lanes_h
#define emmy_math_lanes_h

/**
 * Before a function: it is compiled for several instruction sets, and the
 * processor chooses when the program starts. What it calls must be inlined.
 * Where the compiler cannot do so, it is compiled once.
 */
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && \
  defined(__linux__) && !defined(__AVX512F__) &&                       \
  !defined(__SANITIZE_ADDRESS__)
#  define EMMY_CLONES \
    __attribute__((target_clones("avx512f", "fma", "default")))
#else
#  define EMMY_CLONES
#endif

/** For what functions with clones call. */
#define EMMY_INLINE inline __attribute__((always_inline))

namespace emmy
{
  /**
   * Numbers side by side, as of several points or nodes: an operation acts on
   * all of them. Compiled to the widest registers that there are. (A vector of
   * GCC and Clang; never handed on by value, since how that is done depends on
   * the instruction set.)
   */
  template <int n>
  struct LanesOf;
  /** Of 256 bits. */
  template <>
  struct LanesOf<4>
  {
    /** The compiler's vector. */
    typedef double type __attribute__((vector_size(32)));
  };
  /** Which four of the eight in two such registers, for __builtin_shuffle. */
  typedef long long Order __attribute__((vector_size(32)));
  /** Of 512 bits. */
  template <>
  struct LanesOf<8>
  {
    /** The compiler's vector. */
    typedef double type __attribute__((vector_size(64)));
  };

  /**
   * Points that are worked on together. Eight would need twice the registers:
   * where they have 256 bits most numbers would be kept in memory.
   */
  constexpr unsigned int n_lanes = 4;
  /** One number of each of these points. */
  using Lanes = LanesOf<n_lanes>::type;

  /** Nodes that stand side by side where numbers are by node. */
  template <int dim>
  constexpr unsigned int node_lanes = (dim == 2) ? 4 : 8;

  /** How many numbers a row over the nodes of a group has: full lanes. */
  template <int dim>
  constexpr unsigned int
  padded(const unsigned int n_nodes)
  {
    return (n_nodes + node_lanes<dim> - 1) / node_lanes<dim> * node_lanes<dim>;
  }
} // namespace emmy

#endif
