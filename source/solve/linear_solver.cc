#include <deal.II/lac/solver_bicgstab.h>
#include <deal.II/lac/solver_control.h>
#include <deal.II/lac/trilinos_solver.h>

#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/solve/direct_solver.h>
#include <emmy/solve/gmres.h>
#include <emmy/solve/linear_solver.h>
#include <emmy/solve/preconditioner.h>

#include <Epetra_MultiVector.h>

#include <algorithm>
#include <cmath>

namespace emmy
{
  namespace TW = dealii::TrilinosWrappers;

  namespace
  {
    class KrylovSolver : public LinearSolver
    {
    public:
      KrylovSolver(const std::string &method,
                   const std::string &preconditioner,
                   const unsigned int n_components,
                   const unsigned int max_iterations)
        : method(method)
        , preconditioner_name(preconditioner)
        , max_iterations(max_iterations)
        , product(n_components)
        , preconditioner(make_preconditioner(preconditioner, n_components))
      {}

      void
      begin_sequence() override
      {
        serves = false;
      }

      LinearResult
      prepare(const Matrix     &new_matrix,
              const NodePlaces *new_places = nullptr) override
      {
        matrix = &new_matrix;
        places = new_places;
        product.set(*matrix);
        is_kept = serves && places && has_nodes_of_before();
        return is_kept ? LinearResult() : make();
      }

      LinearResult
      solve(Vector &x, const Vector &b, const double tolerance) override
      {
        LinearResult       result     = refine(x, b, tolerance);
        const unsigned int iterations = result.iterations;
        const bool         is_anew    = is_kept && !result.is_solved;
        if (is_anew)
          {
            result = make();
            if (result.is_solved)
              result = refine(x, b, tolerance);
          }
        if (is_kept)
          serves = rate(result, tolerance) <= 1.5 * first_rate + 0.5;
        else
          first_rate = rate(result, tolerance);
        if (is_anew)
          result.iterations += iterations;
        return result;
      }

      std::string
      name() const override
      {
        return method + " with " + preconditioner_name;
      }

    private:
      /** Iterations for a tenth of the residual. */
      static double
      rate(const LinearResult &result, const double tolerance)
      {
        return result.iterations / -std::log10(std::min(tolerance, 0.1));
      }

      LinearResult
      make()
      {
        LinearResult result;
        try
          {
            preconditioner->make(*matrix, places);
          }
        catch (const std::exception &)
          {
            result.problem =
              "the preconditioner " + preconditioner_name + " cannot be made";
          }
        result  = agreed(result, matrix->get_mpi_communicator());
        is_kept = false;
        serves =
          result.is_solved && places && preconditioner->outlives_matrix();
        if (serves)
          nodes_of_before = places->coordinates;
        return result;
      }

      /** Whether the rows are of the nodes of which the preconditioner was
       * made. Other pairs of them may meet: it is an approximation anyway.
       * Collective. */
      bool
      has_nodes_of_before() const
      {
        const Epetra_MultiVector &now = places->coordinates.trilinos_vector();
        const Epetra_MultiVector &before = nodes_of_before.trilinos_vector();
        if (!now.Map().SameAs(before.Map()))
          return false;
        const bool is_same =
          std::equal(now[0], now[0] + now.MyLength(), before[0]);
        return dealii::Utilities::MPI::min(is_same ? 1 : 0,
                                           matrix->get_mpi_communicator()) == 1;
      }

      /**
       * The residual that a method goes by is not the true one to all digits,
       * with a preconditioner in single precision: so begin again from the
       * true one where it is too large.
       */
      LinearResult
      refine(Vector &x, const Vector &b, const double tolerance) const
      {
        constexpr unsigned int max_cycles = 5;

        LinearResult result;
        const double goal = tolerance * b.l2_norm();
        Vector       residual(b), correction(b);
        x           = 0.;
        double norm = residual.l2_norm();
        for (unsigned int cycle = 0; cycle < max_cycles && norm > goal; ++cycle)
          {
            const LinearResult part = run(correction,
                                          residual,
                                          goal,
                                          max_iterations - result.iterations);
            result.iterations += part.iterations;
            result.problem = part.problem;
            if (!part.is_solved)
              break;
            x += correction;
            norm = product.residual(residual, x, b);
          }
        if (result.problem.empty() && !(norm <= goal))
          result.problem = name() + " stays at the residual " + shortest(norm) +
                           " above " + shortest(goal);
        return agreed(result, b.get_mpi_communicator());
      }

