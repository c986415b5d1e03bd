#ifndef emmy_solve_direct_solver_h
#define emmy_solve_direct_solver_h

#include <deal.II/lac/solver_control.h>

#include <emmy/solve/empty_pairs.h>
#include <emmy/solve/linear_solver.h>
#include <emmy/solve/node_product.h>

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

  /**
   * LU on rank 0, by KLU. The factors of the first matrix of a sequence serve
   * for the next ones, by GMRES with them, as long as a few iterations do: in
   * the plane LU takes as long as dozens of them.
   */
  class DirectSolver : public LinearSolver
  {
  public:
    /** @param n_components unknowns of a node */
    DirectSolver(const unsigned int n_components, const EmptyPairs empty_pairs);
    ~DirectSolver() override;

    void
    begin_sequence() override;

    LinearResult
    prepare(const Matrix &matrix, const NodePlaces *places = nullptr) override;

    /**
     * LU of the matrix scaled with its diagonal from both sides. Without it
     * a row of a node that a particle just reaches, whose diagonal is far
     * below its other entries, would be a pivot, and digits of its
     * neighbours lost.
     */
    LinearResult
    prepare_mass(const Matrix &matrix) override;

    /** To round-off; with factors of a matrix before, to the tolerance. */
    LinearResult
    solve(Vector &x, const Vector &b, const double tolerance) override;

    std::string
    name() const override;

  private:
    class Factors;

    LinearResult
    factorise(const Matrix &matrix);
    LinearResult
    solve_with_factors(Vector &x, const Vector &b);
    /** With factors of a matrix that is like the prepared one. */
    LinearResult
    solve_with_kept_factors(Vector &x, const Vector &b, const double tolerance);

    dealii::SolverControl control;
    bool                  is_scaled = false;
    Matrix                copy; ///< of what is factorised
    Vector                scale;
    /** Makes what is factorised; null: it is the matrix itself. */
    std::unique_ptr<WithoutEmptyPairs>                      reduced;
    std::unique_ptr<dealii::TrilinosWrappers::SolverDirect> solver;

    const Matrix *matrix = nullptr; ///< prepared last, with places
    NodeProduct   product;
    /** Of the matrix of the factors, where they can serve for others. */
    std::unique_ptr<const Epetra_CrsGraph> pattern;
    bool                                   serves = false; ///< for the next too
    bool is_kept = false; ///< the factors are of a matrix before
  };
} // namespace emmy

#endif
