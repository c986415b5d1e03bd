// Blocks of nodes that go straight to their places make C^T A C of their sum
// A: groups of all sizes, that overlap, lie in one another or have nothing in
// common, with unknowns that are fixed or follow; in both orders of the
// block's numbers. A graph on which the same nodes meet takes over a pattern.

#include <emmy/system/node_graph.h>

#include "../check.h"

#include <random>

using namespace emmy;

namespace
{
  constexpr unsigned int n_nodes = 120;

  using Group = std::vector<unsigned int>;
  using Block = dealii::FullMatrix<double>;

  unsigned int
  below(const unsigned int n)
  {
    static std::mt19937 generator(7);
    return std::uniform_int_distribution<unsigned int>(0, n - 1)(generator);
  }

  /** Runs of nodes; some begin where the one before did, and are longer. */
  std::vector<Group>
  runs_of_nodes()
  {
    std::vector<Group> groups;
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
    return groups;
  }

  /** Node 10 is fixed, node 50 follows two, and one component of 70 is fixed.
   */
  template <int dim>
  Constraints
  conditions()
  {
    Constraints constraints(
      std::make_shared<dealii::Utilities::MPI::Partitioner>(dim * n_nodes));
    for (unsigned int c = 0; c < dim; ++c)
      {
        constraints.fix(dim * 10 + c);
        constraints.follow(dim * 50 + c,
                           {{dim * 51 + c, 0.75}, {dim * 30 + c, 0.25}});
      }
    constraints.fix(dim * 70);
    constraints.close(true);
    return constraints;
  }

  /** C^T A C, with @p diagonal where there is a condition. */
  template <int dim>
  Block
  condensed(const Block &A, const std::vector<double> &diagonal)
  {
    Block C = dealii::IdentityMatrix(A.m());
    for (unsigned int c = 0; c < dim; ++c)
      {
        C(dim * 10 + c, dim * 10 + c) = C(dim * 50 + c, dim * 50 + c) = 0.;
        C(dim * 50 + c, dim * 51 + c)                                 = 0.75;
        C(dim * 50 + c, dim * 30 + c)                                 = 0.25;
      }
    C(dim * 70, dim * 70) = 0.;
    Block result(A.m(), A.m());
    result.triple_product(A, C, C, /*transpose_B=*/true);
    for (unsigned int i = 0; i < A.m(); ++i)
      if (C(i, i) == 0.)
        result(i, i) = diagonal[i];
    return result;
  }

  double
  difference(const Matrix &matrix, const Block &expected)
  {
    double largest = 0.;
    for (unsigned int i = 0; i < expected.m(); ++i)
      for (unsigned int j = 0; j < expected.n(); ++j)
        largest = std::max(largest, std::abs(matrix.el(i, j) - expected(i, j)));
    return largest;
  }

  template <int dim>
  void
  check_sum()
  {
    const std::vector<Group>                     groups = runs_of_nodes();
    const unsigned int                           n_dofs = dim * n_nodes;
    std::vector<typename NodeGraph<dim>::Clique> cliques;
    std::vector<dealii::types::global_dof_index> first_dofs;
    for (const Group &group : groups)
      cliques.push_back(
        {group.data(), static_cast<unsigned int>(group.size())});
    for (unsigned int node = 0; node < n_nodes; ++node)
      first_dofs.push_back(dim * node);
    NodeGraph<dim> graph, again;
    const auto make = [&](NodeGraph<dim> &made, const NodeGraph<dim> *from) {
      made.make(cliques,
                first_dofs,
                dealii::complete_index_set(n_dofs),
                conditions<dim>(),
                MPI_COMM_SELF,
                from);
    };
    make(graph, nullptr);
    make(again, &graph);

    Matrix by_unknowns, by_components;
    graph.reinit(by_unknowns);
    again.reinit(by_components);
    Block               sum(n_dofs, n_dofs);
    std::vector<double> diagonal(n_dofs);
    for (const Group &group : groups)
      {
        const unsigned int n = dim * group.size();
        Block              block(n, n);
        const auto         dof = [&](const unsigned int i) {
          return dim * group[i / dim] + i % dim;
        };
        for (unsigned int i = 0; i < n; ++i)
          for (unsigned int j = 0; j < n; ++j)
            {
              block(i, j) = 1. + below(1000) + (i == j ? 1e4 : 0.);
              sum(dof(i), dof(j)) += block(i, j);
              diagonal[dof(i)] += i == j ? block(i, j) : 0.;
            }
        graph.add(group.data(), block, by_unknowns);
        const unsigned int  n_group = group.size();
        std::vector<double> values;
        for (unsigned int ij = 0; ij < dim * dim; ++ij)
          for (unsigned int a = 0; a < n_group; ++a)
            for (unsigned int b = 0; b < n_group; ++b)
              values.push_back(block(dim * a + ij / dim, dim * b + ij % dim));
        again.add(group.data(),
                  ComponentBlocks{values.data(),
                                  n_group,
                                  dim * n_group * n_group,
                                  n_group * n_group,
                                  n_group},
                  by_components);
      }
    graph.finish(by_unknowns);
    again.finish(by_components);
    const Block       expected = condensed<dim>(sum, diagonal);
    const double      largest  = expected.linfty_norm();
    const std::string where    = std::to_string(dim) + "D: ";
    test::check(largest > 1e5, where + "there is something to compare");
    test::check_close(difference(by_unknowns, expected),
                      0.,
                      1e-14 * largest,
                      where + "C^T A C");
    test::check_close(difference(by_components, expected),
                      0.,
                      1e-14 * largest,
                      where + "component by component, with another's pattern");

    // where fewer nodes meet the pattern is another
    cliques.resize(20);
    NodeGraph<dim> other;
    make(other, &graph);
    Matrix fewer;
    other.reinit(fewer);
    test::check(fewer.n_nonzero_elements() < by_unknowns.n_nonzero_elements(),
                where + "nodes that do not meet have no entries");
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
