// GMRES: it ends in at most as many iterations as there are different
// eigenvalues, restarted or not; the residual it knows of is the true one;
// numbers that are not finite and singular matrices are said, not hidden. On
// any number of ranks, one without rows too.

#include <deal.II/lac/trilinos_sparsity_pattern.h>

#include <emmy/solve/gmres.h>

#include <cmath>

#include "../check.h"

using namespace emmy;
using test::check;

namespace
{
  constexpr unsigned int n = 60;

  const MPI_Comm world = MPI_COMM_WORLD;

  dealii::IndexSet
  own_rows()
  {
    using namespace dealii::Utilities::MPI;
    const unsigned int rank    = this_mpi_process(world),
                       n_parts = std::max(1u, n_mpi_processes(world) - 1);
    const auto first           = [&](const unsigned int part) {
      return n * std::min(part, n_parts) / n_parts;
    };
    dealii::IndexSet rows(n);
    rows.add_range(first(rank), first(rank + 1));
    rows.compress();
    return rows;
  }

  /** Two diagonals: d(i) and, to the right of it, u(i). */
  template <class Diagonal, class Upper>
  Matrix
  make_matrix(const Diagonal &d, const Upper &u)
  {
    const auto                                rows = own_rows();
    dealii::TrilinosWrappers::SparsityPattern pattern(rows, world);
    for (const auto i : rows)
      for (const auto j : {i, (i + 1) % n})
        pattern.add(i, j);
    pattern.compress();
    Matrix matrix;
    matrix.reinit(pattern);
    for (const auto i : rows)
      {
        matrix.set(i, i, d(i));
        matrix.set(i, (i + 1) % n, u(i));
      }
    matrix.compress(dealii::VectorOperation::insert);
    return matrix;
  }

  Vector
  right_side()
  {
    const auto rows = own_rows();
    Vector     b(rows, world);
    for (const auto i : rows)
      b(i) = std::sin(1. + i * i);
    b.compress(dealii::VectorOperation::insert);
    return b;
  }

  /** Divides by numbers. */
  class Divided : public Preconditioner
  {
  public:
    explicit Divided(const double by)
      : by(by)
    {}
    void
    make(const Matrix &, const NodePlaces *) override
    {}
    void
    vmult(Vector &z, const Vector &r) const override
    {
      z = r;
      z *= 1. / by;
    }

  private:
    const double by;
  };

  void
  test_solves()
  {
    // not symmetric, with eigenvalues over five decades
    const Matrix matrix = make_matrix(
      [](const unsigned int i) { return std::pow(10., -5. * i / n); },
      [](const unsigned int i) { return i + 1 < n ? 1e-6 * (i % 3) : 0.; });
    NodeProduct product(1);
    product.set(matrix);
    const Divided halved(2.);
    const Vector  b = right_side();
    Vector        x(b), residual(b);
    for (const auto &[restart, most] :
         {std::make_pair(n, n), std::make_pair(30u, 20000u)})
      {
        Gmres        gmres(product, halved, restart);
        const double goal = 1e-9 * b.l2_norm();
        check(gmres.solve(x, b, goal, most), "it converges");
        check(!gmres.is_broken(), "and does not break down");
        const double left = matrix.residual(residual, x, b);
        std::cout << "restart " << restart << ": " << gmres.iterations()
                  << " iterations, residual " << left / goal
                  << " of the goal\n";
        check(gmres.iterations() <= most, "no more iterations than allowed");
        check(left <= 1.001 * goal, "the true residual is what it knows of");
      }
    Gmres few(product, halved, n);
    check(!few.solve(x, b, 1e-9 * b.l2_norm(), 5) && few.iterations() == 5 &&
            !few.is_broken(),
          "it stops at the limit, and says that the goal is not reached");
  }

  void
  test_ends()
  {
    const Divided one(1.);
    const Vector  b    = right_side();
    const auto    none = [](const unsigned int) { return 0.; };
    Vector        x(b), zero(b);
    zero = 0.;
    {
      const Matrix three =
        make_matrix([](const unsigned int i) { return 1. + i % 3; }, none);
      NodeProduct product(1);
      product.set(three);
      Gmres gmres(product, one, n);
      check(gmres.solve(x, b, 1e-12 * b.l2_norm(), n) &&
              gmres.iterations() <= 3,
            "three eigenvalues: three iterations");
      check(gmres.solve(x, zero, 1e-12, n) && gmres.iterations() == 0 &&
              x.l2_norm() == 0.,
            "no right side: nothing to do");
    }
    {
      const Matrix singular =
        make_matrix([](const unsigned int i) { return i == 0 ? 0. : 1.; },
                    none);
      NodeProduct product(1);
      product.set(singular);
      Gmres gmres(product, one, n);
      check(!gmres.solve(x, b, 1e-9 * b.l2_norm(), 200),
            "a singular matrix is not solved");
    }
    {
      const Matrix wrong = make_matrix(
        [](const unsigned int i) { return i == 3 ? std::nan("") : 1.; }, none);
      NodeProduct product(1);
      product.set(wrong);
      Gmres gmres(product, one, n);
      check(!gmres.solve(x, b, 1e-9, 200) && gmres.is_broken() &&
              gmres.iterations() < 3,
            "numbers that are none are told at once");
    }
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  test_solves();
  test_ends();
  return test::report();
}
