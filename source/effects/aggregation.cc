#include <emmy/base/text.h>
#include <emmy/effects/aggregation.h>
#include <emmy/effects/families.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

namespace emmy
{
  namespace
  {
    /** A cell takes no root that is more layers of cells away. */
    constexpr unsigned int farthest_layer = 2;

    /**
     * Mass of the nodes as a part of what a full body gives; below zero where
     * no particle reaches. Ghosts are up to date. Collective.
     */
    template <int dim>
    NodeValues
    parts_of_full(const Stencils<dim>       &stencils,
                  const double              *mass,
                  const double              *volume,
                  const BackgroundGrid<dim> &grid)
    {
      NodeValues total(grid.nodes()), density(grid.nodes());
      for (const auto &group : stencils.groups)
        {
          const double *m               = mass + group.first_point;
          const double *V               = volume + group.first_point;
          double        largest_density = 0.;
          for (unsigned int p = 0; p < group.n_points; ++p)
            largest_density = std::max(largest_density, m[p] / V[p]);
          for (unsigned int a = 0; a < group.n_nodes; ++a)
            {
              const double *S   = stencils.value(group, a);
              double        sum = 0.;
              for (unsigned int p = 0; p < group.n_points; ++p)
                sum += m[p] * S[p];
              const auto id = stencils.node_ids[group.first_node + a];
              total(id) += sum;
              density(id) = std::max<double>(density(id), largest_density);
            }
        }
      total.compress(dealii::VectorOperation::add);
      density.compress(dealii::VectorOperation::max);
      NodeValues part(grid.nodes());
      for (unsigned int i = 0; i < part.locally_owned_size(); ++i)
        {
          const auto id = grid.nodes()->local_to_global(i);
          // the sum may be zero, and then zero or less by round-off
          part.local_element(i) =
            density.local_element(i) > 0.
              ? std::max(0., total.local_element(i)) /
                  (density.local_element(i) *
                   grid.volume_of_node(grid.node_position(id)))
              : -1.;
        }
      part.update_ghost_values();
      return part;
    }

    /** Whether two have the same nodes and values on this rank. */
    bool
    same_values(const NodeValues &a, const NodeValues &b)
    {
      if (a.size() == 0 && b.size() == 0)
        return true;
      if (a.get_partitioner() != b.get_partitioner())
        return false;
      const auto &nodes = *a.get_partitioner();
      for (unsigned int i = 0;
           i < nodes.locally_owned_size() + nodes.n_ghost_indices();
           ++i)
        if (a.local_element(i) != b.local_element(i))
          return false;
      return true;
    }

    /** The number of nodes of all ranks that hold. Collective. */
    template <class Condition>
    std::uint64_t
    count(const NodeValues &nodes, const Condition &holds)
    {
      std::uint64_t n = 0;
      for (unsigned int i = 0; i < nodes.locally_owned_size(); ++i)
        n += holds(i);
      return dealii::Utilities::MPI::sum(n, nodes.get_mpi_communicator());
    }

    /**
     * Where no root is near, lower the bar until cells of a field reach it,
     * and count their nodes as fed. Collective.
     */
    template <int dim>
    void
    keep_best_cells(const Stencils<dim>       &stencils,
                    const NodeValues          &part,
                    const double               threshold,
                    const BackgroundGrid<dim> &grid,
                    const unsigned int         field,
                    NodeValues                &fed)
    {
      for (double bar = threshold;;)
        {
          const auto roots =
            find_roots(stencils, fed, grid, field, farthest_layer);
          // the least part of the nodes of a cell that has no root
          std::vector<std::pair<typename BackgroundGrid<dim>::Cell, double>>
                 without;
          double best = -1.;
          for (const auto &[cell, of_field] : stencils.active_cells)
            if (of_field == field &&
                roots.find(grid.key_of(cell)) == roots.end())
              {
                double least = std::numeric_limits<double>::max();
                for (const auto id : grid.node_ids(cell, field))
                  least = std::min<double>(least, part(id));
                without.emplace_back(cell, least);
                best = std::max(best, least);
              }
          best = dealii::Utilities::MPI::max(best, grid.communicator());
          if (best < 0.)
            return;
          // the next bar that some cell reaches; at last, all do
          while (bar > 0. && !reaches(best, bar))
            bar = bar > 1e-12 * threshold ? 0.5 * bar : 0.;

          NodeValues kept(grid.nodes());
          for (const auto &[cell, least] : without)
            if (reaches(least, bar))
              for (const auto id : grid.node_ids(cell, field))
                kept(id) = 1.;
          kept.compress(dealii::VectorOperation::max);
          for (unsigned int i = 0; i < kept.locally_owned_size(); ++i)
            if (kept.local_element(i) > 0.)
              fed.local_element(i) = 1.;
          fed.update_ghost_values();
        }
    }

