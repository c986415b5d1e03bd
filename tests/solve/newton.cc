// Newton: an increment that is large because the body moves is taken, with two
// solves; one that is large because a direction is nearly singular is damped,
// as little as it takes. Where it ends is the same.

#include <deal.II/lac/trilinos_sparsity_pattern.h>

#include <emmy/base/phases.h>
#include <emmy/solve/newton.h>

#include <cmath>

#include "../check.h"

using namespace emmy;
using test::check;
using test::check_close;

namespace
{
  const MPI_Comm world = MPI_COMM_WORLD;

  /** K (u - goal) = 0 of two unknowns, K = {{1, k}, {k, 1}}. */
  class Linear : public NonlinearEquation
  {
  public:
    Linear(const double k, const double first, const double second)
      : k(k)
      , goal(make_vector())
      , residual(make_vector())
    {
      goal(0) = first;
      goal(1) = second;
      goal.compress(dealii::VectorOperation::insert);
      dealii::TrilinosWrappers::SparsityPattern pattern(rows(), world);
      for (unsigned int i = 0; i < 2; ++i)
        for (unsigned int j = 0; j < 2; ++j)
          pattern.add(i, j);
      pattern.compress();
      jacobian.reinit(pattern);
    }

    static Vector
    make_vector()
    {
      return Vector(rows(), world);
    }

    bool
    evaluate(const Vector &solution, const bool) override
    {
      for (unsigned int i = 0; i < 2; ++i)
        for (unsigned int j = 0; j < 2; ++j)
          jacobian.set(i, j, i == j ? 1. : k);
      jacobian.compress(dealii::VectorOperation::insert);
      Vector rest = solution;
      rest -= goal;
      jacobian.vmult(residual, rest);
      return true;
    }

    NewtonSystem
    system() override
    {
      return {residual, residual, jacobian, none, 1., 1., nullptr};
    }

    void
    expand(Vector &) const override
    {}

    double
    size(const Vector &increment) const override
    {
      ++n_sizes;
      return increment.linfty_norm();
    }

    void
    take(Vector &solution, Vector &increment) override
    {
      taken.push_back(increment.linfty_norm());
      if (taken.size() == 1)
        n_tries = n_sizes;
      solution += increment;
    }

    const std::string &
    problem() const override
    {
      return text;
    }

    const double         k;
    Vector               goal;
    std::vector<double>  taken; ///< sizes of increments
    mutable unsigned int n_sizes = 0;
    unsigned int         n_tries = 0; ///< before the first is taken

  private:
    static dealii::IndexSet
    rows()
    {
      return dealii::complete_index_set(2);
    }

    Vector                     residual;
    Matrix                     jacobian;
    const std::vector<RankOne> none;
    const std::string          text;
  };

  NewtonResult
  solve(Linear &equation, const double accuracy = 1e-9)
  {
    const SolverParameters parameters;
    const auto             solver = make_linear_solver(parameters, 2, 2);
    Phases                 phases(world);
    Vector                 solution = Linear::make_vector();
    const NewtonResult     result =
      Newton(parameters, *solver, phases).solve(equation, solution);
    solution -= equation.goal;
    check(result.is_converged && !result.is_damped, "the plain try ends");
    check_close(solution.linfty_norm(),
                0.,
                accuracy,
                "where the equation says");
    return result;
  }

  void
  a_body_that_moves()
  {
    for (const double far : {0.31, 0.5, 0.99})
      {
        Linear equation(0.5, far, -0.2);
        solve(equation);
        check_close(equation.taken.front() / far,
                    1.,
                    1e-5,
                    "all of a motion is taken at once");
        check(equation.n_tries == 2, "with two solves");
      }
    Linear too_far(0.5, 1.2, -0.2);
    solve(too_far);
    check(too_far.taken.front() < 1., "but not beyond one");
  }

  void
  a_singular_direction()
  {
    // the difference of the unknowns is held by 1e-9 of the diagonal only
    Linear equation(1. - 1e-9, 0.5, -0.5);
    solve(equation, 1e-4); // round-off by the condition
    // damped by 1e-10 it is 0.45, by 1e-8 this, by 1e-6 a hundredth of it
    check_close(equation.taken.front(),
                0.5 / 11.,
                1e-4,
                "damped until it is below 0.3, no more");
  }

  void
  a_small_increment()
  {
    Linear equation(0.5, 0.29, 0.1);
    solve(equation);
    check_close(equation.taken.front(), 0.29, 1e-9, "a small one is Newton's");
    check(equation.n_tries == 1, "and one solve's");
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  a_body_that_moves();
  a_singular_direction();
  a_small_increment();
  return test::report();
}
