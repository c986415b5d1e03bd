#include <emmy/base/text.h>
#include <emmy/solve/newton.h>
#include <emmy/solve/rank_one_update.h>

#include <Epetra_CrsMatrix.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

namespace emmy
{
  namespace
  {
    /** |r| below this fraction of the forces is round-off, ... */
    constexpr double force_round_off = 1e-12;
    /** ... and if its work is so too, there is nothing left to gain. */
    constexpr double work_round_off = 1e-13;

    /** What the damped try may leave, of forces and of works. */
    constexpr double singular_tolerance = 1e-8;

    /**
     * An increment with displacement gradients below this is linear to as many
     * digits; it lowers |r| as much, unless that is round-off.
     */
    constexpr double linear_size = 1e-4;
    /** Below this they are round-off, whatever is left of |r|. */
    constexpr double smallest_size = 1e-14;

    /** The largest change of a displacement gradient in one increment. */
    constexpr double largest_size = 0.3;

    /**
     * The least damping, of both tries. A node that few particles reach can
     * have directions that neither inertia nor stress resists beyond
     * round-off; this keeps increments there finite.
     */
    constexpr double least_damping = 1e-12;
    /** Where the damped try starts. */
    constexpr double first_damping = 1e-5;

    /** Where the diagonal stands in this rank's rows: looked for once. */
    class Diagonal
    {
    public:
      /** Calls use(entry) for each of its entries. */
      template <class Use>
      void
      for_each(const Matrix &matrix, const Use &use)
      {
        const Epetra_CrsMatrix &entries = matrix.trilinos_matrix();
        if (!graph || graph->DataPtr() != entries.Graph().DataPtr())
          find(entries);
        for (std::size_t row = 0; row < places.size(); ++row)
          use(entries[row][places[row]]);
      }

      /** The sizes of its entries. */
      Vector
      sizes(const Matrix &matrix, const Vector &like)
      {
        Vector result = like;
        auto   entry  = result.begin();
        for_each(matrix,
                 [&entry](const double value) { *entry++ = std::abs(value); });
        return result;
      }

      /** Raise it by a fraction. */
      void
      damp(const double mu, Matrix &matrix)
      {
        for_each(matrix,
                 [mu](double &value) { value += mu * std::abs(value); });
      }

    private:
      void
      find(const Epetra_CrsMatrix &entries)
      {
        // a copy shares what it has: no other pattern can have its place
        graph = std::make_unique<const Epetra_CrsGraph>(entries.Graph());
        places.clear();
        for (int row = 0; row < graph->NumMyRows(); ++row)
          {
            int length, *columns;
            graph->ExtractMyRowView(row, length, columns);
            int *const end = columns + length;
            int *const place =
              std::find(columns,
                        end,
                        graph->ColMap().LID(graph->RowMap().GID(row)));
            AssertThrow(place != end,
                        dealii::ExcMessage("A row has no diagonal."));
            places.push_back(place - columns);
          }
      }

      std::unique_ptr<const Epetra_CrsGraph> graph;
      std::vector<int>                       places;
    };

    /** sqrt(sum r_i^2 / d_i): every node counts alike. Collective. */
    double
    scaled_norm(const Vector &r, const Vector &diagonal)
    {
      double sum   = 0.;
      auto   entry = diagonal.begin();
      for (auto r_i = r.begin(); r_i != r.end(); ++r_i, ++entry)
        sum += *r_i == 0. ? 0. : *r_i * *r_i / *entry;
      return std::sqrt(
        dealii::Utilities::MPI::sum(sum, r.get_mpi_communicator()));
    }
  } // namespace

  /** One try: where it stands and what it did. */
  class Newton::Iteration
  {
  public:
    Iteration(const Newton      &newton,
              NonlinearEquation &equation,
              Vector            &solution)
      : newton(newton)
      , equation(equation)
      , solution(solution)
      , increment(solution)
      , right_side(solution)
    {}

    /** Evaluate the equation; false if it has no meaning there. */
    bool
    evaluate(const bool with_jacobian = true)
    {
      const auto scope = newton.phases.scope("residual and tangent");
      has_jacobian     = with_jacobian;
      return equation.evaluate(solution, with_jacobian);
    }

    /** The first evaluation; true if there is something to solve. */
    bool
    begin()
    {
      if (!evaluate())
        {
          result.problem = equation.problem();
          return false;
        }
      norm = equation.system().residual.l2_norm();
      result.residual_history.push_back(norm);
      result.is_converged = equation.is_settled() &&
                            is_round_off(std::numeric_limits<double>::max());
      return !result.is_converged;
    }