    /** Nodes and their classes, to all ranks that may own them. Collective. */
    template <int dim>
    std::vector<std::pair<NodePlace<dim>, bool>>
    sent_to_owners(const std::vector<std::pair<NodePlace<dim>, bool>> &nodes,
                   const BackgroundGrid<dim>                          &grid)
    {
      using Nodes = std::vector<std::pair<NodePlace<dim>, bool>>;
      std::map<unsigned int, Nodes> outgoing;
      for (const auto &node : nodes)
        {
          std::set<unsigned int> ranks;
          for (const CellKey<dim> &cell : grid.cells_at_node(node.first.first))
            for (const unsigned int rank : grid.possible_owners(cell))
              ranks.insert(rank);
          for (const unsigned int rank : ranks)
            outgoing[rank].push_back(node);
        }
      Nodes result;
      for (const auto &[sender, incoming] :
           dealii::Utilities::MPI::some_to_some(grid.communicator(), outgoing))
        {
          (void)sender;
          result.insert(result.end(), incoming.begin(), incoming.end());
        }
      std::sort(result.begin(), result.end());
      return result;
    }
  } // namespace

  template <int dim>
  bool
  NodeClasses<dim>::same_nodes_as(const NodeClasses &other) const
  {
    return n_kept == other.n_kept && same_values(fed, other.fed) &&
           same_values(coarse, other.coarse);
  }

  template <int dim>
  std::uint64_t
  class_changes(const NodeClasses<dim>    &before,
                const NodeClasses<dim>    &now,
                const BackgroundGrid<dim> &grid)
  {
    auto old = before.active;
    // all ranks renew their partition together; one that has none yet differs
    if (before.fed.get_partitioner() != now.fed.get_partitioner())
      old = sent_to_owners<dim>(old, grid);
    std::uint64_t n     = 0;
    auto          entry = old.begin();
    for (const auto &[place, is_fed] : now.active)
      {
        while (entry != old.end() && entry->first < place)
          ++entry;
        n += entry != old.end() && entry->first == place &&
             entry->second != is_fed;
      }
    return dealii::Utilities::MPI::sum(n, grid.communicator());
  }

  template <int dim>
  Follower<dim>::Follower(const dealii::types::global_dof_index node_id,
                          const std::vector<Root<dim>>         &roots_of_node,
                          const BackgroundGrid<dim>            &grid)
    : node_id(node_id)
  {
    constexpr unsigned int n_vertices = BackgroundGrid<dim>::nodes_per_cell;
    const CellKey<dim>    &node       = grid.node_key(node_id);
    std::map<CellKey<dim>, Master> by_place;
    for (const Root<dim> &root : roots_of_node)
      {
        roots.push_back(root);
        const auto weights = continued<dim>(root.cell, node, root.span);
        distance =
          std::max(distance, layers_between<dim>(node, root.cell, root.span));
        for (unsigned int v = 0; v < n_vertices; ++v)
          {
            const auto place  = node_of<dim>(root.cell, v, root.span);
            Master    &master = by_place[place];
            master.id         = root.ids[v];
            master.place      = place;
            master.weight += weights[v];
          }
      }
    for (const auto &[place, master] : by_place)
      if (master.weight != 0.)
        masters.push_back(
          {master.id, place, master.weight / roots_of_node.size()});
  }

  template <int dim>
  std::string
  Aggregates<dim>::text() const
  {
    const std::string of_families =
      n_of_families > 0
        ? std::to_string(n_of_families) +
            " nodes follow cells twice as large, as particles there are as "
            "large as cells: the grid is finer than they can use; "
        : std::string();
    return of_families + std::to_string(n_followers - n_of_families) +
           " starved nodes follow; roots are at most " +
           std::to_string(farthest_root) +
           " cells away, the largest weight is " + brief(largest_weight) +
           (n_kept > 0 ? "; " + std::to_string(n_kept) +
                           " starved nodes are free, as no cell around has more"
                       : std::string());
  }

  template <int dim>
  Aggregation<dim>::Aggregation(const double       mass_threshold,
                                const unsigned int mass_component,
                                const unsigned int volume_component)
    : threshold(mass_threshold)
    , mass_component(mass_component)
    , volume_component(volume_component)
  {}

