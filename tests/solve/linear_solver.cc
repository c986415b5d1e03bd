// What "automatic" does: it takes the direct solver where GMRES fails, and says
// so; all methods solve regular matrices, with all preconditioners; a singular
// matrix is reported in words; pairs of nodes that do not meet can be left
// out. On any number of ranks, one without rows too.

#include <deal.II/lac/trilinos_sparsity_pattern.h>

#include <emmy/solve/empty_pairs.h>
#include <emmy/solve/linear_solver.h>

#include "../check.h"

using namespace emmy;
using test::check;
using test::check_close;

namespace
{
  constexpr unsigned int n = 1500, n_components = 3;

  const MPI_Comm world = MPI_COMM_WORLD;

  /** Rows of this rank: of whole nodes, and at will none on the last rank. */
  dealii::IndexSet
  own_rows(const bool last_is_empty)
  {
    const unsigned int rank = dealii::Utilities::MPI::this_mpi_process(world),
                       n_ranks = dealii::Utilities::MPI::n_mpi_processes(world),
                       n_parts = std::max(1u, n_ranks - last_is_empty),
                       n_nodes = n / n_components;
    const auto first           = [&](const unsigned int part) {
      return n_components * (n_nodes * std::min(part, n_parts) / n_parts);
    };
    dealii::IndexSet rows(n);
    rows.add_range(first(rank), first(rank + 1));
    rows.compress();
    return rows;
  }

  using Entries = std::vector<std::pair<unsigned int, double>>;

  /** Rows with the entries (column, value) that @p row gives. */
  template <class Row>
  Matrix
  make_matrix(const Row &row, const bool last_is_empty = false)
  {
    const auto                                rows = own_rows(last_is_empty);
    dealii::TrilinosWrappers::SparsityPattern pattern(rows, world);
    for (const auto i : rows)
      for (const auto &entry : row(i))
        pattern.add(i, entry.first);
    pattern.compress();
    Matrix matrix;
    matrix.reinit(pattern);
    for (const auto i : rows)
      for (const auto &[column, value] : row(i))
        matrix.set(i, column, value);
    matrix.compress(dealii::VectorOperation::insert);
    return matrix;
  }

  /** A vector for a matrix, with the entries of a function. */
  template <class Entry>
  Vector
  make_vector(const Matrix &matrix, const Entry &entry)
  {
    const auto rows = matrix.locally_owned_range_indices();
    Vector     result(rows, world);
    for (const auto i : rows)
      result(i) = entry(i);
    result.compress(dealii::VectorOperation::insert);
    return result;
  }

  /** Of all frequencies. */
  double
  wave(const unsigned int i)
  {
    return std::sin(1. + i * i);
  }

  /** |A x - b| / |b| for a b that has all frequencies, or what went wrong. */
  std::pair<double, std::string>
  solve(LinearSolver &solver, const Matrix &matrix)
  {
    const Vector b = make_vector(matrix, wave);
    Vector       x(b), residual(b);
    LinearResult result = solver.prepare(matrix);
    if (result.is_solved)
      result = solver.solve(x, b, 1e-8);
    if (!result.is_solved)
      return {1., result.problem};
    return {matrix.residual(residual, x, b) / b.l2_norm(), ""};
  }

  /** A mass of hats, with rows and columns of given sizes. */
  template <class Size>
  Matrix
  mass_of_hats(const Size &size, const bool last_is_empty = false)
  {
    return make_matrix(
      [&size](const unsigned int i) {
        Entries entries{{i, 4. * size(i) * size(i)}};
        for (const unsigned int j : {i - 1, i + 1})
          if (j < n)
            entries.push_back({j, size(i) * size(j)});
        return entries;
      },
      last_is_empty);
  }

  double
  one(const unsigned int)
  {
    return 1.;
  }

  /** A cyclic shift: GMRES needs n iterations. Without a diagonal ILU cannot
   * be made either. */
  Matrix
  shift(const double diagonal)
  {
    return make_matrix([diagonal](const unsigned int i) {
      return Entries{{i, diagonal}, {(i + 1) % n, 1.}};
    });
  }

  void
  check_automatic()
  {
    const Matrix easy = mass_of_hats(one), hard = shift(0.5),
                 hopeless = shift(0.);
    SolverParameters parameters;
    for (const Matrix *matrix : {&hard, &hopeless})
      {
        const auto automatic = make_linear_solver(parameters, n, n_components);
        check_close(solve(*automatic, easy).first, 0., 1e-8, "easy matrix");
        check(automatic->name() == "GMRES with ILU",
              "GMRES is enough, not " + automatic->name());
        check_close(solve(*automatic, *matrix).first, 0., 1e-8, "hard matrix");
        // the direct solver stays for 2 matrices, then GMRES has its turn;
        // when it has failed again, for 4
        for (const unsigned int n_failures : {1u, 2u})
          {
            for (unsigned int i = 0; i < 2 * n_failures; ++i)
              check_close(solve(*automatic, *matrix).first, 0., 1e-8, "LU");
            check(automatic->name().find(
                    "failed " + std::to_string(n_failures) + " times") !=
                    std::string::npos,
                  "LU stays for a while, " + automatic->name());
            solve(*automatic, *matrix);
            check(automatic->name().find(
                    "failed " + std::to_string(n_failures + 1) + " times") !=
                    std::string::npos,
                  "GMRES has its turn, and failed, " + automatic->name());
          }
      }
    const auto small =
      make_linear_solver(SolverParameters(), 300, n_components);
    check(small->name() == "direct (KLU)", "small systems: direct");
  }

