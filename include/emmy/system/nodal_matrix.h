#ifndef emmy_system_nodal_matrix_h
#define emmy_system_nodal_matrix_h

#include <emmy/system/active_grid.h>

#include <memory>
#include <vector>

namespace emmy
{
  /**
   * A symmetric matrix that is the same for each component of the unknowns and
   * joins none of them, as a mass: a number for each pair of nodes that meet.
   * It knows no conditions. Each rank has the share of its particles, which
   * products sum.
   *
   * Cost: 8 bytes for a pair of nodes, where a matrix of all unknowns has
   * 8 dim^2; a product acts on all components at once.
   */
  template <int dim>
  class NodalMatrix
  {
  public:
    /** What is done with the grid's conditions. */
    using Conditions = typename NodeGraph<dim>::Conditions;

    /** Zero, on the nodes of a grid with matrices. */
    void
    reinit(const std::shared_ptr<const ActiveGrid<dim>> &active);

    /** Add a matrix of some nodes that meet; local indices. */
    void
    add(const unsigned int *nodes, const dealii::FullMatrix<double> &block);

    /** Whose nodes it has. */
    const ActiveGrid<dim> &
    grid() const
    {
      return *active;
    }

    /** This rank's share for a pair, by its index in NodeGraph::Row. */
    double
    operator[](const std::size_t pair) const
    {
      return values[pair];
    }
    /** This rank's share on the diagonal of a local node. */
    double
    diagonal(const unsigned int node) const
    {
      return values[diagonals[node]];
    }

    /** This rank's share of A v at the local nodes is added to a result. */
    void
    add_times(const std::vector<double> &v, std::vector<double> &result) const;

    /** Numbers of a node in the arrays of the two functions that follow:
     * those of its components, and zeros. */
    static constexpr unsigned int stride = dim == 2 ? 2 : 4;

    /** This rank's share of A x at the local nodes. */
    void
    multiply(const std::vector<double> &x, std::vector<double> &result) const;
    /**
     * A symmetric sweep of Gauss and Seidel over the owned nodes, from zero.
     * @param inverse one over the diagonal; zero where the result is zero
     */
    void
    sweep(const std::vector<double> &inverse,
          const std::vector<double> &r,
          std::vector<double>       &result) const;

    /** A v. Collective. */
    void
    vmult(Vector &result, const Vector &v) const;
    /** r = b - A v. Collective. @return its norm */
    double
    residual(Vector &r, const Vector &v, const Vector &b) const;
    /** v . A v. Collective. */
    double
    matrix_norm_square(const Vector &v) const;

    /**
     * Add a multiple to a matrix of all unknowns, before NodeGraph::finish().
     * @param damping this rank's share of what comes to the diagonal, by local
     *   node; empty: nothing
     */
    void
    add_to(Matrix                    &matrix,
           const double               factor,
           const Conditions           conditions,
           const std::vector<double> &damping = {}) const;

  private:
    /** Values of the unknowns of a row, in the order of its nodes. */
    using RowValues = std::vector<double>;

    void
    add_row(Matrix            &matrix,
            const unsigned int node,
            const RowValues   &row,
            const Conditions   conditions) const;
    void
    add_row_with_conditions(Matrix            &matrix,
                            const unsigned int node,
                            const RowValues   &row,
                            const unsigned int component) const;

    std::shared_ptr<const ActiveGrid<dim>> active;
    std::vector<double>                    values;
    std::vector<std::size_t>               diagonals; ///< by local node
    /** By local node: where it stands in a row, and in which that is. */
    mutable std::vector<std::size_t> place_of_node;
    std::vector<unsigned int>        marked_by;
  };
} // namespace emmy

#endif
