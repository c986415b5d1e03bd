#include <deal.II/lac/la_parallel_vector.h>

#include <emmy/base/dealii_version.h>
#include <emmy/base/index_limits.h>
#include <emmy/system/active_grid.h>

#include <algorithm>
#include <map>

namespace emmy
{
  namespace
  {
    using dealii::types::global_dof_index;

    /** Values over owned and known entries that can be exchanged. */
    using Exchange = dealii::LinearAlgebra::distributed::Vector<double>;

    dealii::IndexSet
    range(const global_dof_index begin,
          const global_dof_index end,
          const global_dof_index size)
    {
      dealii::IndexSet result(size);
      result.add_range(begin, end);
      result.compress();
      return result;
    }
  } // namespace

  namespace
  {
    /** The grid's nodes, with masters and others beyond this rank's part. */
    template <int dim>
    std::shared_ptr<const dealii::Utilities::MPI::Partitioner>
    nodes_and_farther(const BackgroundGrid<dim> &grid,
                      const Couplings<dim>      &couplings)
    {
      dealii::IndexSet ghosts = grid.nodes()->ghost_indices();
      for (const TiedNode<dim> &tied : couplings.tied_nodes)
        for (const auto &master : tied.masters)
          ghosts.add_index(master.id);
      for (const auto &[id, position] : couplings.far_nodes)
        {
          (void)position;
          ghosts.add_index(id);
        }
      return std::make_shared<const dealii::Utilities::MPI::Partitioner>(
        grid.nodes()->locally_owned_range(), ghosts, grid.communicator());
    }

    /** The active nodes that this rank owns, in the order of their places. */
    template <int dim>
    std::vector<global_dof_index>
    owned_active_nodes(const Stencils<dim>       &stencils,
                       const BackgroundGrid<dim> &grid)
    {
      // a node is active if any rank has a particle that reaches it
      Exchange active(grid.nodes());
      for (const global_dof_index id : stencils.node_ids)
        active(id) = 1.;
      active.compress(dealii::VectorOperation::add);

      std::vector<global_dof_index> owned_ids;
      for (unsigned int i = 0; i < active.locally_owned_size(); ++i)
        if (active.local_element(i) > 0.)
          owned_ids.push_back(grid.nodes()->local_to_global(i));
      // the order must not depend on which part of the grid has cells
      std::sort(owned_ids.begin(), owned_ids.end(), [&](auto a, auto b) {
        const CellKey<dim> &key_a = grid.node_key(a), &key_b = grid.node_key(b);
        return key_a != key_b ? key_a < key_b : a < b; // by field
      });
      return owned_ids;
    }

    /** Nodes of others that this rank works on. */
    template <int dim>
    struct Elsewhere
    {
      /** Numbers and ids, sorted. */
      std::vector<std::pair<global_dof_index, global_dof_index>> nodes;
      /** By id, of those beyond this rank's part of the grid. */
      std::map<global_dof_index, dealii::Point<dim>> positions;
    };

    /** @param number of all nodes that this rank knows, by id */
    template <int dim>
    Elsewhere<dim>
    find_elsewhere(const Stencils<dim>       &stencils,
                   const Couplings<dim>      &couplings,
                   const Exchange            &number,
                   const BackgroundGrid<dim> &grid)
    {
      Elsewhere<dim> result;
      const auto     is_known = [&](const global_dof_index id) {
        return grid.nodes()->in_local_range(id) ||
               grid.nodes()->is_ghost_entry(id);
      };
      const auto add_ghost = [&](const global_dof_index id) {
        if (!grid.nodes()->in_local_range(id))
          result.nodes.emplace_back(static_cast<global_dof_index>(number(id)),
                                    id);
      };
      for (const global_dof_index id : stencils.node_ids)
        add_ghost(id);
      for (const global_dof_index id : couplings.node_ids)
        add_ghost(id);
      // particles of another rank may reach into cells of this one
      for (const auto &[cell, field] : stencils.active_cells)
        for (const global_dof_index id : grid.node_ids(cell, field))
          add_ghost(id);
      for (const auto &[id, position] : couplings.far_nodes)
        result.positions[id] = position;
      for (const TiedNode<dim> &tied : couplings.tied_nodes)
        {
          add_ghost(tied.id);
          for (const auto &master : tied.masters)
            {
              add_ghost(master.id);
              if (!is_known(master.id))
                result.positions[master.id] = master.position;
            }
        }
      std::sort(result.nodes.begin(), result.nodes.end());
      result.nodes.erase(std::unique(result.nodes.begin(), result.nodes.end()),
                         result.nodes.end());
      return result;
    }
  } // namespace

  template <int dim>
  ActiveGrid<dim>::ActiveGrid(
    const Stencils<dim>           &stencils,
    const Couplings<dim>          &couplings,
    const BackgroundGrid<dim>     &grid,
    const BoundaryConditions<dim> &boundary_conditions,
    const Matrices                 matrices,
    const ActiveGrid *const        before)
    : grid(grid)
    , grid_nodes(grid.nodes())
    , active_cells(stencils.active_cells)
    , group_node_ids(stencils.node_ids)
    , couplings(couplings)
  {
    number_nodes(stencils);
    make_constraints(boundary_conditions);
    if (matrices == Matrices::wanted)
      make_graph(stencils, before);
  }

