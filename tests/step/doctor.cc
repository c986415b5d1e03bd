// The condition estimate against closed forms and a singular value
// decomposition, on any number of ranks; what the doctor finds where a sliver
// of a block enters a new column of cells, with and without ghost
// stabilisation.

#include <deal.II/lac/lapack_full_matrix.h>

#include <emmy/step/doctor.h>

#include "../check.h"

using namespace emmy;

namespace
{
  /** A matrix whose rows are dealt out to all ranks, with its constraints. */
  struct Example
  {
    dealii::IndexSet                  rows;
    Matrix                            matrix;
    dealii::AffineConstraints<double> constraints;
    Vector                            start;

    explicit Example(const dealii::FullMatrix<double> &entries)
      : rows(dealii::Utilities::create_evenly_distributed_partitioning(
          dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD),
          dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD),
          entries.m()))
    {
      dealii::TrilinosWrappers::SparsityPattern pattern(rows, MPI_COMM_WORLD);
      for (const auto i : rows)
        for (unsigned int j = 0; j < entries.n(); ++j)
          pattern.add(i, j);
      pattern.compress();
      matrix.reinit(pattern);
      for (const auto i : rows)
        for (unsigned int j = 0; j < entries.n(); ++j)
          matrix.set(i, j, entries(i, j));
      matrix.compress(dealii::VectorOperation::insert);
      start.reinit(rows, MPI_COMM_WORLD);
      for (const auto i : rows)
        start(i) = std::sin(3. * i + 1.);
    }

    ConditionEstimate
    estimate()
    {
      constraints.close();
      return condition_estimate(matrix, constraints, start);
    }
  };

  /** The index of the entry of size one, on all ranks. */
  unsigned int
  largest_entry(const Vector &vector)
  {
    unsigned int result = 0;
    for (const auto i : vector.locally_owned_elements())
      if (std::abs(vector(i)) > 0.999)
        result = i;
    return dealii::Utilities::MPI::max(result, MPI_COMM_WORLD);
  }

  /**
   * Blocks (1 c; 0 1), scaled with powers of ten that the estimate must not
   * see. Their singular values are (sqrt(c^2 + 4) +- c)/2, and the unknown
   * that the largest c hides is the first of its block.
   */
  void
  check_shears()
  {
    const std::vector<double>  shears{0.1, 2., 1e5, -30., 0.};
    dealii::FullMatrix<double> entries(10, 10);
    const auto                 scale = [](const unsigned int i) {
      return std::pow(10., static_cast<int>(3 * i % 7) - 3);
    };
    for (unsigned int block = 0; block < shears.size(); ++block)
      {
        const unsigned int i  = 2 * block;
        entries(i, i)         = scale(i) * scale(i);
        entries(i + 1, i + 1) = -scale(i + 1) * scale(i + 1);
        entries(i, i + 1)     = shears[block] * scale(i) * scale(i + 1);
      }
    const auto condition = [](const double c) {
      return std::pow((std::sqrt(c * c + 4.) + c) / 2., 2);
    };
    Example    example(entries);
    const auto estimate = example.estimate();
    test::check_close(estimate.condition() / condition(1e5),
                      1.,
                      1e-5,
                      "condition of a shear of 1e5");
    test::check_close(estimate.largest * estimate.smallest,
                      1.,
                      1e-5,
                      "a shear's singular values are inverse");
    test::check(largest_entry(estimate.weakest) == 4, "the weakest unknown");

    // a constrained unknown is not there
    example.constraints.add_line(4);
    const auto less = example.estimate();
    test::check_close(less.condition() / condition(30.),
                      1.,
                      1e-5,
                      "condition without the largest shear");
    for (const auto i : less.weakest.locally_owned_elements())
      test::check(i != 4 || less.weakest(i) == 0., "nor is it weak");

    // on transposing, the other unknown of the block is hidden
    dealii::FullMatrix<double> transposed(10, 10);
    transposed.copy_transposed(entries);
    const auto other = Example(transposed).estimate();
    test::check_close(other.condition() / condition(1e5),
                      1.,
                      1e-5,
                      "condition of the transposed matrix");
  }

  /** 1/(i + j + 1), scaled to a unit diagonal. */
  dealii::FullMatrix<double>
  hilbert(const unsigned int n)
  {
    dealii::FullMatrix<double> entries(n, n);
    for (unsigned int i = 0; i < n; ++i)
      for (unsigned int j = 0; j < n; ++j)
        entries(i, j) = std::sqrt((2. * i + 1.) * (2. * j + 1.)) / (i + j + 1.);
    return entries;
  }

  void
  check_hilbert()
  {
    for (const unsigned int n : {1, 3, 6, 9})
      {
        dealii::LAPACKFullMatrix<double> copy(n, n);
        copy = hilbert(n);
        copy.compute_svd();
        const double exact =
          copy.singular_value(0) / copy.singular_value(n - 1);
        const double found = Example(hilbert(n)).estimate().condition();
        std::cout << "Hilbert " << n << ": condition " << found << ", exact "
                  << exact << '\n';
        test::check_close(found / exact,
                          1.,
                          1e-5 + 1e-15 * exact,
                          "condition of a scaled Hilbert matrix");
      }
  }

  void
  check_singular()
  {
    // rank one, as the mass of a single particle
    dealii::FullMatrix<double> entries(4, 4);
    for (unsigned int i = 0; i < 4; ++i)
      for (unsigned int j = 0; j < 4; ++j)
        entries(i, j) = (1. + i) * (1. + j);
    test::check(Example(entries).estimate().is_singular(), "rank one");
    // an unknown that nothing reaches
    dealii::FullMatrix<double> missing = hilbert(4);
    for (unsigned int i = 0; i < 4; ++i)
      missing(2, i) = missing(i, 2) = 0.;
    const auto estimate = Example(missing).estimate();
    test::check(estimate.is_singular(), "a row of zeros");
    test::check(largest_entry(estimate.weakest) == 2, "which row");
    const double nan = std::numeric_limits<double>::quiet_NaN();
    missing(0, 1)    = nan;
    test::check(std::isnan(Example(missing).estimate().condition()),
                "no estimate of what is no number");
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_shears();
  check_hilbert();
  check_singular();
  return test::report();
}
