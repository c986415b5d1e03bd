#include <deal.II/grid/grid_tools.h>

#include <deal.II/lac/la_parallel_vector.h>

#include <emmy/transfer/aggregation.h>
#include <emmy/transfer/group_cells.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>

namespace emmy
{
  namespace
  {
    using dealii::types::global_dof_index;
    using Exchange = dealii::LinearAlgebra::distributed::Vector<double>;

    /** Two numbers this close count as equal, whatever round-off says. */
    constexpr double tie = 1e-8;

    /** Whether a part is at least a bar, up to round-off. */
    bool
    reaches(const double part, const double bar)
    {
      return part >= bar * (1. - tie);
    }

    template <int dim>
    using Lattice = typename BackgroundGrid<dim>::Lattice;

    /** A cell as the particles of one body see it. */
    template <int dim>
    using CellOfBody = std::pair<unsigned int, Lattice<dim>>;

    /** The root that a cell has found. */
    template <int dim>
    struct Root
    {
      unsigned int                layer; ///< 0: the cell itself
      Lattice<dim>                cell;
      typename Follower<dim>::Ids ids;
    };

    template <int dim>
    using Roots = std::map<CellOfBody<dim>, Root<dim>>;

    /** How nodes are fed. */
    struct Nodes
    {
      /** Mass, as a part of a full body's, of all nodes known here. */
      Exchange part;
      /** 1 if a node does not follow, else 0; of all nodes known here. */
      Exchange is_free;
      /** Active nodes that this rank owns, as local indices. */
      std::vector<unsigned int> active;
      /** The body that gives an owned node most. */
      std::vector<unsigned int> body;
      unsigned int              n_bodies = 0;
    };

    /** How many cells a node is away from the lower corner. */
    template <int dim>
    std::array<int, dim>
    node_lattice(const dealii::Point<dim> &x, const BackgroundGrid<dim> &grid)
    {
      std::array<int, dim> result;
      for (unsigned int d = 0; d < dim; ++d)
        result[d] =
          std::lround((x[d] - grid.lower_corner()[d]) / grid.cell_size()[d]);
      return result;
    }

    /** int N_A, m^dim. */
    template <int dim>
    double
    volume_of_node(const dealii::Point<dim> &x, const BackgroundGrid<dim> &grid)
    {
      const auto place  = node_lattice(x, grid);
      double     volume = 1.;
      for (unsigned int d = 0; d < dim; ++d)
        volume *=
          (place[d] == 0 || place[d] == int(grid.n_cells()[d]) ? 0.5 : 1.) *
          grid.cell_size()[d];
      return volume;
    }

    /** Add the mass of a body's points, and keep the largest density. */
    template <int dim>
    void
    add_body(const Stencils<dim> &stencils,
             const double        *mass,
             const double        *volume,
             const unsigned int   body,
             Exchange            &of_body,
             Exchange            &density)
    {
      for (const auto &group : stencils.groups)
        if (group.body == body)
          for (unsigned int a = 0; a < group.n_nodes; ++a)
            {
              const double *S   = stencils.value(group, a);
              const double *m   = mass + group.first_point;
              const double *V   = volume + group.first_point;
              double        sum = 0., largest_density = 0.;
              for (unsigned int p = 0; p < group.n_points; ++p)
                {
                  sum += m[p] * S[p];
                  largest_density = std::max(largest_density, m[p] / V[p]);
                }
              const auto id = stencils.node_ids[group.first_node + a];
              // S may be zero, and then zero or less by round-off
              of_body(id) += std::max(sum, std::numeric_limits<double>::min());
              density(id) = std::max<double>(density(id), largest_density);
            }
    }

    /** Find how all nodes are fed; the threshold says which are free. */
    template <int dim>
    Nodes
    weigh(const Stencils<dim>       &stencils,
          const double              *mass,
          const double              *volume,
          const double               threshold,
          const BackgroundGrid<dim> &grid)
    {
      Nodes result;
      for (const auto &group : stencils.groups)
        result.n_bodies = std::max(result.n_bodies, group.body + 1);
      result.n_bodies =
        dealii::Utilities::MPI::max(result.n_bodies, grid.communicator());

      Exchange           total(grid.nodes()), density(grid.nodes());
      const unsigned int n_owned = total.locally_owned_size();
      result.body.resize(n_owned);
      std::vector<double> largest(n_owned);
      for (unsigned int body = 0; body < result.n_bodies; ++body)
        {
          Exchange of_body(grid.nodes());
          add_body(stencils, mass, volume, body, of_body, density);
          of_body.compress(dealii::VectorOperation::add);
          for (unsigned int i = 0; i < n_owned; ++i)
            {
              const double m = of_body.local_element(i);
              total.local_element(i) += m;
              if (m > largest[i] * (1. + tie))
                {
                  largest[i]     = m;
                  result.body[i] = body;
                }
            }
        }
      density.compress(dealii::VectorOperation::max);

      result.part.reinit(grid.nodes());
      result.is_free.reinit(grid.nodes());
      for (unsigned int i = 0; i < n_owned; ++i)
        if (density.local_element(i) > 0.)
          {
            const auto id = grid.nodes()->local_to_global(i);
            result.part.local_element(i) =
              total.local_element(i) /
              (density.local_element(i) *
               volume_of_node(grid.node_position(id), grid));
            result.is_free.local_element(i) =
              reaches(result.part.local_element(i), threshold);
            result.active.push_back(i);
          }
      result.part.update_ghost_values();
      return result;
    }

