#include <emmy/effects/roots.h>
#include <emmy/system/active_cells.h>

#include <algorithm>
#include <limits>

namespace emmy
{
  namespace
  {
    using dealii::types::global_dof_index;

    /** A root as ranks send it: its place, its corners and its span. */
    template <int dim>
    using Entry = std::array<global_dof_index,
                             dim + BackgroundGrid<dim>::nodes_per_cell + 1>;

    template <int dim>
    Entry<dim>
    packed(const Root<dim> &root)
    {
      Entry<dim> entry;
      std::copy(root.cell.begin(), root.cell.end(), entry.begin());
      std::copy(root.ids.begin(), root.ids.end(), entry.begin() + dim);
      entry.back() = root.span;
      return entry;
    }

    template <int dim>
    Root<dim>
    unpacked(const Entry<dim> &entry)
    {
      Root<dim> root;
      std::copy_n(entry.begin(), dim, root.cell.begin());
      std::copy_n(entry.begin() + dim,
                  BackgroundGrid<dim>::nodes_per_cell,
                  root.ids.begin());
      root.span = entry.back();
      return root;
    }

    /** Tell the ranks beside this one of the roots of its cells. Collective. */
    template <int dim>
    void
    exchange(const BackgroundGrid<dim> &grid, Roots<dim> &roots)
    {
      using Data = std::vector<Entry<dim>>;
      exchange_beside<Data>(
        grid,
        [&](const CellKey<dim> &place) {
          Data       data;
          const auto found = roots.find(place);
          if (found != roots.end())
            for (const Root<dim> &root : found->second)
              data.push_back(packed(root));
          return data;
        },
        [&](const CellKey<dim> &place, const Data &data) {
          if (data.empty())
            return;
          auto &found = roots[place];
          found.clear();
          for (const Entry<dim> &entry : data)
            found.push_back(unpacked<dim>(entry));
        });
    }

    /** All roots of some cells, sorted. */
    template <int dim>
    std::vector<Root<dim>>
    roots_in(const Roots<dim> &roots, const std::vector<CellKey<dim>> &cells)
    {
      std::vector<Root<dim>> result;
      for (const CellKey<dim> &cell : cells)
        {
          const auto found = roots.find(cell);
          if (found != roots.end())
            result.insert(result.end(),
                          found->second.begin(),
                          found->second.end());
        }
      std::sort(result.begin(), result.end());
      result.erase(std::unique(result.begin(), result.end()), result.end());
      return result;
    }

    /** Active cells of a field that this rank owns, all whose nodes are fed. */
    template <int dim>
    Roots<dim>
    fed_cells(const Stencils<dim>       &stencils,
              const NodeValues          &is_fed,
              const BackgroundGrid<dim> &grid,
              const unsigned int         field)
    {
      Roots<dim> cells;
      for (const auto &active : stencils.active_cells)
        if (active.field == field)
          {
            const auto ids   = grid.node_ids(active.cell, field);
            const auto place = grid.key_of(active.cell);
            if (std::all_of(ids.begin(), ids.end(), [&](const auto id) {
                  return is_fed(id) > 0.;
                }))
              cells[place] = {{place, ids}};
          }
      return cells;
    }

    /**
     * Layer by layer, active cells of a field that have no root take those of
     * the cells around them. Collective.
     */
    template <int dim>
    Roots<dim>
    spread(Roots<dim>                 roots,
           const Stencils<dim>       &stencils,
           const BackgroundGrid<dim> &grid,
           const unsigned int         field,
           const unsigned int         n_layers)
    {
      std::vector<CellKey<dim>> without;
      for (const auto &active : stencils.active_cells)
        if (active.field == field && roots.count(grid.key_of(active.cell)) == 0)
          without.push_back(grid.key_of(active.cell));
      exchange<dim>(grid, roots);
      for (unsigned int layer = 0; layer < n_layers; ++layer)
        {
          Roots<dim> found;
          for (const CellKey<dim> &place : without)
            {
              auto of_place = roots_in<dim>(roots, grid.cells_around(place));
              if (!of_place.empty())
                found[place] = std::move(of_place);
            }
          if (dealii::Utilities::MPI::max(found.empty() ? 0 : 1,
                                          grid.communicator()) == 0)
            break;
          without.erase(std::remove_if(without.begin(),
                                       without.end(),
                                       [&](const CellKey<dim> &place) {
                                         return found.count(place) > 0;
                                       }),
                        without.end());
          roots.insert(found.begin(), found.end());
          exchange<dim>(grid, roots);
        }
      return roots;
    }
  } // namespace

  template <int dim>
  Roots<dim>
  find_roots(const Stencils<dim>       &stencils,
             const NodeValues          &is_fed,
             const BackgroundGrid<dim> &grid,
             const unsigned int         field,
             const unsigned int         n_layers)
  {
    return spread<dim>(fed_cells<dim>(stencils, is_fed, grid, field),
                       stencils,
                       grid,
                       field,
                       n_layers);
  }

