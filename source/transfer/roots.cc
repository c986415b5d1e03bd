#include <emmy/transfer/roots.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <tuple>

namespace emmy
{
  namespace
  {
    using dealii::types::global_dof_index;

    template <int dim>
    using Lattice = typename BackgroundGrid<dim>::Lattice;

    /** Tell the ranks beside this one of the roots of its cells. Collective. */
    template <int dim>
    void
    exchange(const BackgroundGrid<dim> &grid, Roots<dim> &roots)
    {
      std::vector<std::pair<Lattice<dim>, unsigned int>> bodies_at;
      if (dealii::Utilities::MPI::n_mpi_processes(grid.communicator()) > 1)
        for (const auto &[cell, root] : roots)
          bodies_at.emplace_back(cell.second, cell.first);
      std::sort(bodies_at.begin(), bodies_at.end());

      // body, layer, cell and ids
      using Entry = std::array<global_dof_index,
                               2 + dim + BackgroundGrid<dim>::nodes_per_cell>;
      using Data  = std::vector<Entry>;
      exchange_beside<Data>(
        grid,
        [&](const Lattice<dim> &lattice) {
          Data data;
          for (auto here = std::lower_bound(bodies_at.begin(),
                                            bodies_at.end(),
                                            std::make_pair(lattice, 0u));
               here != bodies_at.end() && here->first == lattice;
               ++here)
            {
              const unsigned int body = here->second;
              const Root<dim>   &root = roots.at({body, lattice});
              Entry              entry{{body, root.layer}};
              std::copy(root.cell.begin(), root.cell.end(), entry.begin() + 2);
              std::copy(root.ids.begin(),
                        root.ids.end(),
                        entry.begin() + 2 + dim);
              data.push_back(entry);
            }
          return data;
        },
        [&](const Lattice<dim> &lattice, const Data &data) {
          for (const Entry &entry : data)
            {
              Root<dim> root;
              root.layer = entry[1];
              std::copy_n(entry.begin() + 2, dim, root.cell.begin());
              std::copy_n(entry.begin() + 2 + dim,
                          BackgroundGrid<dim>::nodes_per_cell,
                          root.ids.begin());
              roots[{static_cast<unsigned int>(entry[0]), lattice}] = root;
            }
        });
    }

    /** Call function(CellOfBody) for the cells of a box, within the grid. */
    template <int dim, class Function>
    void
    for_each_cell_in(const std::array<int, dim> &first,
                     const int                   n,
                     const unsigned int          body,
                     const BackgroundGrid<dim>  &grid,
                     const Function             &function)
    {
      for (int i = 0; i < dealii::Utilities::pow(n, dim); ++i)
        {
          CellOfBody<dim> cell;
          cell.first   = body;
          bool is_cell = true;
          for (int d = 0, rest = i; d < dim; ++d, rest /= n)
            {
              const int place = first[d] + rest % n;
              is_cell = is_cell && place >= 0 && place < int(grid.n_cells()[d]);
              cell.second[d] = place;
            }
          if (is_cell)
            function(cell);
        }
    }

    /**
     * What is small for the root to be preferred: its layer, its distance from
     * a place in half cells, its place in the lattice.
     */
    template <int dim>
    std::tuple<unsigned int, long, Lattice<dim>>
    rank_of(const Root<dim>            &root,
            const std::array<int, dim> &place,
            const BackgroundGrid<dim>  &grid)
    {
      const double h      = grid.smallest_cell_size();
      double       square = 0.;
      for (unsigned int d = 0; d < dim; ++d)
        {
          const int    half_cells = 2 * int(root.cell[d]) + 1 - place[d];
          const double distance   = half_cells * grid.cell_size()[d] / h;
          square += distance * distance;
        }
      return {root.layer, std::lround(square / tie), root.cell};
    }