    /** The active cells that this rank owns, whoever's points make them so. */
    template <int dim>
    std::set<CellOfBody<dim>>
    owned_active_cells(const Stencils<dim>       &stencils,
                       const BackgroundGrid<dim> &grid)
    {
      std::set<CellOfBody<dim>> found, owned;
      for (const auto &group : stencils.groups)
        for_each_cell(stencils, group, grid, [&](const Lattice<dim> &cell) {
          found.insert({group.body, cell});
        });
      std::map<unsigned int, std::vector<CellOfBody<dim>>> of_others;
      for (const auto &entry : found)
        {
          const auto cell = grid.cell_at(entry.second);
          if (cell->is_locally_owned())
            owned.insert(entry);
          else
            of_others[cell->subdomain_id()].push_back(entry);
        }
      for (const auto &[sender, entries] :
           dealii::Utilities::MPI::some_to_some(grid.communicator(), of_others))
        {
          (void)sender;
          owned.insert(entries.begin(), entries.end());
        }
      return owned;
    }

    /** Tell the ranks beside this one of the roots of its cells. Collective. */
    template <int dim>
    void
    exchange(const BackgroundGrid<dim> &grid,
             const unsigned int         n_bodies,
             Roots<dim>                &roots)
    {
      if (dealii::Utilities::MPI::n_mpi_processes(grid.communicator()) == 1)
        return;
      using Cell = typename BackgroundGrid<dim>::Cell;
      // body, layer, cell and ids
      using Entry =
        std::array<global_dof_index, 2 + dim + Follower<dim>::n_roots>;
      using Data = std::vector<Entry>;
      dealii::GridTools::exchange_cell_data_to_ghosts<Data>(
        grid.triangulation(),
        [&](const Cell &cell) {
          Data       data;
          const auto lattice = grid.lattice(cell->center());
          for (unsigned int body = 0; body < n_bodies; ++body)
            if (const auto found = roots.find({body, lattice});
                found != roots.end())
              {
                const Root<dim> &root = found->second;
                Entry            entry{{body, root.layer}};
                std::copy(root.cell.begin(),
                          root.cell.end(),
                          entry.begin() + 2);
                std::copy(root.ids.begin(),
                          root.ids.end(),
                          entry.begin() + 2 + dim);
                data.push_back(entry);
              }
          return data;
        },
        [&](const Cell &cell, const Data &data) {
          const auto lattice = grid.lattice(cell->center());
          for (const Entry &entry : data)
            {
              Root<dim> root;
              root.layer = entry[1];
              std::copy_n(entry.begin() + 2, dim, root.cell.begin());
              std::copy_n(entry.begin() + 2 + dim,
                          Follower<dim>::n_roots,
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

    /** The preferred root of some cells; null if they have none. */
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

    /** Layer by layer, cells without a root take one from a neighbour. */
    template <int dim>
    void
    spread(const std::set<CellOfBody<dim>> &owned,
           const unsigned int               n_bodies,
           const BackgroundGrid<dim>       &grid,
           Roots<dim>                      &roots)
    {
      exchange(grid, n_bodies, roots);
      for (unsigned int i = 0; i < Aggregation<dim>::farthest_layer; ++i)
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
              if (root && root->layer < Aggregation<dim>::farthest_layer)
                found[cell] = {root->layer + 1, root->cell, root->ids};
            }
          roots.insert(found.begin(), found.end());
          exchange(grid, n_bodies, roots);
        }
    }

    /**
     * The roots of all cells of this rank and beside it. Nodes of roots below
     * the threshold become free. Collective.
     */
    template <int dim>
    Roots<dim>
    find_roots(const Stencils<dim>       &stencils,
               const double               threshold,
               const BackgroundGrid<dim> &grid,
               Nodes                     &nodes)
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
          spread(owned, nodes.n_bodies, grid, roots);
        }
      nodes.is_free.compress(dealii::VectorOperation::max);
      return roots;
    }

    /** By component and by node of the root: what owners tell of a node. */
    using Fields = std::vector<Exchange>;

    /**
     * The owner of a node chooses its root, as it knows all cells around.
     * @return at each owned node the root's place in the lattice plus one, 0 if
     *   there is none, and the ids of the root's nodes (numbers are exact in
     *   double up to 2^53)
     */
    template <int dim>
    Fields
    choose(const Nodes               &nodes,
           const Roots<dim>          &roots,
           const BackgroundGrid<dim> &grid)
    {
      Fields fields(dim + Follower<dim>::n_roots, Exchange(grid.nodes()));
      for (const unsigned int node : nodes.active)
        {
          if (nodes.is_free.local_element(node) > 0.)
            continue;
          const auto lattice = node_lattice<dim>(
            grid.node_position(grid.nodes()->local_to_global(node)), grid);
          std::array<int, dim> first, place;
          for (unsigned int d = 0; d < dim; ++d)
            {
              first[d] = lattice[d] - 1;
              place[d] = 2 * lattice[d];
            }
          const Root<dim> *root =
            preferred<dim>(roots, first, 2, nodes.body[node], place, grid);
          Assert(root, dealii::ExcInternalError());
          for (unsigned int d = 0; d < dim; ++d)
            fields[d].local_element(node) = root->cell[d] + 1.;
          for (unsigned int v = 0; v < Follower<dim>::n_roots; ++v)
            fields[dim + v].local_element(node) = root->ids[v];
        }
      return fields;
    }

    template <int dim>
    Follower<dim>
    make_follower(const Fields              &fields,
                  const unsigned int         node,
                  const BackgroundGrid<dim> &grid)
    {
      Follower<dim> follower;
      follower.node_id = grid.nodes()->local_to_global(node);
      follower.weights.fill(1.);
      const auto lattice =
        node_lattice<dim>(grid.node_position(follower.node_id), grid);
      for (unsigned int d = 0; d < dim; ++d)
        {
          follower.root[d]   = fields[d].local_element(node) - 1.;
          const int distance = lattice[d] - int(follower.root[d]);
          for (unsigned int v = 0; v < Follower<dim>::n_roots; ++v)
            follower.weights[v] *= (v >> d) & 1 ? distance : 1 - distance;
          follower.distance =
            std::max<int>(follower.distance, std::max(-distance, distance - 1));
        }
      for (unsigned int v = 0; v < Follower<dim>::n_roots; ++v)
        follower.root_ids[v] = fields[dim + v].local_element(node);
      return follower;
    }
  } // namespace

