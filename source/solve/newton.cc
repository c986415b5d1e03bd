#include <emmy/base/text.h>
#include <emmy/solve/newton.h>

#include <limits>

namespace emmy
{
  namespace
  {
    /** |r| below this fraction of the forces is round-off, ... */
    constexpr double force_round_off = 1e-12;
    /** ... and if its work is so too, there is nothing left to gain. */
    constexpr double work_round_off = 1e-13;
  } // namespace

  Newton::Newton(const SolverParameters &parameters,
                 LinearSolver           &linear_solver,
                 Phases                 &phases)
    : tolerance(parameters.newton_tolerance)
    , linear_tolerance(parameters.linear_tolerance)
    , maximum_iterations(parameters.maximum_iterations)
    , linear_solver(linear_solver)
    , phases(phases)
  {
    parameters.validate();
  }

  NewtonResult
  Newton::solve(NonlinearEquation &equation, Vector &solution) const
  {
    NewtonResult result;
    const auto   evaluate = [&] {
      const auto scope = phases.scope("residual and tangent");
      return equation.evaluate(solution, /*with_jacobian=*/true);
    };
    if (!evaluate())
      {
        result.problem = equation.problem();
        return result;
      }
    double norm = equation.residual().l2_norm();
    result.residual_history.push_back(norm);
    // At nodes that few particles reach, small forces can do much work: go on
    // as long as the residual falls.
    const auto is_round_off = [&](const double norm_before) {
      return norm <= force_round_off * equation.scale() &&
             (norm > 0.5 * norm_before ||
              absolute_product(equation.residual(), solution) <=
                work_round_off * equation.work_scale());
    };
    if (is_round_off(std::numeric_limits<double>::max()))
      {
        result.is_converged = true;
        return result;
      }

    Vector increment(solution), right_side(solution);
    double reference = 0.; // for sum |r||du|
    while (result.iterations < maximum_iterations)
      {
        right_side.equ(-1., equation.residual());
        {
          const auto   scope = phases.scope("linear solve");
          LinearResult solve = linear_solver.prepare(equation.jacobian());
          if (solve.is_solved)
            solve =
              linear_solver.solve(increment, right_side, linear_tolerance);
          result.linear_iterations += solve.iterations;
          if (!solve.is_solved)
            {
              result.problem = "linear solver: " + solve.problem;
              return result;
            }
        }
        ++result.iterations;

        // The first increment may be wild at nodes that few particles reach;
        // then the first |r||du| of the paper is no measure, but this is.
        if (result.iterations == 1)
          reference = absolute_product(right_side, increment);

        solution += increment;
        bool has_meaning = evaluate();
        for (unsigned int halving = 0; !has_meaning && halving < 6; ++halving)
          {
            increment *= 0.5;
            solution -= increment;
            has_meaning = evaluate();
          }
        if (!has_meaning)
          {
            result.problem = equation.problem();
            return result;
          }

        const double norm_before = norm;
        norm                     = equation.residual().l2_norm();
        result.residual_history.push_back(norm);
        result.work_history.push_back(
          absolute_product(equation.residual(), increment));
        reference         = std::min(reference, result.work_history.front());
        const double work = result.work_history.back();
        if (work < tolerance * reference || is_round_off(norm_before))
          {
            result.is_converged = true;
            return result;
          }
      }
    result.problem = "not converged in " + std::to_string(maximum_iterations) +
                     " iterations; |r| went from " +
                     brief(result.residual_history.front()) + " to " +
                     brief(norm) + " N";
    return result;
  }
} // namespace emmy
