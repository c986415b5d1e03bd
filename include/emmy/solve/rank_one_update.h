#ifndef emmy_solve_rank_one_update_h
#define emmy_solve_rank_one_update_h

#include <emmy/solve/linear_solver.h>
#include <emmy/system/rank_one.h>

namespace emmy
{
  /**
   * From the solution of A x = b make that of (A + sum column row^T) x = b
   * (Sherman and Morrison 1950; Woodbury): with A Y = columns,
   * @f[ x \leftarrow x - Y (I + R Y)^{-1} R x . @f]
   * Cost: one solve for each term. Collective.
   *
   * @param solver that A is prepared in
   */
  LinearResult
  update_by_rank_ones(LinearSolver               &solver,
                      const std::vector<RankOne> &terms,
                      Vector                     &x);
} // namespace emmy

#endif