  /**
   * All methods and preconditioners on regular matrices: one that is
   * symmetric, and one that is not, of three components that are coupled along
   * a line. A rank without rows does not hinder them.
   */
  void
  check_all_methods()
  {
    for (const bool last_is_empty : {false, true})
      {
        const Matrix tangent = make_matrix(
          [](const unsigned int i) {
            Entries entries{{i, 4.}};
            for (const unsigned int j : {i - n_components, i + n_components})
              if (j < n)
                entries.push_back({j, j < i ? -1.5 : -0.9});
            // to another component of the same node
            entries.push_back({i % n_components == 0 ? i + 1 : i - 1, 0.4});
            return entries;
          },
          last_is_empty);
        const Matrix mass = mass_of_hats(one, last_is_empty);
        for (const Matrix *matrix : {&mass, &tangent})
          for (const char *const method : {"direct", "GMRES", "BiCGStab"})
            for (const Choice &preconditioner : preconditioners())
              {
                SolverParameters parameters;
                parameters.linear_solver  = method;
                parameters.preconditioner = preconditioner.name;
                const auto solver =
                  make_linear_solver(parameters, n, n_components);
                const auto [error, problem] = solve(*solver, *matrix);
                check(problem.empty() && error <= 1.1e-8,
                      solver->name() + " solves a regular matrix, |r|/|b| " +
                        std::to_string(error) + ' ' + problem);
              }
      }
  }

  void
  check_singular()
  {
    // the last row is zero
    const Matrix singular = make_matrix([](const unsigned int i) {
      return Entries{{i, i + 1 < n ? 1. : 0.}};
    });
    for (const char *const name : {"automatic", "direct", "GMRES", "BiCGStab"})
      {
        SolverParameters parameters;
        parameters.linear_solver = name;
        const auto solver = make_linear_solver(parameters, n, n_components);
        check(!solve(*solver, singular).second.empty(),
              std::string(name) + " reports a singular matrix");
      }
  }

  /**
   * A mass with rows of very different size, D A D with an A like that of hats
   * in the plane: LU of it as it is chooses pivots by size and loses half of
   * the digits, seen in D x; LU of the scaled one does not. Refined, both are
   * right. Where refinement is not enough stands in tests/scenes/gimp.cc.
   */
  void
  check_scaling()
  {
    const auto size = [](const unsigned int i) {
      return std::pow(10., -9. * ((i * i) % 11) / 10.);
    };
    const auto row_of_a = [](const unsigned int i) {
      Entries entries{{i, 4.}};
      for (const unsigned int distance : {1u, 30u})
        for (const unsigned int j : {i - distance, i + distance})
          if (j < n)
            entries.push_back({j, distance == 1 ? 1. : 0.9});
      return entries;
    };
    const Matrix uneven = make_matrix([&](const unsigned int i) {
      Entries entries = row_of_a(i);
      for (auto &[column, value] : entries)
        value *= size(i) * size(column);
      return entries;
    });
    const Vector b      = make_vector(uneven, [&](const unsigned int i) {
      double sum = 0.;
      for (const auto &[column, value] : row_of_a(i))
        sum += value * wave(column);
      return size(i) * sum;
    });
    const auto   error  = [&](const Vector &x) {
      double largest = 0.;
      for (const auto i : x.locally_owned_elements())
        largest = std::max(largest, std::abs(size(i) * x(i) - wave(i)));
      return dealii::Utilities::MPI::max(largest, world);
    };
    for (const bool is_mass : {false, true})
      {
        const std::string name = is_mass ? "scaled" : "as it is";
        const auto        direct =
          make_linear_solver(SolverParameters(), 300, n_components);
        Vector x(b);
        x = 0.;
        check((is_mass ? direct->prepare_mass(uneven) : direct->prepare(uneven))
                  .is_solved &&
                direct->solve(x, b, 1.).is_solved,
              name + ": LU");
        const double once = error(x);
        check(is_mass ? once < 1e-13 : once > 1e-11,
              name + ": error of one solve " + std::to_string(once * 1e12) +
                "e-12");
        x                      = 0.;
        const auto residual_of = [&](Vector &r, const Vector &y) {
          uneven.residual(r, y, b);
        };
        check(solve_to_round_off(*direct, residual_of, Constraints(), b, x)
                .is_solved,
              name + ": refined");
        check_close(error(x), 0., 1e-13, name + ": error of the refined one");

        // Where GMRES is first, the map's second try must be another one.
        const auto first =
          make_linear_solver(SolverParameters(), 2000, n_components);
        x = 0.;
        check((is_mass ? first->prepare_mass(uneven) : first->prepare(uneven))
                .is_solved,
              name + ", automatic: prepared");
        const LinearResult result =
          solve_to_round_off(*first, residual_of, Constraints(), b, x);
        check((result.iterations == 0) == is_mass,
              "automatic: GMRES first, LU as the second try");
        check(!is_mass || (result.is_solved && error(x) < 1e-13),
              "automatic: the second try solves an uneven mass to round-off");
      }
  }

