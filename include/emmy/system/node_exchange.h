#ifndef emmy_system_node_exchange_h
#define emmy_system_node_exchange_h

#include <deal.II/base/partitioner.h>

#include <vector>

namespace emmy
{
  /**
   * Numbers at nodes, between the ranks that own them and those that know them:
   * a message for each neighbour, and no rank waits for any other. Only what
   * neighbours want is copied.
   *
   * Values are arrays of n numbers for each node: of those that this rank owns,
   * and of the others that it knows, in the order of all nodes.
   */
  class NodeExchange
  {
  public:
    /** A rank with which nodes are in common. */
    struct Neighbour
    {
      unsigned int rank; ///< its number
      /** Of the others that this rank knows, these are its. */
      unsigned int first, end;
      /** Own nodes that it knows. */
      std::vector<unsigned int> own;
    };

    /** With none. */
    NodeExchange() = default;
    /** As the nodes are parted. No rank waits. */
    explicit NodeExchange(const dealii::Utilities::MPI::Partitioner &nodes);

    /** All of them. */
    const std::vector<Neighbour> &
    neighbours() const
    {
      return all;
    }

    /** Others get the values of their owners. Neighbours call it too. */
    void
    update(const double *own, const unsigned int n, double *others) const;

    /** Owners get the sums of what all ranks have. Neighbours call it too. */
    void
    add(double *own, const unsigned int n, const double *others) const;

  private:
    /** Between the others' numbers and those of own nodes, in work. */
    void
    exchange(const unsigned int n, const bool to_owners, double *others) const;

    MPI_Comm                         communicator = MPI_COMM_SELF;
    std::vector<Neighbour>           all;
    mutable std::vector<double>      work;
    mutable std::vector<MPI_Request> requests;
  };
} // namespace emmy

#endif
