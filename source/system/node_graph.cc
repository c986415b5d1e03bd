#include <emmy/base/exceptions.h>
#include <emmy/base/index_limits.h>
#include <emmy/base/unknown.h>
#include <emmy/system/block_adder.h>
#include <emmy/system/matrix_pattern.h>
#include <emmy/system/node_graph.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_MpiComm.h>

#include <algorithm>
#include <map>

namespace emmy
{
  using dealii::types::global_dof_index;

  template <int dim>
  void
  NodeGraph<dim>::make(const std::vector<Clique> &cliques,
                       const Dofs                &first_dofs,
                       const dealii::IndexSet    &owned_dofs,
                       const Constraints         &constraints,
                       const MPI_Comm             communicator,
                       const NodeGraph *const     before)
  {
    this->first_dofs = first_dofs;
    n_owned          = owned_dofs.n_elements() / dim;
    note_conditions(constraints);
    find_plain_nodes();
    find_neighbours(cliques);
    adder =
      std::make_unique<BlockAdder<dim>>(*this,
                                        before ? before->adder.get() : nullptr);
    const bool is_same = before && first_dofs == before->first_dofs &&
                         n_owned == before->n_owned && first == before->first &&
                         neighbours == before->neighbours;
    if (dealii::Utilities::MPI::min(is_same ? 1 : 0, communicator) == 1)
      {
        foreign = before->foreign;
        places  = before->places;
        pattern = before->pattern;
        return;
      }
    refuse_matrix_entries(dim * dim * neighbours.size(), communicator);
    foreign.make(first_dofs, owned_dofs, first, neighbours, communicator);
    make_pattern(owned_dofs, communicator);
  }

  template <int dim>
  NodeGraph<dim>::NodeGraph() = default;

  template <int dim>
  NodeGraph<dim>::~NodeGraph() = default;

  template <int dim>
  void
  NodeGraph<dim>::reinit(Matrix &matrix) const
  {
    matrix.reinit(*pattern, /*copy_values=*/false);
    clear(matrix); // the rows of others
  }

  template <int dim>
  void
  NodeGraph<dim>::clear(Matrix &matrix) const
  {
    const Epetra_CrsMatrix &entries = matrix.trilinos_matrix();
    for (int row = 0; row < entries.NumMyRows(); ++row)
      std::fill_n(entries[row], entries.NumMyEntries(row), 0.);
    adder->begin();
    // what an evaluation left that did not come to its end
    for (unsigned int node = n_owned; node < n_nodes(); ++node)
      std::fill_n(foreign.row(node, 0), dim * dim * row(node).n, 0.);
  }

  template <int dim>
  void
  NodeGraph<dim>::finish(Matrix &matrix) const
  {
    foreign.hand_over(matrix);
  }

  template <int dim>
  std::uint64_t
  NodeGraph<dim>::n_nonzeros() const
  {
    if (!pattern)
      return 0;
    return dealii::Utilities::MPI::sum(
      static_cast<std::uint64_t>(pattern->NumMyNonzeros()),
      dynamic_cast<const Epetra_MpiComm &>(pattern->Comm()).Comm());
  }

  template <int dim>
  void
  NodeGraph<dim>::note_conditions(const Constraints &constraints)
  {
    std::map<global_dof_index, unsigned int> node_of_dof;
    if (constraints.has_followers())
      for (unsigned int node = 0; node < first_dofs.size(); ++node)
        node_of_dof[first_dofs[node]] = node;
    free_unknowns.assign(dim * first_dofs.size(), true);
    is_following.assign(dim * first_dofs.size(), false);
    if (constraints.has_followers())
      roots_of.resize(dim * first_dofs.size());
    for (unsigned int node = 0; node < first_dofs.size(); ++node)
      for (unsigned int c = 0; c < dim; ++c)
        {
          const auto *entries =
            constraints.affine().get_constraint_entries(first_dofs[node] + c);
          if (!entries) // no condition
            continue;
          free_unknowns[unknown<dim>(node, c)] = false;
          if (entries->empty()) // fixed
            continue;
          is_following[unknown<dim>(node, c)] = true;
          for (const auto &[dof, weight] : *entries)
            roots_of[unknown<dim>(node, c)].emplace_back(
              unknown<dim>(node_of_dof.at(dof - c), c), weight);
        }
  }