  template <int dim>
  bool
  ActiveGrid<dim>::fits(const Stencils<dim>  &stencils,
                        const Couplings<dim> &now) const
  {
    // in another window the old cells are not to be touched
    return dealii::Utilities::MPI::min(
             grid.nodes() == grid_nodes &&
                 stencils.node_ids == group_node_ids &&
                 stencils.active_cells == active_cells &&
                 now.node_ids == couplings.node_ids &&
                 now.group_sizes == couplings.group_sizes &&
                 now.tied_nodes == couplings.tied_nodes
               ? 1
               : 0,
             communicator()) == 1;
  }

  template <int dim>
  MPI_Comm
  ActiveGrid<dim>::communicator() const
  {
    return grid.communicator();
  }

  template <int dim>
  double
  ActiveGrid<dim>::shortest_side() const
  {
    return grid.shortest_side();
  }

  template <int dim>
  unsigned int
  ActiveGrid<dim>::local_index(const global_dof_index grid_id) const
  {
    const auto found = std::lower_bound(local_index_of.begin(),
                                        local_index_of.end(),
                                        std::make_pair(grid_id, 0u));
    AssertThrow(found != local_index_of.end() && found->first == grid_id,
                dealii::ExcMessage("Node " + std::to_string(grid_id) +
                                   " is not active."));
    return found->second;
  }

  template <int dim>
  void
  ActiveGrid<dim>::number_nodes(const Stencils<dim> &stencils)
  {
    const std::vector<global_dof_index> owned_ids =
      owned_active_nodes(stencils, grid);
    const auto [first, n_nodes] =
      sum_below_and_total(owned_ids.size(), communicator());
    refuse_unknowns(dim * n_nodes);

    // numbers of the nodes that others own (exact in double up to 2^53)
    Exchange number(couplings.has_tied_nodes || couplings.has_far_nodes
                      ? nodes_and_farther(grid, couplings)
                      : grid.nodes());
    for (unsigned int i = 0; i < owned_ids.size(); ++i)
      number(owned_ids[i]) = first + i;
    number.update_ghost_values();

    const Elsewhere<dim> elsewhere =
      find_elsewhere(stencils, couplings, number, grid);
    const auto &ghosts = elsewhere.nodes;

    std::vector<global_dof_index> ids = owned_ids;
    for (unsigned int i = 0; i < owned_ids.size(); ++i)
      node_numbers.push_back(first + i);
    for (const auto &[ghost_number, id] : ghosts)
      {
        ids.push_back(id);
        node_numbers.push_back(ghost_number);
      }
    for (unsigned int i = 0; i < ids.size(); ++i)
      {
        const auto beyond = elsewhere.positions.find(ids[i]);
        node_positions.push_back(beyond == elsewhere.positions.end()
                                   ? grid.node_position(ids[i])
                                   : beyond->second);
        local_index_of.emplace_back(ids[i], i);
      }
    std::sort(local_index_of.begin(), local_index_of.end());

    group_nodes.reserve(stencils.node_ids.size());
    for (const global_dof_index id : stencils.node_ids)
      group_nodes.push_back(local_index(id));
    for (const global_dof_index id : couplings.node_ids)
      local_coupled_nodes.push_back(local_index(id));
    for (const auto &[cell, field] : active_cells)
      {
        const auto cell_ids = grid.node_ids(cell, field);
        nodes_of_cell.emplace_back();
        for (unsigned int v = 0; v < cell_ids.size(); ++v)
          nodes_of_cell.back()[v] = local_index(cell_ids[v]);
      }

    const global_dof_index end = first + owned_ids.size();
    dealii::IndexSet       ghost_nodes(n_nodes), ghost_dofs(dim * n_nodes);
    for (const auto &[ghost_number, id] : ghosts)
      {
        (void)id;
        ghost_nodes.add_index(ghost_number);
        ghost_dofs.add_range(dim * ghost_number, dim * (ghost_number + 1));
      }
    ghost_nodes.compress();
    ghost_dofs.compress();
    owned_dofs = range(dim * first, dim * end, dim * n_nodes);
    zero.reinit(owned_dofs, communicator());
    node_partition = std::make_shared<dealii::Utilities::MPI::Partitioner>(
      range(first, end, n_nodes), ghost_nodes, communicator());
    dof_partition =
      std::make_shared<dealii::Utilities::MPI::Partitioner>(owned_dofs,
                                                            ghost_dofs,
                                                            communicator());

    node_places     = {zero, grid.shortest_side()};
    auto coordinate = node_places.coordinates.begin();
    for (unsigned int node = 0; node < n_owned_nodes(); ++node)
      for (unsigned int c = 0; c < dim; ++c)
        *coordinate++ = node_positions[node][c];
  }

