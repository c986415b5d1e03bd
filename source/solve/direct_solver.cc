#include <deal.II/lac/trilinos_solver.h>

#include <emmy/base/exceptions.h>
#include <emmy/solve/direct_solver.h>

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

  DirectSolver::DirectSolver(const unsigned int n_components,
                             const EmptyPairs   empty_pairs)
  {
    if (empty_pairs == EmptyPairs::left_out)
      reduced = std::make_unique<WithoutEmptyPairs>(n_components);
  }

  DirectSolver::~DirectSolver() = default;

  LinearResult
  DirectSolver::prepare(const Matrix &matrix, const NodePlaces *)
  {
    is_scaled = false;
    return factorise(matrix);
  }

  LinearResult
  DirectSolver::prepare_mass(const Matrix &matrix)
  {
    is_scaled = true;
    scale.reinit(matrix.locally_owned_range_indices(),
                 matrix.get_mpi_communicator());
    for (const auto i : matrix.locally_owned_range_indices())
      {
        const double diagonal = std::abs(matrix.diag_element(i));
        scale[i]              = diagonal > 0. ? 1. / std::sqrt(diagonal) : 1.;
      }
    scale.compress(dealii::VectorOperation::insert);
    scaled.reinit(matrix);
    scaled.copy_from(matrix);
    auto &entries = const_cast<Epetra_CrsMatrix &>(scaled.trilinos_matrix());
    entries.LeftScale(*scale.trilinos_vector()(0));
    entries.RightScale(*scale.trilinos_vector()(0));
    return factorise(scaled);
  }

  LinearResult
  DirectSolver::solve(Vector &x, const Vector &b, const double)
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
  DirectSolver::factorise(const Matrix &matrix)
  {
    LinearResult result;
    try
      {
        solver = std::make_unique<TW::SolverDirect>(control);
        solver->initialize(reduced ? (*reduced)(matrix) : matrix);
      }
    catch (const std::exception &)
      {
        result.problem = "the matrix is singular: LU factorisation failed";
      }
    return agreed(result, matrix.get_mpi_communicator());
  }
} // namespace emmy