  template <int dim>
  void
  NodeGraph<dim>::find_plain_nodes()
  {
    is_plain.assign(first_dofs.size(), false);
    for (unsigned int node = 0; node < first_dofs.size(); ++node)
      is_plain[node] = std::all_of(free_unknowns.begin() + dim * node,
                                   free_unknowns.begin() + dim * (node + 1),
                                   [](const char free) { return free != 0; });
  }

  template <int dim>
  void
  NodeGraph<dim>::find_neighbours(std::vector<Clique> cliques)
  {
    // groups with GIMP lie in others that come after them
    const unsigned int        n_nodes = first_dofs.size();
    std::vector<unsigned int> in_last(n_nodes, 0);
    unsigned int              n_kept = cliques.size();
    for (unsigned int i = cliques.size(); i-- > 0;)
      {
        const unsigned int *const end = cliques[i].nodes + cliques[i].n;
        if (n_kept < cliques.size() &&
            std::all_of(cliques[i].nodes, end, [&](const unsigned int node) {
              return in_last[node] == n_kept + 1;
            }))
          continue;
        cliques[--n_kept] = cliques[i];
        std::for_each(cliques[n_kept].nodes, end, [&](const unsigned int node) {
          in_last[node] = n_kept + 1;
        });
      }
    cliques.erase(cliques.begin(), cliques.begin() + n_kept);

    // a node that follows brings its roots along
    std::vector<std::vector<unsigned int>> with_roots;
    with_roots.reserve(cliques.size());
    for (Clique &clique : cliques)
      {
        std::vector<unsigned int> nodes(clique.nodes, clique.nodes + clique.n);
        for (unsigned int a = 0; a < clique.n; ++a)
          for (unsigned int c = 0; c < dim; ++c)
            if (is_following[unknown<dim>(clique.nodes[a], c)])
              for (const auto &root :
                   roots_of[unknown<dim>(clique.nodes[a], c)])
                nodes.push_back(root.first / dim);
        if (nodes.size() == clique.n)
          continue;
        with_roots.push_back(std::move(nodes));
        clique = {with_roots.back().data(),
                  static_cast<unsigned int>(with_roots.back().size())};
      }

    std::vector<std::vector<unsigned int>> cliques_of(n_nodes);
    for (unsigned int i = 0; i < cliques.size(); ++i)
      for (unsigned int a = 0; a < cliques[i].n; ++a)
        cliques_of[cliques[i].nodes[a]].push_back(i);

    std::vector<unsigned int> seen_by(n_nodes,
                                      dealii::numbers::invalid_unsigned_int);
    first.assign(1, 0);
    for (unsigned int node = 0; node < n_nodes; ++node)
      {
        for (const unsigned int i : cliques_of[node])
          for (unsigned int b = 0; b < cliques[i].n; ++b)
            {
              const unsigned int other = cliques[i].nodes[b];
              if (seen_by[other] != node)
                neighbours.push_back(other);
              seen_by[other] = node;
            }
        std::sort(neighbours.begin() + first.back(), neighbours.end());
        first.push_back(neighbours.size());
      }
  }

  template <int dim>
  std::vector<std::vector<unsigned int>>
  NodeGraph<dim>::columns_of_others(const global_dof_index first_owned,
                                    Dofs                  &column_dofs) const
  {
    std::map<global_dof_index, unsigned int> of_others;
    for (unsigned int node = n_owned; node < first_dofs.size(); ++node)
      of_others[first_dofs[node]] = node;
    const auto column_of = [&](const global_dof_index dof) {
      if (dof >= first_owned && dof < first_owned + dim * n_owned)
        return static_cast<unsigned int>((dof - first_owned) / dim);
      const auto [found, is_new] = of_others.insert({dof, column_dofs.size()});
      if (is_new)
        column_dofs.push_back(dof);
      return found->second;
    };
    std::vector<std::vector<unsigned int>> result;
    for (const auto &row : foreign.rows_of_others())
      {
        result.emplace_back();
        for (const global_dof_index dof : row.columns)
          result.back().push_back(column_of(dof));
      }
    return result;
  }

