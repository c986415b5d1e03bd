#ifndef emmy_solve_block_ilu_h
#define emmy_solve_block_ilu_h

#include <emmy/base/linear_algebra.h>

#include <array>
#include <vector>

namespace emmy
{
  /**
   * Incomplete LU factorisation without fill, ILU(0), of this rank's part of a
   * matrix (Saad 2003, Iterative methods for sparse linear systems, sec. 10.3),
   * in blocks of the unknowns of a node and in single precision. The matrix is
   * scaled with its diagonal from both sides first, so that nodes that hardly
   * any particle reaches are no matter of range.
   *
   * Cost: 4 n^2 bytes for a pair of nodes that meet; making it takes as long
   * as some five products, where Ifpack's takes thirty or more
   * (doc/performance.md).
   *
   * @tparam n unknowns per node
   */
  template <int n>
  class BlockIlu
  {
  public:
    void
    make(const Matrix &matrix);

    void
    vmult(Vector &z, const Vector &r) const;

    /** z += P r. */
    void
    vmult_add(Vector &z, const Vector &r) const;

  private:
    /** Column by column. */
    using Block = std::array<float, n * n>;

    /** The pattern of the blocks, and their scaled values. */
    void
    copy(const Matrix &matrix);
    void
    factorise();
    /** P r to work, in units of the scaled matrix and of the result. */
    double
    substitute(const Vector &r) const;

    /** Blocks of node i: [first[i], first[i + 1]), by their columns. */
    std::vector<unsigned int> first, diagonal, columns;
    /** L without its unit diagonal, the inverse of U's diagonal, U. */
    std::vector<Block>         blocks;
    std::vector<double>        scale;
    mutable std::vector<float> work;
  };
} // namespace emmy

#endif