      static std::string
      not_reached(const double goal, const unsigned int iterations)
      {
        return " did not reach the residual " + shortest(goal) + " in " +
               std::to_string(iterations) + " iterations";
      }

      LinearResult
      run(Vector            &x,
          const Vector      &b,
          const double       goal,
          const unsigned int most) const
      {
        LinearResult result;
        if (method == "GMRES")
          {
            Gmres gmres(product, *preconditioner, /*restart=*/50);
            result.is_solved  = gmres.solve(x, b, goal, most);
            result.iterations = gmres.iterations();
            if (!result.is_solved)
              result.problem =
                name() + (gmres.is_broken()
                            ? " broke down"
                            : not_reached(goal, result.iterations));
            return result;
          }
        dealii::SolverControl control(most, goal);
        x = 0.;
        try
          {
            dealii::SolverBicgstab<Vector>(control).solve(*matrix,
                                                          x,
                                                          b,
                                                          *preconditioner);
          }
        catch (const std::exception &)
          {
            // a method that breaks down leaves no number of steps
            result.problem =
              name() +
              (control.last_step() == dealii::numbers::invalid_unsigned_int
                 ? std::string(" broke down")
                 : not_reached(goal, control.last_step()));
          }
        result.is_solved = result.problem.empty();
        if (control.last_step() != dealii::numbers::invalid_unsigned_int)
          result.iterations = control.last_step();
        return result;
      }

      const std::string                     method, preconditioner_name;
      const unsigned int                    max_iterations;
      const Matrix                         *matrix = nullptr;
      const NodePlaces                     *places = nullptr;
      NodeProduct                           product;
      const std::unique_ptr<Preconditioner> preconditioner;
      Vector nodes_of_before;    ///< coordinates by row
      bool   serves     = false; ///< for the next matrix too
      bool   is_kept    = false; ///< from a matrix before
      double first_rate = 0.;    ///< with the matrix that it was made of
    };

    /**
     * GMRES with ILU, and LU where that fails: matrices with weakly filled
     * nodes can be too much for a preconditioner. What follows such a matrix is
     * like it, so LU stays for a while: the longer, the more often GMRES has
     * failed in this run, since LU of a large matrix in space takes as long as
     * hundreds of iterations. Matrices that are too large to
     * factorise are left to GMRES alone.
     *
     * A sequence that goes on is a hard one: near a singular matrix Newton
     * needs more digits of its increments, in directions that the norm of the
     * residual does not see. So LU takes the matrices after the fifth, where it
     * is about as fast.
     */
    class AutomaticSolver : public LinearSolver
    {
    public:
      AutomaticSolver(const std::string &preconditioner,
                      const unsigned int n_components,
                      LinearSolverState *state_of_run,
                      const EmptyPairs   empty_pairs)
        : krylov("GMRES", preconditioner, n_components, 300)
        , direct(n_components, empty_pairs)
        , largest_direct(largest_direct_size(n_components))
        , largest_hard(n_components == 2 ? 60000 : 1000)
        , state(state_of_run ? *state_of_run : own_state)
      {}

      void
      begin_sequence() override
      {
        krylov.begin_sequence();
        direct.begin_sequence();
        n_matrices = 0;
      }

      LinearResult
      prepare(const Matrix     &new_matrix,
              const NodePlaces *places = nullptr) override
      {
        matrix     = &new_matrix;
        first_norm = 0.;
        is_direct  = state.n_direct_left > 0;
        if (is_direct)
          --state.n_direct_left;
        else if (++n_matrices > most_easy)
          is_direct = matrix->m() <= largest_hard;
        if (is_direct)
          return direct.prepare(*matrix);
        const LinearResult result = krylov.prepare(*matrix, places);
        return result.is_solved ? result : fall_back(result);
      }

      /** LU of the scaled matrix, where it is not too large for that. */
      LinearResult
      prepare_mass(const Matrix &new_matrix) override
      {
        if (new_matrix.m() > largest_direct)
          return prepare(new_matrix);
        matrix     = &new_matrix;
        first_norm = 0.;
        is_direct  = true;
        return direct.prepare_mass(*matrix);
      }