  template <int dim>
  void
  NodeGraph<dim>::make_pattern(const dealii::IndexSet &owned_dofs,
                               const MPI_Comm          communicator)
  {
    // columns: the local nodes, then those that only other ranks have met
    Dofs       column_dofs = first_dofs;
    const auto of_others =
      columns_of_others(n_owned > 0 ? *owned_dofs.begin() : global_dof_index(0),
                        column_dofs);
    std::vector<std::vector<unsigned int>> rows(n_owned);
    for (unsigned int node = 0; node < n_owned; ++node)
      rows[node].assign(neighbours.begin() + first[node],
                        neighbours.begin() + first[node + 1]);
    const auto &rows_of_others = foreign.rows_of_others();
    for (std::size_t i = 0; i < of_others.size(); ++i)
      {
        auto &row = rows[rows_of_others[i].node];
        row.insert(row.end(), of_others[i].begin(), of_others[i].end());
      }
    for (std::vector<unsigned int> &row : rows)
      {
        std::sort(row.begin(), row.end());
        row.erase(std::unique(row.begin(), row.end()), row.end());
      }
    pattern = matrix_pattern<dim>(rows, column_dofs, owned_dofs, communicator);

    const auto place_in = [](const std::vector<unsigned int> &row,
                             const unsigned int               column) {
      return std::lower_bound(row.begin(), row.end(), column) - row.begin();
    };
    places.resize(neighbours.size());
    for (unsigned int node = 0; node < first_dofs.size(); ++node)
      for (std::size_t k = first[node]; k < first[node + 1]; ++k)
        places[k] = node < n_owned ? place_in(rows[node], neighbours[k])
                                   : k - first[node];
    for (std::size_t i = 0; i < of_others.size(); ++i)
      {
        std::vector<unsigned int> places_of_row;
        for (const unsigned int column : of_others[i])
          places_of_row.push_back(
            place_in(rows[rows_of_others[i].node], column));
        foreign.set_places(i, std::move(places_of_row));
      }
  }

  template <int dim>
  double *
  NodeGraph<dim>::entries_of(const unsigned int unknown, Matrix &matrix) const
  {
    return unknown / dim < n_owned ? matrix.trilinos_matrix()[unknown]
                                   : foreign.row(unknown / dim, unknown % dim);
  }

  template <int dim>
  void
  NodeGraph<dim>::add(const unsigned int               *nodes,
                      const dealii::FullMatrix<double> &block,
                      Matrix                           &matrix) const
  {
    const unsigned int n = block.m();
    add(nodes,
        ComponentBlocks{&block(0, 0), n / dim, n, 1, dim * n, dim},
        matrix);
  }

  template <int dim>
  void
  NodeGraph<dim>::add(const unsigned int    *nodes,
                      const ComponentBlocks &blocks,
                      Matrix                &matrix) const
  {
    adder->add(nodes, blocks, matrix);
  }

  template <int dim>
  void
  NodeGraph<dim>::add_components(const unsigned int               *nodes,
                                 const dealii::FullMatrix<double> &nodal,
                                 Matrix                           &matrix) const
  {
    const unsigned int n = nodal.m();
    if (std::all_of(nodes, nodes + n, [&](const unsigned int node) {
          return has_no_condition(node);
        }))
      return adder->add_components(nodes, nodal, matrix);
    dealii::FullMatrix<double> block(dim * n, dim * n);
    for (unsigned int a = 0; a < n; ++a)
      for (unsigned int b = 0; b < n; ++b)
        for (unsigned int c = 0; c < dim; ++c)
          block(dim * a + c, dim * b + c) = nodal(a, b);
    add(nodes, block, matrix);
  }

  template class NodeGraph<2>;
  template class NodeGraph<3>;
} // namespace emmy
