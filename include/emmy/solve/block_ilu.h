#ifndef emmy_solve_block_ilu_h
#define emmy_solve_block_ilu_h

#include <emmy/base/linear_algebra.h>

#include <array>
#include <memory>
#include <vector>

namespace emmy
{
  template <int n>
  class OverlapRows;

  /**
   * Incomplete LU factorisation without fill, ILU(0), of this rank's part of a
   * matrix (Saad 2003, Iterative methods for sparse linear systems, sec. 10.3),
   * in blocks of the unknowns of a node and in single precision. The matrix is
   * scaled with its diagonal from both sides first, so that nodes that hardly
   * any particle reaches are no matter of range.
   *
   * With several ranks, the part of each is wider by the nodes of others that
   * its own meet; what comes out for those is dropped (restricted additive
   * Schwarz, Cai and Sarkis 1999, SIAM J. Sci. Comput. 21, 792). So ranks cost
   * next to no iterations, for one more exchange of a layer of nodes in each.
   *
   * Cost: 4 n^2 bytes for a pair of nodes that meet; making it takes as many
   * instructions as some sixty substitutions, a third of them for the pattern
   * if that is another (doc/performance.md).
   *
   * @tparam n unknowns per node
   */
  template <int n>
  class BlockIlu
  {
  public:
    BlockIlu();
    ~BlockIlu();

    /** Factorise. Keeps the pattern, for the next matrix with the same. */
    void
    make(const Matrix &matrix);

    /** z = P r. */
    void
    vmult(Vector &z, const Vector &r) const;

    /** z += P r. */
    void
    vmult_add(Vector &z, const Vector &r) const;

  private:
    /** Column by column. */
    using Block = std::array<float, n * n>;

    /** Which blocks there are. */
    void
    find_pattern();
    /** Their scaled values. */
    void
    copy();
    /** The arrays of L and U, from the rows of the whole. */
    void
    arrange(const std::vector<unsigned int> &first,
            const std::vector<unsigned int> &pattern);
    void
    factorise();
    /** P r to work, in units of the scaled matrix and of the result. */
    double
    substitute(const Vector &r) const;

    /** Where the row of U of a node ends. */
    unsigned int
    upper_end(const unsigned int node) const
    {
      return node > 0 ? upper[node - 1] : columns.size();
    }

    /**
     * The rows of L, less the unit diagonal, from lower[i] to lower[i + 1].
     * Behind them those of U, from the last one to the first, as they are
     * needed: from upper[i] on, with the inverse of the diagonal before the
     * others.
     */
    std::vector<unsigned int>  lower, upper, columns;
    std::vector<Block>         blocks;
    std::vector<double>        scale;
    mutable std::vector<float> work;

    std::unique_ptr<OverlapRows<n>> rows;
  };
} // namespace emmy

#endif
