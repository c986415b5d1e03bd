#ifndef emmy_solve_mass_solver_h
#define emmy_solve_mass_solver_h

#include <emmy/solve/linear_solver.h>
#include <emmy/system/nodal_matrix.h>
#include <emmy/system/node_exchange.h>

#include <array>
#include <utility>
#include <vector>

namespace emmy
{
  /**
   * Solves C^T M C x = C^T b to round-off, with a mass M that is the same for
   * each component and the conditions C of its grid, by conjugate gradients
   * (Saad 2003, algorithm 9.1): all components at once, each with its own
   * lengths of steps, preconditioned with a symmetric sweep of Gauss and Seidel
   * over the rows of each rank. No second matrix is made.
   *
   * Made for a mass. Cost of an iteration: two passes over the matrix; a mass
   * with some particles for each node takes ten to twenty.
   */
  template <int dim>
  class MassSolver
  {
  public:
    /** What is done with the grid's conditions. */
    using Conditions = typename NodalMatrix<dim>::Conditions;

    /**
     * Collective.
     * @param mass    borrowed
     * @param damping this rank's share of what keeps the diagonal positive
     */
    MassSolver(const NodalMatrix<dim>    &mass,
               const std::vector<double> &damping,
               const Conditions           conditions);

    /**
     * From @p x on, which satisfies the conditions, until the residual falls
     * no more; keeps what M cannot see of it. Collective.
     * @return not solved: another solver is to be asked
     */
    LinearResult
    solve(Vector &x, const Vector &b) const;

  private:
    static constexpr unsigned int stride = NodalMatrix<dim>::stride;

    /** Of the local nodes, those of other ranks as they have them; see
     * NodalMatrix::stride. */
    using Values     = std::vector<double>;
    using Components = std::array<double, dim>;

    /** Where a local unknown stands. */
    static std::size_t
    at(const unsigned int unknown)
    {
      return stride * (unknown / dim) + unknown % dim;
    }
    /** In this order, and back. */
    static Values
    with_stride(const std::vector<double> &local);
    static std::vector<double>
    without_stride(const Values &values);

    bool
    is_free(const unsigned int unknown) const;
    /** Owners get the sums of what all ranks have. */
    void
    add_at_owners(Values &values) const;
    /** Others get what owners have. */
    void
    tell_others(Values &values) const;
    /** Of C^T M C with the damping. */
    void
    find_diagonal(const std::vector<double> &damping);
    /** Followers from their roots. */
    void
    expand(Values &values) const;
    /** C^T times forces, of owned nodes summed over the ranks. */
    void
    condense(Values &forces) const;
    /** b - M x, condensed; of owned nodes. */
    Values
    residual(const Values &x, const Values &b) const;
    /** a . b and a . c, by component. Collective. */
    std::pair<Components, Components>
    products(const Values &a, const Values &b, const Values &c) const;
    static double
    total(const Components &components);
    double
    norm(const Values &values) const;
    /**
     * Conjugate gradients from zero.
     * @param goal of the residual's norm
     * @return iterations; most + 1: it was not reached
     */
    unsigned int
    correct(Values            &x,
            Values             r,
            const double       goal,
            const unsigned int most) const;

    const NodalMatrix<dim> &mass;
    const NodeGraph<dim>   &graph;
    const Conditions        conditions;
    const NodeExchange      exchange;
    /** One over the diagonal, of owned nodes; zero for unknowns that are not
     * free. */
    Values inverse;
  };
} // namespace emmy

#endif
