#ifndef emmy_solve_overlap_rows_h
#define emmy_solve_overlap_rows_h

#include <emmy/base/linear_algebra.h>
#include <emmy/system/node_exchange.h>

#include <Epetra_CrsMatrix.h>

#include <map>
#include <memory>
#include <vector>

namespace emmy
{
  /**
   * The rows of this rank's nodes between those of the nodes of others that
   * they meet, all in the order of the whole matrix. Columns are counted
   * likewise; those further away are left out.
   *
   * Owned by BlockIlu. Which entries the rows of others have is told when the
   * pattern is another; each matrix after that takes a message of numbers.
   *
   * @tparam n unknowns per node
   */
  template <int n>
  class OverlapRows
  {
  public:
    /**
     * Borrow a matrix. Collective.
     * @return whether its pattern is another than before
     */
    bool
    read(const Matrix &matrix);

    /** The first of this rank's unknowns. */
    unsigned int
    begin() const
    {
      return first_own;
    }
    /** One past the last. */
    unsigned int
    end() const
    {
      return first_own + n_own;
    }
    /** With those of others. */
    unsigned int
    n_nodes() const
    {
      return (n_own + n_others) / n;
    }

    /** Calls entry(column, value) for those of the unknown i. */
    template <typename Entry>
    void
    for_each(const unsigned int i, const Entry &entry) const
    {
      if (i >= begin() && i < end())
        {
          int     length, *in_row;
          double *of_row;
          entries->ExtractMyRowView(i - begin(), length, of_row, in_row);
          for (int k = 0; k < length; ++k)
            if (column[in_row[k]] != none)
              entry(column[in_row[k]], of_row[k]);
          return;
        }
      const unsigned int other = i < begin() ? i : i - n_own;
      for (std::size_t k = first[other]; k < first[other + 1]; ++k)
        if (other_columns[k] != none)
          entry(other_columns[k], values[k]);
    }

    /** Whether an unknown of a node meets those that the one before it meets.
     */
    bool
    is_like_last(const unsigned int i) const
    {
      return like_last[i] != 0;
    }

    /** Zero if it has none. */
    double
    diagonal(const unsigned int i) const
    {
      if (diagonals[i] == nowhere)
        return 0.;
      const bool is_own = i >= begin() && i < end();
      return is_own ? (*entries)[i - begin()][diagonals[i]]
                    : values[diagonals[i]];
    }

    /**
     * Entries of a vector at the unknowns of others, first those below
     * begin(), then those from end() on. Neighbours call it too.
     */
    const std::vector<double> &
    of_others(const Vector &vector) const;

  private:
    static constexpr unsigned int none = dealii::numbers::invalid_unsigned_int;
    static constexpr std::size_t  nowhere = static_cast<std::size_t>(-1);

    /** The nodes of others, and with whom they are exchanged. */
    std::vector<dealii::types::global_dof_index>
    meet(const Matrix &matrix);
    void
    find_diagonals();
    /** Whether an own row has the columns of the one before, of the same node.
     */
    bool
    is_repeated(const unsigned int row) const;
    /** What each neighbour gets of own rows: what() of an unknown. */
    template <class Number, class What>
    std::vector<Number>
    hand_over(const What &what) const;

    const Epetra_CrsMatrix                *entries      = nullptr;
    MPI_Comm                               communicator = MPI_COMM_SELF;
    std::unique_ptr<const Epetra_CrsGraph> graph;
    NodeExchange                           exchange;
    unsigned int              first_own = 0, n_own = 0, n_others = 0;
    std::vector<unsigned int> column; ///< of a column of the matrix
    /** Of the rows of others, from [first[i]] to [first[i + 1]]. */
    std::vector<std::size_t>    first;
    std::vector<unsigned int>   other_columns;
    std::vector<double>         values;
    std::vector<std::size_t>    diagonals; ///< where in the row, or in values
    std::vector<char>           like_last;
    mutable std::vector<double> from_others;
  };
} // namespace emmy

#endif
