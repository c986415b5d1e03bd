#include <deal.II/lac/lapack_full_matrix.h>

#include <emmy/solve/condition.h>

#include <Amesos_Klu.h>
#include <Epetra_LinearProblem.h>
#include <Epetra_Vector.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace emmy
{
  namespace
  {
    constexpr double largest_condition = 1e16, singular_condition = 1e15;

    /**
     * Added to the unit diagonal before the factorisation, so that a singular
     * matrix has one: a few times the round-off of the entries.
     */
    constexpr double first_shift = 1e-15;

    struct Eigenpair
    {
      double value = 0.;
      Vector vector; ///< of norm 1
    };

    /**
     * The largest eigenvalue of a symmetric operator without negative ones, by
     * Lanczos' method. All vectors are kept and orthogonalised twice: they are
     * few.
     */
    Eigenpair
    largest_eigenpair(
      const std::function<void(Vector &, const Vector &)> &apply,
      const Vector                                        &start)
    {
      constexpr unsigned int max_steps = 60;
      constexpr double       tolerance = 1e-6; // of the residual, relative

      std::vector<Vector> basis{start};
      basis[0] /= start.l2_norm();
      std::vector<double> diagonal, beside;
      Eigenpair           result;
      while (true)
        {
          const unsigned int n = basis.size();
          Vector             next(start);
          apply(next, basis.back());
          diagonal.push_back(next * basis.back());
          for (unsigned int repetition = 0; repetition < 2; ++repetition)
            for (const Vector &v : basis)
              next.add(-(next * v), v);
          beside.push_back(next.l2_norm());

          // the operator on the basis; scaled, as LAPACK wants an accuracy
          const double scale =
            *std::max_element(diagonal.begin(), diagonal.end());
          result.value = scale;
          if (!std::isfinite(scale + beside.back()) || scale <= 0.)
            break;
          dealii::LAPACKFullMatrix<double> projected(n, n);
          for (unsigned int i = 0; i < n; ++i)
            {
              projected(i, i) = diagonal[i] / scale;
              if (i > 0)
                projected(i, i - 1) = projected(i - 1, i) =
                  beside[i - 1] / scale;
            }
          dealii::Vector<double>     values;
          dealii::FullMatrix<double> vectors;
          projected.compute_eigenvalues_symmetric(
            0.5, 1.5 * n, 1e-15, values, vectors);
          if (values.size() == 0) // round-off left no positive eigenvalue
            break;
          const unsigned int last = values.size() - 1;
          result.value            = scale * values[last];

          if (beside.back() * std::abs(vectors(n - 1, last)) <=
                tolerance * result.value ||
              n == max_steps)
            {
              result.vector = Vector(start);
              result.vector = 0.;
              for (unsigned int i = 0; i < n; ++i)
                result.vector.add(vectors(i, last), basis[i]);
              break;
            }
          next /= beside.back();
          basis.push_back(std::move(next));
        }
      return result;
    }

    /** LU factors that also solve with the transposed matrix. */
    class Factors
    {
    public:
      /** The matrix must stay alive and unchanged. */
      explicit Factors(const Matrix &matrix)
        : solver(problem)
      {
        problem.SetOperator(
          const_cast<Epetra_CrsMatrix *>(&matrix.trilinos_matrix()));
      }

      /** @return whether there are factors. Collective. */
      bool
      compute()
      {
        // a singular matrix is a result: nothing to be printed
        const int mode = Epetra_Object::GetTracebackMode();
        Epetra_Object::SetTracebackMode(0);
        const bool succeeds = solver.SymbolicFactorization() == 0 &&
                              solver.NumericFactorization() == 0;
        Epetra_Object::SetTracebackMode(mode);
        return succeeds;
      }

      void
      solve(Vector &x, const Vector &b, const bool transposed)
      {
        problem.SetLHS(&x.trilinos_vector());
        problem.SetRHS(const_cast<Epetra_MultiVector *>(&b.trilinos_vector()));
        solver.SetUseTranspose(transposed);
        solver.Solve();
      }

    private:
      Epetra_LinearProblem problem;
      Amesos_Klu           solver;
    };

    /** 1/sqrt|a_ii|; 1 where that is zero, and 0 on constrained unknowns. */
    Vector
    scaling(const Matrix                            &matrix,
            const dealii::AffineConstraints<double> &constraints,
            const Vector                            &like)
    {
      Vector result(like);
      auto   entry = result.begin();
      for (const auto row : matrix.locally_owned_range_indices())
        {
          const double diagonal = std::abs(matrix.diag_element(row));
          *entry++              = constraints.is_constrained(row) ? 0.
                                  : diagonal > 0. ? 1. / std::sqrt(diagonal)
                                                  : 1.;
        }
      return result;
    }

    void
    shift_diagonal(const double shift, Matrix &matrix)
    {
      for (const auto row : matrix.locally_owned_range_indices())
        matrix.add(row, row, shift);
      matrix.compress(dealii::VectorOperation::add);
    }
  } // namespace

  double
  ConditionEstimate::condition() const
  {
    return std::min(largest / smallest, largest_condition);
  }

  bool
  ConditionEstimate::is_singular() const
  {
    return condition() > singular_condition;
  }

  ConditionEstimate
  condition_estimate(const Matrix                            &matrix,
                     const dealii::AffineConstraints<double> &constraints,
                     const Vector                            &start)
  {
    const Vector scale = scaling(matrix, constraints, start);
    Matrix       scaled;
    scaled.copy_from(matrix);
    auto &epetra = const_cast<Epetra_CrsMatrix &>(scaled.trilinos_matrix());
    auto &factor = const_cast<Epetra_MultiVector &>(scale.trilinos_vector());
    const Epetra_Vector view(Epetra_DataAccess::View, factor, 0);
    epetra.LeftScale(view);
    epetra.RightScale(view);
    // nothing couples to a constrained unknown now; a unit diagonal keeps the
    // factors regular, and no vector has a share there
    for (const auto row : scaled.locally_owned_range_indices())
      if (constraints.is_constrained(row))
        scaled.set(row, row, 1.);
    scaled.compress(dealii::VectorOperation::insert);

    ConditionEstimate result;
    Vector            first(start), between(start);
    constraints.set_zero(first);
    result.weakest = Vector(first);
    result.weakest = 0.; // as long as it is not known
    result.largest = result.smallest = std::numeric_limits<double>::quiet_NaN();
    if (!std::isfinite(scaled.frobenius_norm()) || first.l2_norm() == 0.)
      return result;

    result.largest  = std::sqrt(largest_eigenpair(
                                 [&](Vector &y, const Vector &x) {
                                   scaled.vmult(between, x);
                                   scaled.Tvmult(y, between);
                                 },
                                 first)
                                 .value);
    result.smallest = 0.;
    for (double shift = first_shift; shift < 1e-12; shift *= 10.)
      {
        shift_diagonal(shift, scaled);
        Factors factors(scaled);
        if (!factors.compute())
          continue;
        const Eigenpair inverse = largest_eigenpair(
          [&](Vector &y, const Vector &x) {
            factors.solve(between, x, /*transposed=*/true);
            factors.solve(y, between, /*transposed=*/false);
          },
          first);
        if (!std::isfinite(inverse.value) || inverse.vector.size() == 0)
          continue;
        result.smallest = 1. / std::sqrt(inverse.value);
        result.weakest  = Vector(inverse.vector);
        break;
      }
    result.weakest.scale(scale);
    if (const double norm = result.weakest.linfty_norm(); norm > 0.)
      result.weakest /= norm;
    return result;
  }
} // namespace emmy
