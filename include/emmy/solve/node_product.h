#ifndef emmy_solve_node_product_h
#define emmy_solve_node_product_h

#include <emmy/base/linear_algebra.h>
#include <emmy/system/node_exchange.h>

#include <memory>
#include <vector>

class Epetra_CrsGraph;

namespace emmy
{
  /**
   * Products with a matrix in blocks of the unknowns of a node. Values stay
   * where Trilinos has them; of the columns there is one index for a block, so
   * that 8.4 bytes are read for an entry in space, where Epetra reads 12, and a
   * register holds a row of a block. Neighbours exchange what they need, and no
   * rank waits for all.
   *
   * Matrices whose rows are not in such blocks get Epetra's product.
   *
   * Owned by a Krylov method. Cost: 4 bytes for a pair of nodes; indices are
   * made when the pattern of the matrix is another.
   */
  class NodeProduct
  {
  public:
    /** @param n_components unknowns of a node */
    explicit NodeProduct(const unsigned int n_components);
    ~NodeProduct();

    /** Borrow a matrix. Collective. */
    void
    set(const Matrix &matrix);

    /** Whether the rows of all ranks are in blocks. */
    bool
    is_in_blocks() const
    {
      return has_blocks;
    }

    /** y = A x. Collective. */
    void
    vmult(Vector &y, const Vector &x) const;

    /** r = b - A x. Collective. @return its norm */
    double
    residual(Vector &r, const Vector &x, const Vector &b) const;

  private:
    /** Whether all rows of this rank are in blocks; sets first, nodes. */
    bool
    find_blocks();
    /** As indices of own ones, then of others. */
    std::vector<unsigned int>
    nodes_of_columns() const;

    const unsigned int                     n;
    const Matrix                          *matrix = nullptr;
    std::unique_ptr<const Epetra_CrsGraph> graph;
    bool                                   has_blocks = false;
    unsigned int                           n_owned    = 0; ///< nodes
    std::vector<std::size_t>               first;
    std::vector<unsigned int>              nodes; ///< own ones, then others
    std::vector<const double *>            rows;  ///< by unknown
    NodeExchange                           exchange;
    /** Of x: own, others, and one more to read behind the last. */
    mutable std::vector<double> values;
  };
} // namespace emmy

#endif
