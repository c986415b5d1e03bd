#include <deal.II/lac/trilinos_solver.h>

#include <emmy/base/exceptions.h>
#include <emmy/solve/direct_solver.h>
#include <emmy/solve/gmres.h>

#include <Epetra_CrsMatrix.h>

#include <cmath>

namespace emmy
{
  namespace TW = dealii::TrilinosWrappers;

  LinearResult
  agreed(LinearResult result, const MPI_Comm communicator)
  {
    result.problem   = agree_on_problem(communicator, result.problem);
    result.is_solved = result.problem.empty();
    return result;
  }

  /** The inverse that LU gave, as a preconditioner of GMRES. */
  class DirectSolver::Factors : public Preconditioner
  {
  public:
    explicit Factors(TW::SolverDirect &solver)
      : solver(solver)
    {}

    void
    make(const Matrix &, const NodePlaces *) override
    {}

    void
    vmult(Vector &z, const Vector &r) const override
    {
      solver.solve(z, r);
    }

  private:
    TW::SolverDirect &solver;
  };

  DirectSolver::DirectSolver(const unsigned int n_components,
                             const EmptyPairs   empty_pairs)
    : product(n_components)
  {
    if (empty_pairs == EmptyPairs::left_out)
      reduced = std::make_unique<WithoutEmptyPairs>(n_components);
  }

  DirectSolver::~DirectSolver() = default;

  void
  DirectSolver::begin_sequence()
  {
    serves = false;
  }

  LinearResult
  DirectSolver::prepare(const Matrix &new_matrix, const NodePlaces *places)
  {
    matrix                       = &new_matrix;
    const Epetra_CrsGraph &graph = matrix->trilinos_matrix().Graph();
    is_kept = serves && places && graph.DataPtr() == pattern->DataPtr();
    if (is_kept)
      {
        product.set(*matrix);
        return LinearResult();
      }
    is_scaled = false;
    // Trilinos looks at the matrix in each solve, and others come before them
    copy.reinit(*matrix);
    copy.copy_from(*matrix);
    const LinearResult result = factorise(copy);
    serves                    = result.is_solved && places;
    // a copy shares what it has: no other pattern can have its place
    pattern = serves ? std::make_unique<Epetra_CrsGraph>(graph) : nullptr;
    return result;
  }

  LinearResult
  DirectSolver::prepare_mass(const Matrix &matrix)
  {
    is_scaled = true;
    is_kept = serves = false;
    scale.reinit(matrix.locally_owned_range_indices(),
                 matrix.get_mpi_communicator());
    for (const auto i : matrix.locally_owned_range_indices())
      {
        const double diagonal = std::abs(matrix.diag_element(i));
        scale[i]              = diagonal > 0. ? 1. / std::sqrt(diagonal) : 1.;
      }
    scale.compress(dealii::VectorOperation::insert);
    copy.reinit(matrix);
    copy.copy_from(matrix);
    auto &entries = const_cast<Epetra_CrsMatrix &>(copy.trilinos_matrix());
    entries.LeftScale(*scale.trilinos_vector()(0));
    entries.RightScale(*scale.trilinos_vector()(0));
    return factorise(copy);
  }

  LinearResult
  DirectSolver::solve(Vector &x, const Vector &b, const double tolerance)
  {
    if (!is_kept)
      return solve_with_factors(x, b);
    LinearResult result = solve_with_kept_factors(x, b, tolerance);
    if (result.is_solved)
      return result;
    is_kept = serves = false;
    copy.copy_from(*matrix);
    result = factorise(copy);
    return result.is_solved ? solve_with_factors(x, b) : result;
  }

  LinearResult
  DirectSolver::solve_with_kept_factors(Vector       &x,
                                        const Vector &b,
                                        const double  tolerance)
  {
    constexpr unsigned int most      = 8;
    constexpr double       round_off = 1e-12;

    LinearResult result;
    const double goal = std::min(tolerance, round_off) * b.l2_norm();
    try
      {
        const Factors factors(*solver);
        Gmres         gmres(product, factors, most);
        result.is_solved = gmres.solve(x, b, goal, most);
      }
    catch (const std::exception &)
      {
        result.is_solved = false;
      }
    if (!result.is_solved)
      result.problem = "the factors of another matrix do not serve";
    return agreed(result, b.get_mpi_communicator());
  }

  LinearResult
  DirectSolver::solve_with_factors(Vector &x, const Vector &b)
  {
    LinearResult result;
    try
      {
        if (is_scaled)
          {
            Vector scaled_b(b);
            scaled_b.scale(scale);
            solver->solve(x, scaled_b);
            x.scale(scale);
          }
        else
          solver->solve(x, b);
      }
    catch (const std::exception &)
      {
        result.problem = "the matrix is singular: LU could not solve";
      }
    if (result.problem.empty() && !std::isfinite(x.l2_norm()))
      result.problem = "the matrix is singular: LU gave no number";
    return agreed(result, b.get_mpi_communicator());
  }

  std::string
  DirectSolver::name() const
  {
    return "direct (KLU)";
  }

  LinearResult
  DirectSolver::factorise(const Matrix &to_factorise)
  {
    LinearResult result;
    try
      {
        solver = std::make_unique<TW::SolverDirect>(control);
        solver->initialize(reduced ? (*reduced)(to_factorise) : to_factorise);
      }
    catch (const std::exception &)
      {
        result.problem = "the matrix is singular: LU factorisation failed";
      }
    return agreed(result, to_factorise.get_mpi_communicator());
  }
} // namespace emmy