    /** Layer by layer, cells without a root take one from a neighbour. */
    template <int dim>
    void
    spread(const std::set<CellOfBody<dim>> &owned,
           const BackgroundGrid<dim>       &grid,
           Roots<dim>                      &roots)
    {
      exchange(grid, roots);
      for (unsigned int i = 0; i < farthest_layer; ++i)
        {
          Roots<dim> found;
          for (const CellOfBody<dim> &cell : owned)
            {
              if (roots.find(cell) != roots.end())
                continue;
              std::array<int, dim> first, centre;
              for (unsigned int d = 0; d < dim; ++d)
                {
                  first[d]  = int(cell.second[d]) - 1;
                  centre[d] = 2 * int(cell.second[d]) + 1;
                }
              const Root<dim> *root =
                preferred<dim>(roots, first, 3, cell.first, centre, grid);
              if (root && root->layer < farthest_layer)
                found[cell] = {root->layer + 1, root->cell, root->ids};
            }
          roots.insert(found.begin(), found.end());
          exchange(grid, roots);
        }
    }
  } // namespace

  template <int dim>
  const Root<dim> *
  preferred(const Roots<dim>           &roots,
            const std::array<int, dim> &first,
            const int                   n,
            const unsigned int          body,
            const std::array<int, dim> &place,
            const BackgroundGrid<dim>  &grid)
  {
    const Root<dim> *best = nullptr;
    for_each_cell_in<dim>(
      first, n, body, grid, [&](const CellOfBody<dim> &cell) {
        const auto found = roots.find(cell);
        if (found != roots.end() &&
            (!best || rank_of<dim>(found->second, place, grid) <
                        rank_of<dim>(*best, place, grid)))
          best = &found->second;
      });
    return best;
  }

  template <int dim>
  Roots<dim>
  find_roots(const Stencils<dim>       &stencils,
             const double               threshold,
             const BackgroundGrid<dim> &grid,
             Feeding                   &nodes)
  {
    const auto owned = owned_active_cells(stencils, grid);
    Roots<dim> roots;
    for (double bar = threshold;;)
      {
        // the least part of the nodes of a cell, if it has no root yet
        std::map<CellOfBody<dim>, double> parts;
        double                            best = -1.;
        for (const CellOfBody<dim> &cell : owned)
          if (roots.find(cell) == roots.end())
            {
              double part = std::numeric_limits<double>::max();
              for (const auto id : grid.node_ids(grid.cell_at(cell.second)))
                part = std::min<double>(part, nodes.part(id));
              parts[cell] = part;
              best        = std::max(best, part);
            }
        best = dealii::Utilities::MPI::max(best, grid.communicator());
        if (best < 0.)
          break;
        // the next bar that some cell reaches; at last, all do
        while (bar > 0. && !reaches(best, bar))
          bar = bar > 1e-12 * threshold ? 0.5 * bar : 0.;

        for (const auto &[cell, part] : parts)
          if (reaches(part, bar))
            {
              const auto ids = grid.node_ids(grid.cell_at(cell.second));
              roots[cell]    = {0, cell.second, ids};
              for (const auto id : ids)
                nodes.is_free(id) = 1.;
            }
        spread(owned, grid, roots);
      }
    nodes.is_free.compress(dealii::VectorOperation::max);
    return roots;
  }

  template Roots<2>
  find_roots<2>(const Stencils<2> &,
                const double,
                const BackgroundGrid<2> &,
                Feeding &);
  template Roots<3>
  find_roots<3>(const Stencils<3> &,
                const double,
                const BackgroundGrid<3> &,
                Feeding &);
  template const Root<2> *
  preferred<2>(const Roots<2> &,
               const std::array<int, 2> &,
               const int,
               const unsigned int,
               const std::array<int, 2> &,
               const BackgroundGrid<2> &);
  template const Root<3> *
  preferred<3>(const Roots<3> &,
               const std::array<int, 3> &,
               const int,
               const unsigned int,
               const std::array<int, 3> &,
               const BackgroundGrid<3> &);
} // namespace emmy
