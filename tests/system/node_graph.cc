// Blocks of nodes that go straight to their places make C^T A C of their sum
// A: groups of all sizes, that overlap, lie in one another or have nothing in
// common, with unknowns that are fixed or follow; in both orders of the
// block's numbers, and again in other orders of the groups. A graph on which
// the same nodes meet takes over a pattern.

#include <emmy/system/node_graph.h>

#include "../check.h"

#include <algorithm>
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

  Block
  random_block(const unsigned int n)
  {
    Block block(n, n);
    for (unsigned int i = 0; i < n; ++i)
      for (unsigned int j = 0; j < n; ++j)
        block(i, j) = 1. + below(1000) + (i == j ? 1e4 : 0.);
    return block;
  }

  template <int dim>
  void
  add_to_sum(const Group         &group,
             const Block         &block,
             Block               &sum,
             std::vector<double> &diagonal)
  {
    const auto dof = [&](const unsigned int i) {
      return dim * group[i / dim] + i % dim;
    };
    for (unsigned int i = 0; i < block.m(); ++i)
      for (unsigned int j = 0; j < block.m(); ++j)
        {
          sum(dof(i), dof(j)) += block(i, j);
          diagonal[dof(i)] += i == j ? block(i, j) : 0.;
        }
  }

  /** [((i dim + j) n + a) n + b] of a block. */
  template <int dim>
  std::vector<double>
  by_component(const Block &block)
  {
    std::vector<double> values;
    const unsigned int  n = block.m() / dim;
    for (unsigned int ij = 0; ij < dim * dim; ++ij)
      for (unsigned int a = 0; a < n; ++a)
        for (unsigned int b = 0; b < n; ++b)
          values.push_back(block(dim * a + ij / dim, dim * b + ij % dim));
    return values;
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

  /** Two graphs of the same nodes, and a matrix of each. */
  template <int dim>
  struct Graphs
  {
    Graphs()
    {
      make(groups, graph, nullptr);
      make(groups, again, &graph);
      graph.reinit(by_unknowns);
      again.reinit(by_components);
    }

    void
    make(const std::vector<Group> &groups,
         NodeGraph<dim>           &made,
         const NodeGraph<dim>     *from) const
    {
      std::vector<typename NodeGraph<dim>::Clique> cliques;
      for (const Group &group : groups)
        cliques.push_back(
          {group.data(), static_cast<unsigned int>(group.size())});
      std::vector<dealii::types::global_dof_index> first_dofs;
      for (unsigned int node = 0; node < n_nodes; ++node)
        first_dofs.push_back(dim * node);
      made.make(cliques,
                first_dofs,
                dealii::complete_index_set(dim * n_nodes),
                conditions<dim>(),
                MPI_COMM_SELF,
                from);
    }

    /** Add blocks of groups, in both orders of their numbers. */
    void
    check(const std::vector<Group> &groups, const std::string &what)
    {
      Block               sum(dim * n_nodes, dim * n_nodes);
      std::vector<double> diagonal(dim * n_nodes);
      graph.clear(by_unknowns);
      again.clear(by_components);
      for (const Group &group : groups)
        {
          const Block block = random_block(dim * group.size());
          add_to_sum<dim>(group, block, sum, diagonal);
          graph.add(group.data(), block, by_unknowns);
          const unsigned int        n      = group.size();
          const std::vector<double> values = by_component<dim>(block);
          again.add(group.data(),
                    ComponentBlocks{values.data(), n, dim * n * n, n * n, n},
                    by_components);
        }
      graph.finish(by_unknowns);
      again.finish(by_components);
      const Block  expected = condensed<dim>(sum, diagonal);
      const double largest  = expected.linfty_norm();
      test::check(largest > 1e5, where + what + "there is something");
      test::check_close(difference(by_unknowns, expected),
                        0.,
                        1e-14 * largest,
                        where + what + "C^T A C");
      test::check_close(difference(by_components, expected),
                        0.,
                        1e-14 * largest,
                        where + what +
                          "component by component, with another's pattern");
    }

    const std::vector<Group> groups = runs_of_nodes();
    const std::string        where  = std::to_string(dim) + "D: ";
    NodeGraph<dim>           graph, again;
    Matrix                   by_unknowns, by_components;
  };

  /** Places that were found for groups serve for no others. */
  template <int dim>
  void
  check_sums()
  {
    Graphs<dim> graphs;
    graphs.check(graphs.groups, "");
    graphs.check(graphs.groups, "the same again, ");
    std::vector<Group> others = graphs.groups;
    std::reverse(others[50].begin(), others[50].end());
    others[60].assign(others[62].begin() + 1, others[62].begin() + 5);
    graphs.check(others, "as many nodes, ");
    others.erase(others.begin() + 20);
    others.insert(others.begin() + 80, graphs.groups[20]);
    graphs.check(others, "in another order, ");
    others.resize(100);
    graphs.check(others, "fewer, ");
    graphs.check(graphs.groups, "the first again, ");

    // where fewer nodes meet the pattern is another
    NodeGraph<dim> other;
    Matrix         fewer;
    graphs.make({graphs.groups.begin(), graphs.groups.begin() + 20},
                other,
                &graphs.graph);
    other.reinit(fewer);
    test::check(fewer.n_nonzero_elements() <
                  graphs.by_unknowns.n_nonzero_elements(),
                graphs.where + "nodes that do not meet have no entries");
  }

  template <int dim>
  void
  check_components()
  {
    Graphs<dim>  graphs;
    unsigned int n_plain = 0;
    for (const Group &group : graphs.groups)
      {
        const Block nodal = random_block(group.size());
        Block       block(dim * group.size(), dim * group.size());
        bool        is_plain = true;
        for (unsigned int a = 0; a < group.size(); ++a)
          {
            is_plain =
              is_plain && group[a] != 10 && group[a] != 50 && group[a] != 70;
            for (unsigned int b = 0; b < group.size(); ++b)
              for (unsigned int c = 0; c < dim; ++c)
                block(dim * a + c, dim * b + c) = nodal(a, b);
          }
        n_plain += is_plain;
        graphs.graph.add(group.data(), block, graphs.by_unknowns);
        graphs.again.add_components(group.data(), nodal, graphs.by_components);
      }
    test::check(n_plain > 10 && n_plain < graphs.groups.size() - 10,
                graphs.where + "groups with and without conditions");
    const double size = graphs.by_unknowns.linfty_norm();
    graphs.by_components.add(-1., graphs.by_unknowns);
    test::check_close(graphs.by_components.linfty_norm(),
                      0.,
                      1e-14 * size,
                      graphs.where + "the same matrix for each component");
  }

  template <int dim>
  void
  check_far_nodes()
  {
    Graphs<dim> graphs;
    const Group far{0, n_nodes - 1};
    Block       diagonal(2 * dim, 2 * dim);
    for (unsigned int i = 0; i < 2 * dim; ++i)
      diagonal(i, i) = 3.;
    graphs.graph.add(far.data(), diagonal, graphs.by_unknowns);
    double sum = 0.;
    for (const auto &entry : graphs.by_unknowns)
      sum += std::abs(entry.value());
    const auto meets_itself = [&](const unsigned int node) {
      return graphs.graph.row(node).n > 0;
    };
    test::check_close(sum,
                      3. * dim * (meets_itself(far[0]) + meets_itself(far[1])),
                      1e-14,
                      graphs.where + "what does not meet is left out");
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_sums<2>();
  check_sums<3>();
  check_components<2>();
  check_components<3>();
  check_far_nodes<2>();
  check_far_nodes<3>();
  return test::report();
}
