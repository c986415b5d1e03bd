// Products in blocks of nodes are those of Trilinos, and matrices without such
// blocks are told; what ranks exchange of nodes comes from their owners, and
// sums go there. On any number of ranks, one without rows too.

#include <deal.II/lac/trilinos_sparsity_pattern.h>

#include <emmy/solve/node_product.h>

#include <cmath>

#include "../check.h"

using namespace emmy;
using test::check;
using test::check_close;

namespace
{
  const MPI_Comm world = MPI_COMM_WORLD;

  /** Nodes of this rank, none on the last one of several. */
  dealii::IndexSet
  own_nodes(const unsigned int n)
  {
    using namespace dealii::Utilities::MPI;
    const unsigned int rank    = this_mpi_process(world),
                       n_parts = std::max(1u, n_mpi_processes(world) - 1);
    const auto first           = [&](const unsigned int part) {
      return n * std::min(part, n_parts) / n_parts;
    };
    dealii::IndexSet nodes(n);
    nodes.add_range(first(rank), first(rank + 1));
    nodes.compress();
    return nodes;
  }

  /** A ring of nodes, each with its neighbours and one across. */
  void
  test_products(const unsigned int dim, const bool in_blocks)
  {
    constexpr unsigned int n = 40;
    dealii::IndexSet       rows(dim * n);
    for (const auto node : own_nodes(n))
      rows.add_range(dim * node, dim * (node + 1));
    rows.compress();
    const auto for_each = [&](const auto &use) {
      for (const auto i : rows)
        for (const unsigned int step : {0u, 1u, n - 1, n / 2})
          for (unsigned int d = 0; d < dim; ++d)
            if (in_blocks || i != 0 || step != 1 || d > 0)
              use(i, dim * ((i / dim + step) % n) + d);
    };
    dealii::TrilinosWrappers::SparsityPattern pattern(rows, world);
    for_each([&](const auto i, const auto j) { pattern.add(i, j); });
    pattern.compress();
    Matrix      matrix;
    NodeProduct product(dim);
    Vector      x(rows, world), expected(x), found(x);
    for (const auto i : rows)
      x(i) = std::sin(1. + i * i);
    x.compress(dealii::VectorOperation::insert);
    for (const double factor : {1., 2.}) // the second has the same pattern
      {
        matrix.reinit(pattern);
        for_each([&](const auto i, const auto j) {
          matrix.set(i, j, factor * std::cos(i + 3. * j));
        });
        matrix.compress(dealii::VectorOperation::insert);
        product.set(matrix);
        check(product.is_in_blocks() == in_blocks, "blocks are known");
        matrix.vmult(expected, x);
        product.vmult(found, x);
        const double left = product.residual(found, x, expected);
        check_close(left / expected.l2_norm(), 0., 1e-15, "A x - A x");
        check_close(found.l2_norm(), left, 1e-30, "its norm");
      }
  }

  /** Each rank also knows the two nodes beyond its own, of a ring. */
  void
  test_exchange()
  {
    constexpr unsigned int n = 30, n_numbers = 2;
    const auto             own = own_nodes(n);
    dealii::IndexSet       others(n);
    if (own.n_elements() > 0)
      for (const auto other :
           {(*own.begin() + n - 1) % n, (*own.begin() + own.n_elements()) % n})
        if (!own.is_element(other))
          others.add_index(other);
    others.compress();
    const NodeExchange exchange(
      dealii::Utilities::MPI::Partitioner(own, others, world));
    const auto value = [](const auto node, const unsigned int c) {
      return 1. + 10. * node + c;
    };
    std::vector<double> of_own, of_others(n_numbers * others.n_elements());
    for (const auto node : own)
      for (unsigned int c = 0; c < n_numbers; ++c)
        of_own.push_back(value(node, c));
    exchange.update(of_own.data(), n_numbers, of_others.data());
    auto found = of_others.begin();
    for (const auto node : others)
      for (unsigned int c = 0; c < n_numbers; ++c)
        check(*found++ == value(node, c), "the owner's value");

    exchange.add(of_own.data(), n_numbers, of_others.data());
    double sum = 0., expected = 0.; // what is known twice counts twice
    for (const double v : of_own)
      sum += v;
    for (const double v : of_others)
      expected += v;
    for (const auto node : own)
      expected += value(node, 0) + value(node, 1);
    check_close(dealii::Utilities::MPI::sum(sum, world),
                dealii::Utilities::MPI::sum(expected, world),
                1e-9,
                "sums come to the owners");
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  for (const unsigned int dim : {2u, 3u})
    for (const bool in_blocks : {true, false})
      test_products(dim, in_blocks);
  test_exchange();
  return test::report();
}