    bool
    may_go_on()
    {
      if (result.iterations < newton.maximum_iterations)
        return true;
      result.problem =
        "not converged in " + std::to_string(newton.maximum_iterations) +
        " iterations; |r| went from " + brief(result.residual_history.front()) +
        " to " + brief(norm) + " N";
      return false;
    }

    /**
     * Find the increment with the matrix damped by @p mu; a second time, mu
     * adds to what was there.
     * @return false if the linear solver failed
     */
    bool
    find_increment(const double mu)
    {
      const auto scope = newton.phases.scope("linear solve");
      diagonal.damp(mu, equation.system().jacobian);
      // moved, not copied into: unknowns may be numbered anew
      right_side = Vector(equation.system().reduced_residual);
      right_side *= -1.;
      LinearResult solve =
        newton.linear_solver.prepare(equation.system().jacobian,
                                     equation.system().node_places);
      if (solve.is_solved)
        solve =
          newton.linear_solver.solve(increment, right_side, linear_tolerance());
      if (solve.is_solved)
        {
          const LinearResult update =
            update_by_rank_ones(newton.linear_solver,
                                equation.system().rank_ones,
                                increment);
          solve.iterations += update.iterations;
          solve.is_solved = update.is_solved;
          solve.problem   = update.problem;
        }
      result.linear_iterations += solve.iterations;
      newton.phases.add_iterations("linear solve", solve.iterations);
      if (solve.is_solved)
        equation.expand(increment);
      else
        result.problem = "linear solver: " + solve.problem;
      return solve.is_solved;
    }

    /**
     * How well the next increment is to be found: as well as Newton is
     * expected to fall, which is with the square of how it fell before (an
     * inexact Newton method, Eisenstat and Walker 1996, choice 2), and no
     * better than round-off lets it. It starts tight: an iteration of Newton
     * more costs more than what a loose solve saves.
     */
    double
    linear_tolerance() const
    {
      constexpr double safety = 0.1, last = 1e-8, tightest = 1e-10,
                       round_off = 1e-14;

      const auto &history = result.residual_history;
      if (history.size() < 2)
        return newton.linear_tolerance;
      const double falls = norm / history[history.size() - 2];
      // the last increment leaves what is round-off, not what is enough
      const double loosest = history.size() > 2
                               ? std::min(last, newton.linear_tolerance)
                               : newton.linear_tolerance;
      return std::min(loosest,
                      std::max({safety * falls * falls,
                                tightest,
                                round_off * equation.system().scale / norm}));
    }

    /**
     * Whether the increment will most likely be the last one, so that no
     * matrix is wanted after it. Newton falls at least as fast as before.
     * Collective.
     */
    bool
    expects_to_end() const
    {
      const auto &history = result.residual_history;
      if (history.size() < 2)
        return false;
      const double falls = norm / history[history.size() - 2];
      return falls < 0.1 &&
             (falls * norm <= force_round_off * equation.system().scale ||
              falls * absolute_product(right_side, increment) <
                newton.tolerance * reference);
    }

    /**
     * Take the increment, and evaluate, without the matrix where it is not
     * likely to be wanted. @return whether the equation has meaning there.
     */
    bool
    take(const bool with_jacobian = true)
    {
      // The first increment may be wild at nodes that few particles reach;
      // then the first |r||du| of the paper is no measure, but this is.
      if (++result.iterations == 1)
        reference = absolute_product(right_side, increment);
      equation.take(solution, increment);
      return evaluate(with_jacobian);
    }

    /** Note what the increment led to. @return whether this is enough. */
    bool
    is_converged()
    {
      const double norm_before = norm;
      norm                     = equation.system().residual.l2_norm();
      result.residual_history.push_back(norm);
      newton.phases.tell("Newton iteration " +
                         std::to_string(result.iterations) +
                         ", |r| = " + brief(norm) + " N");
      result.work_history.push_back(
        absolute_product(equation.system().residual, increment));
      reference = std::min(reference, result.work_history.front());
      result.is_converged =
        equation.is_settled() &&
        (result.work_history.back() < newton.tolerance * reference ||
         is_round_off(norm_before));
      return result.is_converged;
    }

    /**
     * At nodes that few particles reach, small forces can do much work: go on
     * as long as the residual falls.
     */
    bool
    is_round_off(const double norm_before) const
    {
      return norm <= force_round_off * equation.system().scale &&
             (norm > 0.5 * norm_before ||
              absolute_product(equation.system().residual, solution) <=
                work_round_off * equation.system().work_scale);
    }

