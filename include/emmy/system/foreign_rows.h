#ifndef emmy_system_foreign_rows_h
#define emmy_system_foreign_rows_h

#include <deal.II/base/index_set.h>

#include <emmy/base/linear_algebra.h>

#include <utility>
#include <vector>

namespace emmy
{
  /**
   * What this rank adds to rows of a matrix that other ranks own. It is summed
   * here, and handed to the owners at once: which entries these are is told
   * once, so that a message of numbers remains for each rank that owns some.
   *
   * Owned by NodeGraph. Cost: 8 dim^2 bytes for a pair of nodes of which the
   * first is another rank's.
   */
  template <int dim>
  class ForeignRows
  {
  public:
    /** A row of an owned node, to which another rank adds. */
    struct RowOfOthers
    {
      unsigned int node; ///< local index
      /** Its first unknowns in the columns, as indices of all ranks. */
      std::vector<dealii::types::global_dof_index> columns;
      /** Where these stand in the row, in nodes. */
      std::vector<unsigned int> places;
    };

    /**
     * Once. Collective.
     * @param first_dofs of each local node; owned nodes come first, the others
     *   in their order
     * @param owned_dofs  of this rank, without gaps
     * @param first, neighbours of node i: neighbours[first[i]] to
     *   neighbours[first[i + 1]]
     */
    void
    make(const std::vector<dealii::types::global_dof_index> &first_dofs,
         const dealii::IndexSet                             &owned_dofs,
         const std::vector<std::size_t>                     &first,
         const std::vector<unsigned int>                    &neighbours,
         const MPI_Comm                                      communicator);

    /** The rows to which others add. */
    const std::vector<RowOfOthers> &
    rows_of_others() const
    {
      return others;
    }
    /** Say where the columns of one of them stand. */
    void
    set_places(const std::size_t row, std::vector<unsigned int> places)
    {
      others[row].places = std::move(places);
    }

    /**
     * What is summed for component c of a node of another rank; of its
     * neighbours in their order, dim numbers for each.
     */
    double *
    row(const unsigned int node, const unsigned int c) const
    {
      const std::size_t n =
        dim * (offsets[node - n_owned + 1] - offsets[node - n_owned]);
      return values.data() + dim * dim * offsets[node - n_owned] + c * n;
    }

    /** Add all to the rows of their owners, and begin with zeros. Collective.
     */
    void
    hand_over(Matrix &matrix) const;

  private:
    /** Pairs of nodes that go to a rank, or come from one, in a row. */
    struct Message
    {
      unsigned int rank;
      std::size_t  first, n; ///< pairs
    };

    MPI_Comm     communicator = MPI_COMM_NULL;
    unsigned int n_owned      = 0;
    /** Of the nodes of other ranks: the first pair. */
    std::vector<std::size_t>    offsets;
    std::vector<Message>        outgoing, incoming;
    std::vector<RowOfOthers>    others; ///< in the order of incoming
    mutable std::vector<double> values, received;
  };
} // namespace emmy

#endif
