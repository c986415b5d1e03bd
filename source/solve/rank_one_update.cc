#include <deal.II/lac/full_matrix.h>

#include <emmy/solve/rank_one_update.h>

namespace emmy
{
  LinearResult
  update_by_rank_ones(LinearSolver               &solver,
                      const std::vector<RankOne> &terms,
                      Vector                     &x)
  {
    // A and its update may nearly cancel
    constexpr double tolerance = 1e-10;

    LinearResult result;
    if (terms.empty())
      return result;
    std::vector<Vector> Y;
    for (const RankOne &term : terms)
      {
        Y.emplace_back(term.column);
        Y.back() = 0.;
        const LinearResult solve =
          solver.solve(Y.back(), term.column, tolerance);
        result.iterations += solve.iterations;
        if (!solve.is_solved)
          {
            result.is_solved = false;
            result.problem   = solve.problem;
            return result;
          }
      }
    const unsigned int         n = terms.size();
    dealii::FullMatrix<double> small(n, n);
    dealii::Vector<double>     along(n), shares(n);
    for (unsigned int i = 0; i < n; ++i)
      {
        along(i) = terms[i].row * x;
        for (unsigned int j = 0; j < n; ++j)
          small(i, j) = (i == j ? 1. : 0.) + terms[i].row * Y[j];
      }
    small.gauss_jordan();
    small.vmult(shares, along);
    for (unsigned int i = 0; i < n; ++i)
      x.add(-shares(i), Y[i]);
    return result;
  }
} // namespace emmy