      LinearResult
      solve(Vector &x, const Vector &b, const double tolerance) override
      {
        if (is_direct)
          return direct.solve(x, b, tolerance);
        LinearResult result =
          krylov.solve(x,
                       b,
                       matrix->m() <= largest_hard
                         ? std::min(tolerance, digits_for_lu)
                         : tolerance);
        // a refinement that stalls near round-off is no failure
        const double norm          = b.l2_norm();
        const bool   is_refinement = norm < 1e-3 * first_norm;
        first_norm                 = std::max(first_norm, norm);
        if (result.is_solved || is_refinement)
          return result;
        const unsigned int iterations = result.iterations;
        result                        = fall_back(result);
        if (result.is_solved)
          result = direct.solve(x, b, tolerance);
        result.iterations = iterations;
        return result;
      }

      std::string
      name() const override
      {
        return krylov.name() +
               (state.n_failures == 0
                  ? std::string()
                  : ", which failed " + std::to_string(state.n_failures) +
                      " times; then direct (KLU)");
      }

    private:
      /** Factorise, after GMRES or its preconditioner failed. */
      LinearResult
      fall_back(const LinearResult &failure)
      {
        if (matrix->m() > largest_direct)
          return failure;
        constexpr unsigned int longest = 50;
        ++state.n_failures;
        is_direct = true;
        state.n_direct_left =
          state.n_failures < 6 ? 1u << state.n_failures : longest;
        return direct.prepare(*matrix);
      }

      KrylovSolver krylov;
      DirectSolver direct;
      /** What GMRES leaves where it stands for LU, as |r| / |b|. */
      static constexpr double digits_for_lu = 1e-8;
      /** Matrices of a sequence that GMRES gets. */
      static constexpr unsigned int most_easy = 5;

      const std::uint64_t largest_direct;
      const std::uint64_t largest_hard; ///< unknowns of a hard sequence for LU
      const Matrix       *matrix     = nullptr;
      unsigned int        n_matrices = 0;  ///< of this sequence
      double              first_norm = 0.; ///< of b since prepare()
      bool                is_direct  = false;
      LinearSolverState   own_state;
      LinearSolverState  &state;
    };
  } // namespace

  std::uint64_t
  largest_direct_size(const unsigned int n_components)
  {
    return n_components == 2 ? 300000 : 30000;
  }

  std::unique_ptr<LinearSolver>
  make_linear_solver(const SolverParameters &parameters,
                     const std::uint64_t     n_dofs,
                     const unsigned int      n_components,
                     LinearSolverState      *state,
                     const EmptyPairs        empty_pairs)
  {
    parameters.validate();
    if (state && state->first_size == 0)
      state->first_size = n_dofs;
    const std::uint64_t size     = state ? state->first_size : n_dofs;
    const std::string  &method   = parameters.linear_solver;
    const bool          is_small = size <= 300;
    if (method == "direct" || (method == "automatic" && is_small))
      return std::make_unique<DirectSolver>(n_components, empty_pairs);
    if (method == "automatic")
      return std::make_unique<AutomaticSolver>(parameters.preconditioner,
                                               n_components,
                                               state,
                                               empty_pairs);
    return std::make_unique<KrylovSolver>(method,
                                          parameters.preconditioner,
                                          n_components,
                                          1000);
  }

  LinearResult
  solve_to_round_off(
    LinearSolver                                        &solver,
    const std::function<void(Vector &, const Vector &)> &residual_of,
    const Constraints                                   &constraints,
    const Vector                                        &b,
    Vector                                              &x)
  {
    constexpr unsigned int max_refinements  = 10;
    constexpr double       krylov_tolerance = 1e-6;

    LinearResult result;
    Vector       residual(b), correction(b), better(b);
    const auto   update_residual = [&](const Vector &trial) {
      residual_of(residual, trial);
      constraints.condense(residual);
      return residual.l2_norm();
    };
    double norm = update_residual(x);
    // walls that move bring momentum into a body at rest, where b is zero
    const double scale = std::max(b.l2_norm(), norm);
    for (unsigned int i = 0; i < max_refinements && norm > 0.; ++i)
      {
        const LinearResult solve =
          solver.solve(correction, residual, krylov_tolerance);
        result.iterations += solve.iterations;
        if (!solve.is_solved)
          return i == 0 ? solve : result;
        constraints.set_zero(correction);
        constraints.expand(correction);
        better = x;
        better += correction;
        const double better_norm = update_residual(better);
        if (!(better_norm < 0.9 * norm))
          break;
        x    = better;
        norm = better_norm;
      }
    // far above round-off, far below what a ledger would show
    if (norm > 1e-10 * scale)
      {
        result.is_solved = false;
        result.problem   = "the residual of the point-to-grid map stays at " +
                         shortest(norm / scale) + " of the momentum";
      }
    return result;
  }
} // namespace emmy