  template <int dim>
  dealii::Point<dim>
  Follower<dim>::root_position(const unsigned int         vertex,
                               const BackgroundGrid<dim> &grid) const
  {
    dealii::Point<dim> result = grid.lower_corner();
    for (unsigned int d = 0; d < dim; ++d)
      result[d] += (root[d] + ((vertex >> d) & 1)) * grid.cell_size()[d];
    return result;
  }

  template <int dim>
  std::string
  Aggregates<dim>::text() const
  {
    return std::to_string(n_followers) +
           " starved nodes follow roots at most " +
           std::to_string(farthest_root) +
           " cells away, the largest weight is " +
           std::to_string(std::lround(largest_weight)) +
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
  Aggregates<dim>
  Aggregation<dim>::operator()(const Stencils<dim>       &stencils,
                               const PointArrays<dim>    &points,
                               const BackgroundGrid<dim> &grid) const
  {
    Nodes            nodes       = weigh(stencils,
                        points.component(mass_component),
                        points.component(volume_component),
                        threshold,
                        grid);
    const Roots<dim> roots       = find_roots(stencils, threshold, grid, nodes);
    const Fields     fields      = choose<dim>(nodes, roots, grid);
    std::uint64_t    n_followers = 0, n_kept = 0;
    for (const unsigned int node : nodes.active)
      if (nodes.is_free.local_element(node) == 0.)
        ++n_followers;
      else if (!reaches(nodes.part.local_element(node), threshold))
        ++n_kept;
    const MPI_Comm  communicator = grid.communicator();
    Aggregates<dim> result;
    result.n_followers = dealii::Utilities::MPI::sum(n_followers, communicator);
    result.n_kept      = dealii::Utilities::MPI::sum(n_kept, communicator);
    if (result.n_followers == 0)
      return result;

    for (const Exchange &field : fields)
      field.update_ghost_values();
    const unsigned int n_known =
      grid.nodes()->locally_owned_size() + grid.nodes()->n_ghost_indices();
    for (unsigned int node = 0; node < n_known; ++node)
      if (fields[0].local_element(node) > 0.)
        result.followers.push_back(make_follower<dim>(fields, node, grid));
    for (const Follower<dim> &follower : result.followers)
      {
        result.farthest_root =
          std::max(result.farthest_root, follower.distance);
        for (const double weight : follower.weights)
          result.largest_weight =
            std::max(result.largest_weight, std::abs(weight));
      }
    result.farthest_root =
      dealii::Utilities::MPI::max(result.farthest_root, communicator);
    result.largest_weight =
      dealii::Utilities::MPI::max(result.largest_weight, communicator);
    return result;
  }

  template struct Follower<2>;
  template struct Follower<3>;
  template struct Aggregates<2>;
  template struct Aggregates<3>;
  template class Aggregation<2>;
  template class Aggregation<3>;
} // namespace emmy
