#ifndef emmy_solve_direct_solver_h
#define emmy_solve_direct_solver_h

#include <deal.II/lac/solver_control.h>

#include <emmy/solve/empty_pairs.h>
#include <emmy/solve/linear_solver.h>

namespace dealii
{
  namespace TrilinosWrappers
  {
    class SolverDirect;
  }
} // namespace dealii

namespace emmy
{
  /** All ranks learn of a failure on any of them. Collective. */
  LinearResult
  agreed(LinearResult result, const MPI_Comm communicator);

  /** LU on rank 0, by KLU. */
  class DirectSolver : public LinearSolver
  {
  public:
    /** @param n_components unknowns of a node */
    DirectSolver(const unsigned int n_components, const EmptyPairs empty_pairs);
    ~DirectSolver() override;

    LinearResult
    prepare(const Matrix &matrix, const NodePlaces * = nullptr) override;

    /**
     * LU of the matrix scaled with its diagonal from both sides. Without it
     * a row of a node that a particle just reaches, whose diagonal is far
     * below its other entries, would be a pivot, and digits of its
     * neighbours lost.
     */
    LinearResult
    prepare_mass(const Matrix &matrix) override;

    LinearResult
    solve(Vector &x, const Vector &b, const double) override;

    std::string
    name() const override;

  private:
    LinearResult
    factorise(const Matrix &matrix);

    dealii::SolverControl control;
    bool                  is_scaled = false;
    Matrix                scaled;
    Vector                scale;
    /** Makes what is factorised; null: it is the matrix itself. */
    std::unique_ptr<WithoutEmptyPairs>                      reduced;
    std::unique_ptr<dealii::TrilinosWrappers::SolverDirect> solver;
  };
} // namespace emmy

#endif