  template <int dim>
  void
  ActiveGrid<dim>::make_constraints(
    const BoundaryConditions<dim> &boundary_conditions)
  {
    conditions = Constraints(dof_partition);
    for (unsigned int node = 0; node < n_local_nodes(); ++node)
      {
        const auto fixed =
          boundary_conditions.fixed_components(node_positions[node]);
        for (unsigned int c = 0; c < dim; ++c)
          if (fixed[c])
            conditions.fix(first_dof(node) + c);
      }
    for (const TiedNode<dim> &tied : couplings.tied_nodes)
      {
        const unsigned int node = local_index(tied.id);
        const auto         fixed =
          boundary_conditions.fixed_components(node_positions[node]);
        for (unsigned int c = 0; c < dim; ++c)
          {
            if (fixed[c])
              continue;
            Constraints::Entries entries;
            for (const auto &master : tied.masters)
              entries.emplace_back(first_dof(local_index(master.id)) + c,
                                   master.weight);
            conditions.follow(first_dof(node) + c, entries);
          }
      }
    conditions.close(couplings.has_tied_nodes);
  }

  template <int dim>
  void
  ActiveGrid<dim>::make_graph(const Stencils<dim>    &stencils,
                              const ActiveGrid *const before)
  {
    std::vector<typename NodeGraph<dim>::Clique> cliques;
    for (const auto &group : stencils.groups)
      cliques.push_back({nodes(group), group.n_nodes});
    std::size_t first = 0;
    for (const unsigned int n : couplings.group_sizes)
      {
        cliques.push_back({coupled_nodes(first), n});
        first += n;
      }
    std::vector<global_dof_index> first_dofs;
    for (unsigned int node = 0; node < n_local_nodes(); ++node)
      first_dofs.push_back(first_dof(node));
    node_graph.make(cliques,
                    first_dofs,
                    owned_dofs,
                    conditions,
                    communicator(),
                    before ? &before->node_graph : nullptr);
  }

  template <int dim>
  Vector
  ActiveGrid<dim>::make_vector() const
  {
    // Copies share one map. A map for each vector would take several exchanges,
    // and deal.II would make the vector anew in each assignment.
    return zero;
  }

  template <int dim>
  std::vector<double>
  ActiveGrid<dim>::to_local(const Vector &vector) const
  {
    Exchange values(dof_partition);
    std::copy(vector.begin(), vector.end(), values.begin());
    values.update_ghost_values();
    std::vector<double> local(dim * n_local_nodes());
    for (unsigned int i = 0; i < local.size(); ++i)
      local[i] = values.local_element(i);
    return local;
  }

  template <int dim>
  void
  ActiveGrid<dim>::add(const std::vector<double> &local, Vector &vector) const
  {
    Exchange values(dof_partition);
    for (unsigned int i = 0; i < local.size(); ++i)
      values.local_element(i) = local[i];
    values.compress(dealii::VectorOperation::add);
    auto target = vector.begin();
    for (unsigned int i = 0; i < values.locally_owned_size(); ++i, ++target)
      *target += values.local_element(i);
  }

  template <int dim>
  void
  ActiveGrid<dim>::sum_over_ranks(std::vector<double> &local) const
  {
    Exchange values(node_partition);
    for (unsigned int i = 0; i < local.size(); ++i)
      values.local_element(i) = local[i];
    values.compress(dealii::VectorOperation::add);
    for (unsigned int i = 0; i < values.locally_owned_size(); ++i)
      local[i] = values.local_element(i);
  }

  template <int dim>
  void
  ActiveGrid<dim>::share(std::vector<double> &local) const
  {
    if (dealii::Utilities::MPI::n_mpi_processes(communicator()) == 1)
      return; // all is local
    Exchange values(local.size() == n_local_nodes() ? node_partition
                                                    : dof_partition);
    for (unsigned int i = 0; i < local.size(); ++i)
      values.local_element(i) = local[i];
    values.compress(dealii::VectorOperation::add);
    values.update_ghost_values();
    for (unsigned int i = 0; i < local.size(); ++i)
      local[i] = values.local_element(i);
  }

  template <int dim>
  Vector
  ActiveGrid<dim>::carried_over(const ActiveGrid &from,
                                const Vector     &vector,
                                const Vector     &otherwise) const
  {
    Vector result = otherwise;
    // owners of nodes are the same, so this rank knows what it looks for
    auto known = from.local_index_of.begin();
    for (const auto &[id, node] : local_index_of)
      {
        if (node >= n_owned_nodes())
          continue;
        while (known != from.local_index_of.end() && known->first < id)
          ++known;
        if (known != from.local_index_of.end() && known->first == id)
          for (unsigned int c = 0; c < dim; ++c)
            result.begin()[unknown<dim>(node, c)] =
              vector.begin()[dim * known->second + c];
      }
    return result;
  }

  template <int dim>
  Vector
  ActiveGrid<dim>::to_vector(const std::vector<double> &local) const
  {
    Vector result = make_vector();
    std::copy_n(local.begin(), dim * n_owned_nodes(), result.begin());
    return result;
  }

  template class ActiveGrid<2>;
  template class ActiveGrid<3>;
} // namespace emmy