  template <int dim>
  NodeClasses<dim>
  Aggregation<dim>::classify(const Stencils<dim>       &stencils,
                             const PointArrays<dim>    &points,
                             const BackgroundGrid<dim> &grid,
                             const NodeClasses<dim>    &before) const
  {
    const NodeValues part = parts_of_full(stencils,
                                          points.component(mass_component),
                                          points.component(volume_component),
                                          grid);
    NodeClasses<dim> classes;
    classes.fed.reinit(grid.nodes());
    for (unsigned int i = 0; i < part.locally_owned_size(); ++i)
      classes.fed.local_element(i) = reaches(part.local_element(i), threshold);
    classes.fed.update_ghost_values();
    classes.cells         = stencils.active_cells;
    const auto is_starved = [&](const unsigned int i) {
      return part.local_element(i) >= 0. &&
             !reaches(part.local_element(i), threshold);
    };
    // where none was kept, each starved node had a root; and so it has now
    const bool is_known = before.n_kept == 0 && before.cells == classes.cells &&
                          same_values(before.fed, classes.fed);
    if (dealii::Utilities::MPI::min(is_known ? 1 : 0, grid.communicator()) ==
          0 &&
        count(part, is_starved) > 0)
      {
        for (unsigned int field = 0; field < grid.fields().size(); ++field)
          keep_best_cells(stencils, part, threshold, grid, field, classes.fed);
        classes.n_kept = count(part, [&](const unsigned int i) {
          return is_starved(i) && classes.fed.local_element(i) > 0.;
        });
      }
    for (unsigned int i = 0; i < part.locally_owned_size(); ++i)
      if (part.local_element(i) >= 0.)
        {
          const auto id = grid.nodes()->local_to_global(i);
          classes.active.emplace_back(NodePlace<dim>{grid.node_key(id),
                                                     grid.fields().field(id)},
                                      classes.fed.local_element(i) > 0.);
        }
    std::sort(classes.active.begin(), classes.active.end());
    classes.coarse =
      coarse_nodes<dim>(stencils, points.component(volume_component), grid);
    return classes;
  }

  template <int dim>
  Aggregates<dim>
  Aggregation<dim>::find(const NodeClasses<dim>    &classes,
                         const Stencils<dim>       &stencils,
                         const BackgroundGrid<dim> &grid) const
  {
    Aggregates<dim> result;
    result.n_kept = classes.n_kept;
    NodeValues active(grid.nodes());
    for (const auto id : stencils.node_ids)
      active(id) = 1.;
    active.compress(dealii::VectorOperation::add);
    // nodes that move on their own, or would if no family was near
    NodeValues is_free = classes.fed;
    is_free.update_ghost_values(); // a copy has none
    std::map<dealii::types::global_dof_index, std::vector<Root<dim>>> chosen;
    if (classes.coarse.size() > 0)
      {
        chosen =
          follow_families<dim>(stencils, grid, active, classes.coarse, is_free);
        result.n_of_families =
          dealii::Utilities::MPI::sum(std::uint64_t(chosen.size()),
                                      grid.communicator());
      }
    const auto is_starved = [&](const unsigned int i) {
      return active.local_element(i) > 0. && is_free.local_element(i) == 0.;
    };
    const std::uint64_t n_starved = count(active, is_starved);
    if (n_starved == 0)
      return result;

    // as many layers as there are: the particles may have moved since
    for (unsigned int field = 0; field < grid.fields().size(); ++field)
      {
        const auto roots = find_roots(stencils,
                                      is_free,
                                      grid,
                                      field,
                                      std::numeric_limits<unsigned int>::max());
        for (unsigned int i = 0; i < active.locally_owned_size(); ++i)
          {
            const auto id = grid.nodes()->local_to_global(i);
            if (grid.fields().field(id) != field || !is_starved(i) ||
                chosen.count(id) > 0)
              continue;
            auto nearest = nearest_roots<dim>(roots, grid.node_key(id), grid);
            if (!nearest.empty())
              chosen[id] = std::move(nearest);
          }
      }
    const MPI_Comm communicator = grid.communicator();
    result.n_followers =
      dealii::Utilities::MPI::sum(std::uint64_t(chosen.size()), communicator);
    result.n_kept += n_starved - result.n_followers;

    for (const auto &[id, nearest] : share_roots<dim>(std::move(chosen), grid))
      result.followers.emplace_back(id, nearest, grid);
    // the order must not depend on which part of the grid has cells
    std::sort(result.followers.begin(),
              result.followers.end(),
              [&](const auto &a, const auto &b) {
                const CellKey<dim> &key_a = grid.node_key(a.node_id),
                                   &key_b = grid.node_key(b.node_id);
                return key_a != key_b ? key_a < key_b : a.node_id < b.node_id;
              });
    for (const Follower<dim> &follower : result.followers)
      {
        result.farthest_root =
          std::max(result.farthest_root, follower.distance);
        for (const auto &master : follower.masters)
          result.largest_weight =
            std::max(result.largest_weight, std::abs(master.weight));
      }
    result.farthest_root =
      dealii::Utilities::MPI::max(result.farthest_root, communicator);
    result.largest_weight =
      dealii::Utilities::MPI::max(result.largest_weight, communicator);
    return result;
  }

  template struct NodeClasses<2>;
  template struct NodeClasses<3>;
  template std::uint64_t
  class_changes<2>(const NodeClasses<2> &,
                   const NodeClasses<2> &,
                   const BackgroundGrid<2> &);
  template std::uint64_t
  class_changes<3>(const NodeClasses<3> &,
                   const NodeClasses<3> &,
                   const BackgroundGrid<3> &);
  template struct Follower<2>;
  template struct Follower<3>;
  template struct Aggregates<2>;
  template struct Aggregates<3>;
  template class Aggregation<2>;
  template class Aggregation<3>;
} // namespace emmy
