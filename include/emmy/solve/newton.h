#ifndef emmy_solve_newton_h
#define emmy_solve_newton_h

#include <emmy/assembly/nonlinear_equation.h>
#include <emmy/base/phases.h>
#include <emmy/solve/linear_solver.h>

#include <string>
#include <vector>

namespace emmy
{
  /** How Newton ended. */
  struct NewtonResult
  {
    bool         is_converged      = false;
    unsigned int iterations        = 0;
    unsigned int linear_iterations = 0;
    /** sum |r||du| of each iteration (Pretti et al. 2023, sec. 3.4). */
    std::vector<double> work_history;
    /** |r| before the first and after each iteration. */
    std::vector<double> residual_history;
    /** Why it did not converge, in words; the same on all ranks. */
    std::string problem;
  };

  /**
   * Newton's method on a NonlinearEquation. Converged when sum |r||du|, with r
   * after the increment, has fallen to the tolerance times its first value
   * (that with r before the first increment, if smaller), or |r| to 1e-12 of
   * the forces that balance in it and its work to round-off (free flight,
   * rest). An increment that leaves the equation without meaning is halved, at
   * most six times. Made by the step for each attempt.
   */
  class Newton
  {
  public:
    Newton(const SolverParameters &parameters,
           LinearSolver           &linear_solver,
           Phases                 &phases);

    /**
     * Solve in place, starting from @p solution, which satisfies the
     * constraints. On success the equation was last evaluated at the
     * solution. Collective.
     */
    NewtonResult
    solve(NonlinearEquation &equation, Vector &solution) const;

  private:
    const double       tolerance, linear_tolerance;
    const unsigned int maximum_iterations;
    LinearSolver      &linear_solver;
    Phases            &phases;
  };
} // namespace emmy

#endif
