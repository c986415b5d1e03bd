#ifndef emmy_effects_pooled_stiffness_h
#define emmy_effects_pooled_stiffness_h

#include <emmy/effects/cell_matrix.h>

#include <vector>

namespace emmy
{
  /**
   * The derivative of the internal force of points whose groups are small and
   * overlap, as with GIMP, where every particle may have nodes of its own and
   * those of neighbours are almost the same: points that follow each other are
   * summed over the nodes of all of them, as long as these have room, before
   * they go to the matrix. Owned by who adds the force, for one matrix.
   *
   * Cost: as CellMatrix with all these nodes; nothing goes to the matrix for a
   * single point.
   */
  template <int dim>
  class PooledStiffness
  {
  public:
    PooledStiffness(const NodeGraph<dim> &graph, Matrix &matrix);

    /** @param nodes local indices of the group's nodes */
    void
    add(const unsigned int                     *nodes,
        const typename CellMatrix<dim>::Points &points);

    /** Hand over what is there; once after the last points. */
    void
    flush();

  private:
    /** Of the boxes of two cells' edge that particles of a cell's size reach.
     */
    static constexpr unsigned int most_nodes = dim == 2 ? 9 : 27;

    /** Make room for the nodes of a group, and find their indices. */
    void
    take_in(const unsigned int *nodes, const unsigned int n);
    /** The matrix of the points that wait, over the first so many nodes. */
    void
    work_off(const unsigned int n_nodes);

    const NodeGraph<dim>     &graph;
    Matrix                   &matrix;
    std::vector<unsigned int> members;
    /** Of each local node: its index among the members, or none. */
    std::vector<unsigned int> index_of;
    std::vector<unsigned int> indices; ///< of the nodes of a group
    /** Room for so many nodes, in full lanes. */
    unsigned int room = 0, n_padded = 0;
    bool         is_empty  = true; ///< the sum
    unsigned int n_waiting = 0;    ///< points

    // as CellMatrix has them, of the points that wait
    dealii::AlignedVector<double> slopes, products, sum;
    std::vector<double>           tangents, volumes;
  };
} // namespace emmy

#endif