  /**
   * Without pairs of nodes that have nothing in common a matrix is the same;
   * pairs that come to have something, or no longer do, are seen.
   */
  void
  check_empty_pairs()
  {
    constexpr unsigned int n_nodes = n / n_components, far = 7;
    const auto             row_with = [](const double weight) {
      return [weight](const unsigned int i) {
        Entries            entries;
        const unsigned int node = i / n_components;
        for (const unsigned int other :
             {node, (node + 1) % n_nodes, (node + far) % n_nodes})
          for (unsigned int c = 0; c < n_components; ++c)
            {
              const unsigned int j = n_components * other + c;
              entries.emplace_back(j,
                                   other == node ? (i == j ? 4. : 0.)
                                               : other == (node + far) % n_nodes
                                                 ? weight * wave(i + j)
                                               : c == i % n_components ? 0.5
                                                                       : 0.);
            }
        return entries;
      };
    };
    Matrix            matrix = make_matrix(row_with(0.));
    WithoutEmptyPairs without(n_components);
    const auto        solver = make_linear_solver(
      SolverParameters(), 300, n_components, nullptr, EmptyPairs::left_out);
    const Vector b = make_vector(matrix, wave);
    Vector       x(b), kept(b), all(b);
    for (const double weight : {0., 0.2, 0., 0.3})
      {
        const std::string name = "far pairs times " + std::to_string(weight);
        for (const auto i : matrix.locally_owned_range_indices())
          for (const auto &[column, value] : row_with(weight)(i))
            matrix.set(i, column, value);
        matrix.compress(dealii::VectorOperation::insert);
        const Matrix &reduced = without(matrix);
        check(reduced.n_nonzero_elements() ==
                (weight == 0. ? 2 : 3) * n_components * n,
              name + ": entries that are left");
        reduced.vmult(kept, b);
        matrix.vmult(all, b);
        kept -= all;
        check(kept.linfty_norm() <= 1e-15, name + ": the same matrix");
        check(solver->prepare(matrix).is_solved &&
                solver->solve(x, b, 1.).is_solved,
              name + ": LU");
        check(matrix.residual(kept, x, b) < 1e-13 * b.l2_norm(),
              name + ": solution");
      }
  }

  /**
   * Factors serve for matrices of a sequence that are near, also when theirs is
   * gone; for those that are not, there are others.
   */
  void
  check_kept_factors()
  {
    const auto solver =
      make_linear_solver(SolverParameters(), 300, n_components);
    auto         matrix = std::make_unique<Matrix>();
    const Matrix first  = mass_of_hats(one);
    const Vector b      = make_vector(first, wave);
    NodePlaces   places;
    Vector       x(b), residual(b);
    solver->begin_sequence();
    for (const double change : {0., 1e-3, 1e3})
      {
        auto next = std::make_unique<Matrix>();
        next->reinit(first);
        next->copy_from(first);
        for (const auto i : next->locally_owned_range_indices())
          next->add(i, i, change * (1. + wave(i)));
        next->compress(dealii::VectorOperation::add);
        matrix = std::move(next); // that of the factors is gone
        check(solver->prepare(*matrix, &places).is_solved &&
                solver->solve(x, b, 1.).is_solved,
              "sequence: solved");
        check(matrix->residual(residual, x, b) < 2e-12 * b.l2_norm(),
              "sequence: to round-off, change " + std::to_string(change));
      }
  }

  /** Where LU is not dear it takes the sixth matrix of a sequence. */
  void
  check_long_sequence()
  {
    if (dealii::Utilities::MPI::n_mpi_processes(world) > 2)
      return; // else parts have no whole nodes of two unknowns
    const auto   solver = make_linear_solver(SolverParameters(), n, 2);
    const Matrix matrix = mass_of_hats(one);
    const Vector b      = make_vector(matrix, wave);
    Vector       x(b), residual(b);
    for (unsigned int sequence = 0; sequence < 2; ++sequence)
      {
        solver->begin_sequence();
        for (unsigned int k = 0; k < 7; ++k)
          {
            solver->prepare(matrix);
            const LinearResult result = solver->solve(x, b, 0.1);
            check(result.is_solved && (result.iterations == 0) == (k >= 5),
                  "long sequence: LU from the sixth matrix on, not before");
            check(matrix.residual(residual, x, b) <= 1e-8 * b.l2_norm(),
                  "where LU is not dear GMRES goes to 1e-8");
          }
      }
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_automatic();
  check_all_methods();
  check_singular();
  check_scaling();
  check_empty_pairs();
  check_kept_factors();
  check_long_sequence();
  return test::report();
}
