#ifndef emmy_solve_newton_h
#define emmy_solve_newton_h

#include <emmy/base/phases.h>
#include <emmy/solve/linear_solver.h>
#include <emmy/solve/nonlinear_equation.h>

#include <string>
#include <vector>

namespace emmy
{
  /** How Newton ended. */
  struct NewtonResult
  {
    bool         is_converged      = false; ///< to its tolerance
    unsigned int iterations        = 0;     ///< of both tries
    unsigned int linear_iterations = 0;     ///< over all iterations
    /** sum |r||du| of each iteration (Pretti et al. 2023, sec. 3.4). */
    std::vector<double> work_history;
    /** |r| before the first and after each iteration that was kept. */
    std::vector<double> residual_history;
    /** Whether the plain try failed and the damped one took over. */
    bool is_damped = false;
    /** Whether a rest was left that could not be lowered and does not matter.
     */
    bool leaves_rest = false;
    /** Why the plain try failed, if it did. */
    std::string first_try;
    /** Why it did not converge, in words; the same on all ranks. */
    std::string problem;
  };

  /**
   * Newton's method on a NonlinearEquation, with two tries.
   *
   * The plain try is converged when sum |r||du|, with r after the increment,
   * has fallen to the tolerance times its first value (that with r before the
   * first increment, if smaller), or |r| to 1e-12 of the forces that balance
   * in it and its work to round-off (free flight, rest). It never iterates on
   * round-off: when an increment that is small enough to be linear, with
   * displacement gradients below 1e-4, has not halved |r|, what is left is
   * the round-off of the evaluation, and it is content if |r| is below 1e-8
   * of the forces and its work below 1e-8 of theirs. An increment whose
   * size() is above 0.3 is found again with a more strongly damped matrix; one
   * that leaves the equation without meaning is halved, at most six times.
   *
   * If it fails, the matrix is most often singular: a particle alone among new
   * nodes has no stress, and then nothing resists its rotation but a torque
   * that hardly depends on it. The damped try adds mu times its diagonal to
   * the matrix, and adapts mu as Levenberg and Marquardt do: less after an
   * increment that lowers the residual, scaled with the diagonal; more, and
   * the increment is taken back, otherwise. This does not change where it
   * converges to. It is also content when that scaled residual no longer
   * falls, with |r| below 1e-8 of the forces and its work below 1e-8 of
   * theirs: what is left belongs to the free rotation, and the ledger books
   * its work.
   *
   * Made by the step for each attempt.
   */
  class Newton
  {
  public:
    /** With a solver for its linear systems. */
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
    class Iteration;

    void
    plain(Iteration &iteration) const;
    void
    damped(Iteration &iteration) const;

    const double       tolerance, linear_tolerance;
    const unsigned int maximum_iterations;
    LinearSolver      &linear_solver;
    Phases            &phases;
  };
} // namespace emmy

#endif
