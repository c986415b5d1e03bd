#ifndef emmy_solve_gmres_h
#define emmy_solve_gmres_h

#include <emmy/solve/node_product.h>
#include <emmy/solve/preconditioner.h>

#include <vector>

namespace emmy
{
  /**
   * GMRES with a preconditioner on the right, restarted: Saad, Iterative
   * methods for sparse linear systems (2003), algorithms 6.9, 6.11 and 9.5.
   * Vectors are made orthogonal by the classical method of Gram and Schmidt,
   * a second time where little of one is left, so that an iteration waits for
   * all ranks once (twice), however many vectors there are: dealii::SolverGMRES
   * does it for each of them, and makes maps of a new vector by six collective
   * calls more.
   *
   * Made for each solve; keeps the vectors of one. Cost of an iteration: a
   * product, a preconditioner, and passes over the vectors so far.
   */
  class Gmres
  {
  public:
    /** Borrows both. @param restart how many vectors are kept */
    Gmres(const NodeProduct    &matrix,
          const Preconditioner &preconditioner,
          const unsigned int    restart)
      : matrix(matrix)
      , preconditioner(preconditioner)
      , restart(restart)
    {}

    /**
     * From x = 0, until the residual that the method knows of is at most
     * @p goal, which the true one may exceed by round-off. Collective.
     * @return whether it was reached
     */
    bool
    solve(Vector            &x,
          const Vector      &b,
          const double       goal,
          const unsigned int most);

    /** Of the last solve. */
    unsigned int
    iterations() const
    {
      return n_iterations;
    }

    /** Whether numbers that are not finite ended it. */
    bool
    is_broken() const
    {
      return broken;
    }

  private:
    /** One start: adds to x. @return the norm of the residual it knows of */
    double
    run(Vector &x, Vector &residual, const double norm, const double goal);
    /**
     * Take from w what it has of the vectors so far.
     * @return their amounts, and the norm of the rest behind them
     */
    std::vector<double>
    take_out(Vector &w) const;
    /** x += M^-1 sum y_j v_j */
    void
    add_combination(const std::vector<double> &y, Vector &x);

    const NodeProduct               &matrix;
    const Preconditioner            &preconditioner;
    const unsigned int               restart;
    std::vector<std::vector<double>> vectors; ///< of this rank
    unsigned int                     n_vectors = 0, n_iterations = 0, most = 0;
    bool                             broken = false;
  };
} // namespace emmy

#endif