  template <int dim>
  Roots<dim>
  find_families(const Stencils<dim>       &stencils,
                const NodeValues          &is_fed,
                const BackgroundGrid<dim> &grid,
                const unsigned int         field,
                const unsigned int         n_layers)
  {
    const Roots<dim> fed = fed_cells<dim>(stencils, is_fed, grid, field);
    Roots<dim>       families;
    for (const auto &[place, cells] : fed)
      {
        Root<dim> family;
        family.span   = 2;
        family.cell   = block_of<dim>(place, family.span);
        bool is_whole = true;
        for (unsigned int v = 0; v < family.ids.size() && is_whole; ++v)
          {
            const auto member = fed.find(node_of<dim>(family.cell, v));
            is_whole          = member != fed.end();
            if (is_whole) // its corner is also the family's
              family.ids[v] = member->second.front().ids[v];
          }
        if (is_whole)
          families[place] = {family};
      }
    return spread<dim>(std::move(families), stencils, grid, field, n_layers);
  }

  template <int dim>
  std::vector<Root<dim>>
  nearest_roots(const Roots<dim>          &roots,
                const CellKey<dim>        &node,
                const BackgroundGrid<dim> &grid)
  {
    auto       result   = roots_in<dim>(roots, grid.cells_at_node(node));
    const auto distance = [&](const Root<dim> &root) {
      return grid.from_node_to_center(node, root.cell, root.span).norm();
    };
    double least = std::numeric_limits<double>::max();
    for (const Root<dim> &root : result)
      least = std::min(least, distance(root));
    least += tie * grid.shortest_side();
    result.erase(std::remove_if(result.begin(),
                                result.end(),
                                [&](const Root<dim> &root) {
                                  return distance(root) > least;
                                }),
                 result.end());
    return result;
  }

  template <int dim>
  std::map<global_dof_index, std::vector<Root<dim>>>
  share_roots(std::map<global_dof_index, std::vector<Root<dim>>> chosen,
              const BackgroundGrid<dim>                         &grid)
  {
    if (dealii::Utilities::MPI::n_mpi_processes(grid.communicator()) == 1)
      return chosen;
    // a node and one of its roots
    using Message =
      std::vector<std::array<global_dof_index,
                             2 + dim + BackgroundGrid<dim>::nodes_per_cell>>;
    const auto               &nodes = *grid.nodes();
    std::vector<unsigned int> known_to_others; // one receiver after the other
    for (const auto &[begin, end] : nodes.import_indices())
      for (unsigned int i = begin; i < end; ++i)
        known_to_others.push_back(i);

    std::map<unsigned int, Message> to_others;
    auto                            node = known_to_others.begin();
    for (const auto &[receiver, n_nodes] : nodes.import_targets())
      for (unsigned int i = 0; i < n_nodes; ++i, ++node)
        {
          const auto id    = nodes.local_to_global(*node);
          const auto found = chosen.find(id);
          if (found == chosen.end())
            continue;
          for (const Root<dim> &root : found->second)
            {
              typename Message::value_type part;
              part[0]          = id;
              const auto entry = packed(root);
              std::copy(entry.begin(), entry.end(), part.begin() + 1);
              to_others[receiver].push_back(part);
            }
        }
    for (const auto &[sender, message] :
         dealii::Utilities::MPI::some_to_some(grid.communicator(), to_others))
      {
        (void)sender;
        for (const auto &part : message)
          {
            Entry<dim> entry;
            std::copy(part.begin() + 1, part.end(), entry.begin());
            chosen[part[0]].push_back(unpacked<dim>(entry));
          }
      }
    return chosen;
  }

  template Roots<2>
  find_families<2>(const Stencils<2> &,
                   const NodeValues &,
                   const BackgroundGrid<2> &,
                   const unsigned int,
                   const unsigned int);
  template Roots<2>
  find_roots<2>(const Stencils<2> &,
                const NodeValues &,
                const BackgroundGrid<2> &,
                const unsigned int,
                const unsigned int);
  template Roots<3>
  find_families<3>(const Stencils<3> &,
                   const NodeValues &,
                   const BackgroundGrid<3> &,
                   const unsigned int,
                   const unsigned int);
  template Roots<3>
  find_roots<3>(const Stencils<3> &,
                const NodeValues &,
                const BackgroundGrid<3> &,
                const unsigned int,
                const unsigned int);
  template std::vector<Root<2>>
  nearest_roots<2>(const Roots<2> &,
                   const CellKey<2> &,
                   const BackgroundGrid<2> &);
  template std::vector<Root<3>>
  nearest_roots<3>(const Roots<3> &,
                   const CellKey<3> &,
                   const BackgroundGrid<3> &);
  template std::map<global_dof_index, std::vector<Root<2>>>
  share_roots<2>(std::map<global_dof_index, std::vector<Root<2>>>,
                 const BackgroundGrid<2> &);
  template std::map<global_dof_index, std::vector<Root<3>>>
  share_roots<3>(std::map<global_dof_index, std::vector<Root<3>>>,
                 const BackgroundGrid<3> &);
} // namespace emmy
