// Blocks that are summed before they go to a matrix make the same matrix as
// blocks that go there one by one: groups of all sizes, that overlap, lie in
// one another or have nothing in common, with unknowns that are fixed or
// follow.

#include <emmy/system/block_sum.h>

#include "../check.h"

#include <random>

using namespace emmy;

namespace
{
  template <int dim>
  void
  check_sum()
  {
    constexpr unsigned int n_nodes = 120;
    std::mt19937           generator(7);
    const auto             below = [&](const unsigned int n) {
      return std::uniform_int_distribution<unsigned int>(0, n - 1)(generator);
    };

    // runs of nodes; some begin where the one before did, and are longer
    std::vector<std::vector<unsigned int>> groups;
    for (unsigned int i = 0; i < 200; ++i)
      {
        const unsigned int n =
          i % 3 == 0 ? 4 : (i % 3 == 1 ? 27 : 28 + below(36));
        const unsigned int first =
          i % 3 == 0 ? below(n_nodes - 64) : groups.back().front();
        groups.emplace_back();
        for (unsigned int a = 0; a < n; ++a)
          groups.back().push_back(first + a);
      }

    const unsigned int n_dofs = dim * n_nodes;
    dealii::IndexSet   all    = dealii::complete_index_set(n_dofs);
    Constraints        constraints(
      std::make_shared<dealii::Utilities::MPI::Partitioner>(n_dofs));
    for (unsigned int c = 0; c < dim; ++c)
      {
        constraints.fix(dim * 10 + c);
        constraints.follow(dim * 50 + c,
                           {{dim * 51 + c, 0.75}, {dim * 30 + c, 0.25}});
      }
    constraints.fix(dim * 70); // one component of a node
    constraints.close(true);

    std::vector<typename NodeGraph<dim>::Clique> cliques;
    std::vector<dealii::types::global_dof_index> first_dofs;
    for (const auto &group : groups)
      cliques.push_back(
        {group.data(), static_cast<unsigned int>(group.size())});
    for (unsigned int node = 0; node < n_nodes; ++node)
      first_dofs.push_back(dim * node);
    NodeGraph<dim> graph;
    graph.make(cliques, first_dofs, all, constraints, MPI_COMM_SELF);

    Matrix one_by_one, in_components, summed;
    graph.reinit(one_by_one);
    graph.reinit(in_components);
    graph.reinit(summed);
    BlockSum<dim> sum(graph, summed);
    double        largest = 0.;
    for (const auto &group : groups)
      {
        const unsigned int         n = dim * group.size();
        dealii::FullMatrix<double> block(n, n);
        for (unsigned int i = 0; i < n; ++i)
          for (unsigned int j = 0; j < n; ++j)
            block(i, j) = 1. + below(1000) + (i == j ? 1e4 : 0.);
        graph.add(group.data(), block, one_by_one);
        const unsigned int  n_group = group.size();
        std::vector<double> values;
        for (unsigned int ij = 0; ij < dim * dim; ++ij)
          for (unsigned int a = 0; a < n_group; ++a)
            for (unsigned int b = 0; b < n_group; ++b)
              values.push_back(block(dim * a + ij / dim, dim * b + ij % dim));
        const ComponentBlocks blocks{values.data(),
                                     n_group,
                                     dim * n_group * n_group,
                                     n_group * n_group,
                                     n_group};
        graph.add(group.data(), blocks, in_components);
        sum.add(group.data(), blocks);
      }
    sum.flush();
    graph.finish(one_by_one);
    graph.finish(in_components);
    graph.finish(summed);
    largest = one_by_one.linfty_norm();
    in_components.add(-1., one_by_one);
    test::check_close(in_components.linfty_norm(),
                      0.,
                      1e-14 * largest,
                      std::to_string(dim) + "D: in both orders");
    summed.add(-1., one_by_one);
    test::check(largest > 1e5, "there is something to compare");
    test::check_close(summed.linfty_norm(),
                      0.,
                      1e-14 * largest,
                      std::to_string(dim) + "D: summed and one by one");
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_sum<2>();
  check_sum<3>();
  return test::report();
}