    /**
     * Whether |r| is what the round-off of its evaluation makes it: the last
     * increment, found with the true matrix, was small enough to be linear
     * and still has not lowered |r|. What is left must not matter, or the
     * increment be round-off itself: in a body that is stressed but in balance
     * the forces that are measured with are round-off too. Collective.
     */
    bool
    is_noise() const
    {
      const auto  &history = result.residual_history;
      const double before  = history[history.size() - 2];
      if (norm <= 0.5 * before)
        return false;
      const double size = equation.size(increment);
      return size <= smallest_size || (size <= linear_size && is_left_over());
    }

    /** What is left does not matter, whether or not it can be lowered. */
    bool
    is_left_over() const
    {
      return norm <= singular_tolerance * equation.system().scale &&
             absolute_product(equation.system().residual, solution) <=
               singular_tolerance * equation.system().work_scale;
    }

    const Newton      &newton;
    NonlinearEquation &equation;
    Vector            &solution;
    Vector             increment, right_side;
    Diagonal           diagonal; ///< of the jacobian
    NewtonResult       result;
    bool               has_jacobian = false; ///< of the solution
    double             norm         = 0.;    ///< |r|
    double             reference    = 0.;    ///< for sum |r||du|
  };

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
    linear_solver.begin_sequence();
    const Vector start = solution;
    Iteration    first(*this, equation, solution);
    plain(first);
    // without a residual the start has no meaning: no second try can begin
    if (first.result.is_converged || first.result.residual_history.empty())
      return first.result;

    equation.begin_again(solution, start);
    Iteration second(*this, equation, solution);
    damped(second);
    NewtonResult result = second.result;
    result.is_damped    = true;
    result.first_try    = first.result.problem;
    result.iterations += first.result.iterations;
    result.linear_iterations += first.result.linear_iterations;
    if (!result.is_converged)
      result.problem = first.result.problem + "; then, with a damped matrix, " +
                       result.problem;
    return result;
  }

  void
  Newton::plain(Iteration &iteration) const
  {
    if (!iteration.begin())
      return;
    while (iteration.may_go_on())
      {
        double mu = least_damping;
        if (!iteration.find_increment(mu))
          return;
        while (mu < 0.1 &&
               iteration.equation.size(iteration.increment) > largest_size)
          if (!iteration.find_increment(mu *= 100.))
            return;

        bool has_meaning =
          iteration.take(/*with_jacobian=*/!iteration.expects_to_end());
        const bool is_newtons = has_meaning && mu == least_damping;
        for (unsigned int halving = 0; !has_meaning && halving < 6; ++halving)
          {
            iteration.equation.halve(iteration.solution, iteration.increment);
            has_meaning = iteration.evaluate();
          }
        // beyond a kink an increment can do harm
        for (unsigned int halving = 0;
             has_meaning && iteration.equation.has_kinks() && halving < 5 &&
             iteration.equation.system().residual.l2_norm() > iteration.norm;
             ++halving)
          {
            iteration.equation.halve(iteration.solution, iteration.increment);
            has_meaning = iteration.evaluate();
          }
        if (!has_meaning)
          {
            iteration.result.problem = iteration.equation.problem();
            return;
          }
        if (iteration.is_converged())
          return;
        if (is_newtons && iteration.is_noise())
          {
            iteration.result.is_converged = true;
            return;
          }
        if (!iteration.has_jacobian)
          iteration.evaluate();
      }
  }

  void
  Newton::damped(Iteration &iteration) const
  {
    if (!iteration.begin())
      return;
    NonlinearEquation &equation = iteration.equation;
    const Vector       diagonal =
      iteration.diagonal.sizes(equation.system().jacobian, iteration.solution);
    double measure = scaled_norm(equation.system().residual, diagonal);
    for (double mu = first_damping; iteration.may_go_on();)
      {
        if (!iteration.find_increment(mu))
          return;
        const bool   has_meaning    = iteration.take();
        const double measure_before = measure;
        if (has_meaning)
          measure = scaled_norm(equation.system().residual, diagonal);
        const bool is_better = has_meaning && measure < measure_before;
        if (is_better && iteration.is_converged())
          return;
        if (!is_better)
          {
            iteration.equation.take_back(iteration.solution,
                                         iteration.increment);
            iteration.evaluate();
            measure = measure_before;
          }
        const bool has_stalled = measure > 0.5 * measure_before;
        if (has_stalled && iteration.is_left_over())
          {
            iteration.result.is_converged = iteration.result.leaves_rest = true;
            return;
          }
        mu = is_better ? std::max(least_damping, 0.1 * mu)
                       : std::min(1., 100. * mu);
      }
  }
} // namespace emmy
