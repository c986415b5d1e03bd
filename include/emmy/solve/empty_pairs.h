#ifndef emmy_solve_empty_pairs_h
#define emmy_solve_empty_pairs_h

#include <emmy/base/linear_algebra.h>

#include <Epetra_CrsGraph.h>

#include <array>
#include <memory>
#include <vector>

namespace emmy
{
  /**
   * Matrices without the pairs of nodes whose entries are all zero: of nodes
   * that follow others, of bodies that only nearly touch, and of contact in the
   * mass. LU fills in between them as if they were not. The diagonal stays.
   *
   * Owned by a solver. Cost: a pass over the matrix; where other pairs are
   * empty than in the last two matrices, a pattern.
   */
  class WithoutEmptyPairs
  {
  public:
    /**
     * @param n_components unknowns of a node. All its rows have the same
     *   pattern, with the columns of a node side by side: see NodeGraph.
     */
    explicit WithoutEmptyPairs(const unsigned int n_components);

    /** Valid until the next but one is asked for. Collective. */
    const Matrix &
    operator()(const Matrix &matrix);

  private:
    struct Reduced
    {
      Epetra_CrsGraph all; ///< of the matrix
      /** By pair of nodes of that, row by row. */
      std::vector<char> is_kept;
      Matrix            matrix;
    };

    template <int n>
    void
    find_kept(const Epetra_CrsMatrix &matrix);
    std::unique_ptr<Reduced>
    made(const Epetra_CrsMatrix &matrix) const;
    template <int n>
    void
    copy(const Epetra_CrsMatrix &matrix, Reduced &result) const;

    const int         n;
    std::vector<char> is_kept; ///< in the matrix that is looked at
    /** The latest first. */
    std::array<std::unique_ptr<Reduced>, 2> last;
  };
} // namespace emmy

#endif
