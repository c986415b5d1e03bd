#ifndef emmy_solve_linear_solver_h
#define emmy_solve_linear_solver_h

#include <emmy/base/linear_algebra.h>
#include <emmy/base/section.h>
#include <emmy/system/constraints.h>
#include <emmy/system/node_places.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace emmy
{
  /** What an entry of a parameter file may say, and what it stands for. */
  struct Choice
  {
    /** As in parameter files, and for `emmy --list`. */
    std::string name, description;
  };

  /** All values of Solver/Linear solver. */
  const std::vector<Choice> &
  linear_solvers();

  /** All values of Solver/Preconditioner. */
  const std::vector<Choice> &
  preconditioners();

  /** Section `Solver`. */
  class SolverParameters : public Section
  {
  public:
    /** Its name; automatic: by size. */
    std::string linear_solver  = "automatic";
    std::string preconditioner = "ILU"; ///< its name
    /** Of the first Krylov solve of a step, to its right-hand side. */
    double linear_tolerance = 1e-4;
    /** Of sum |r||du|, to its first value. */
    double       newton_tolerance   = 1e-11;
    unsigned int maximum_iterations = 100; ///< of Newton, a step

    /** Declares the entries of the section. */
    explicit SolverParameters(const std::string &path = "Solver");

    /** Throws ExcParameter. */
    void
    validate() const;
  };

  /** How a linear solve went; the same on all ranks. */
  struct LinearResult
  {
    bool         is_solved  = true; ///< to its tolerance
    unsigned int iterations = 0;    ///< of a Krylov method
    std::string  problem;           ///< in words, if not solved
  };

  /** What a solver's choices depend on, from one system to the next. */
  struct LinearSolverState
  {
    std::uint64_t first_size    = 0; ///< unknowns of the first system
    unsigned int  n_direct_left = 0; ///< systems that LU gets before GMRES may
    unsigned int  n_failures    = 0; ///< of GMRES, which LU solved then
  };

  /** What LU does with pairs of nodes that have nothing in common. */
  enum class EmptyPairs
  {
    kept,
    left_out ///< see WithoutEmptyPairs
  };

  /**
   * A solver for square, in general non-symmetric, matrices. Owned by the
   * step; used for the point-to-grid map and by Newton.
   */
  class LinearSolver
  {
  public:
    virtual ~LinearSolver() = default;

    /**
     * Matrices that are prepared with places from now on are like each other,
     * and not like those of before: a preconditioner of one serves for those
     * of the same nodes, as long as it does.
     */
    virtual void
    begin_sequence()
    {}

    /**
     * Factorise, or make the preconditioner. The matrix must stay alive.
     * @param places of the rows, for a coarse level; null: there is none
     */
    virtual LinearResult
    prepare(const Matrix &matrix, const NodePlaces *places = nullptr) = 0;

    /**
     * The same for a symmetric mass matrix with rows of very different size,
     * where prepare() loses digits: a direct solver scales it.
     */
    virtual LinearResult
    prepare_mass(const Matrix &matrix)
    {
      return prepare(matrix);
    }

    /**
     * Solve with the prepared matrix to the relative residual @p tolerance
     * (a direct solver: to round-off).
     */
    virtual LinearResult
    solve(Vector &x, const Vector &b, const double tolerance) = 0;

    /** For the log, e.g. "direct (KLU)". */
    virtual std::string
    name() const = 0;
  };

  /**
   * How many unknowns a factorisation that nobody asked for may have: its fill
   * takes gigabytes and minutes from there on.
   * @param n_components unknowns per node: 2 in plane strain, 3 in space
   */
  std::uint64_t
  largest_direct_size(const unsigned int n_components);

  /**
   * The solver that the parameters name; "automatic" takes the direct one up
   * to a size where its fill-in costs more than GMRES with ILU, and from there
   * on GMRES, with the direct one for matrices where that fails.
   *
   * @param n_dofs       size of the first system, for the choice
   * @param n_components unknowns per node, for the multigrid's near-kernel
   * @param state        borrowed: where the solver keeps what its choices
   *   depend on; one that knows a first size goes on. Null: in the solver
   * @param empty_pairs  left out: for matrices of NodeGraph with many of them
   */
  std::unique_ptr<LinearSolver>
  make_linear_solver(const SolverParameters &parameters,
                     const std::uint64_t     n_dofs,
                     const unsigned int      n_components,
                     LinearSolverState      *state       = nullptr,
                     const EmptyPairs        empty_pairs = EmptyPairs::kept);

  /**
   * Solve A x = b to round-off, with constraints C^T A x = C^T b: by iterative
   * refinement, until the residual no longer falls, with a solver that was
   * prepared with a matrix close to A. Starts from @p x, which satisfies the
   * constraints, and keeps what A cannot see of it. The identities of the
   * ledger need a small residual, not a small condition number.
   * @param residual_of sets its first argument to b - A times the second
   */
  LinearResult
  solve_to_round_off(
    LinearSolver                                        &solver,
    const std::function<void(Vector &, const Vector &)> &residual_of,
    const Constraints                                   &constraints,
    const Vector                                        &b,
    Vector                                              &x);
} // namespace emmy

#endif
