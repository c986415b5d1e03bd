#include <emmy/transfer/aggregation.h>
#include <emmy/transfer/roots.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

namespace emmy
{
  namespace
  {
    using Exchange = Feeding::Values;

    /** int N_A, m^dim. */
    template <int dim>
    double
    volume_of_node(const typename BackgroundGrid<dim>::Lattice &place,
                   const BackgroundGrid<dim>                   &grid)
    {
      double volume = 1.;
      for (unsigned int d = 0; d < dim; ++d)
        volume *= (place[d] == 0 || place[d] == grid.n_cells()[d] ? 0.5 : 1.) *
                  grid.cell_size()[d];
      return volume;
    }

    /** What the points of a body give a node. */
    struct Share
    {
      dealii::types::global_dof_index node_id;
      unsigned int                    body;
      double                          mass; // kg

      template <class Archive>
      void
      serialize(Archive &archive, const unsigned int /*version*/)
      {
        archive &node_id &body &mass;
      }
    };

    /** One share for each node and body, sorted; the sum of those there are. */
    void
    merge(std::vector<Share> &shares)
    {
      // stable: the order of a sum must not depend on other bodies
      std::stable_sort(shares.begin(),
                       shares.end(),
                       [](const Share &a, const Share &b) {
                         return std::tie(a.node_id, a.body) <
                                std::tie(b.node_id, b.body);
                       });
      std::size_t n = 0;
      for (const Share &share : shares)
        if (n > 0 && shares[n - 1].node_id == share.node_id &&
            shares[n - 1].body == share.body)
          shares[n - 1].mass += share.mass;
        else
          shares[n++] = share;
      shares.resize(n);
    }

    /** The shares of owned nodes, merged, and the largest density. Collective.
     */
    template <int dim>
    std::vector<Share>
    collect_shares(const Stencils<dim>       &stencils,
                   const double              *mass,
                   const double              *volume,
                   const BackgroundGrid<dim> &grid,
                   Exchange                  &density)
    {
      std::vector<Share> shares;
      for (const auto &group : stencils.groups)
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
            shares.push_back(
              {id,
               group.body,
               std::max(sum, std::numeric_limits<double>::min())});
            density(id) = std::max<double>(density(id), largest_density);
          }
      merge(shares);

      // ghosts are sorted by their owners
      const auto                                &nodes = *grid.nodes();
      std::map<unsigned int, std::vector<Share>> of_others;
      std::vector<Share>                         result;
      for (const Share &share : shares)
        if (nodes.in_local_range(share.node_id))
          result.push_back(share);
        else
          {
            unsigned int ghost =
              nodes.global_to_local(share.node_id) - nodes.locally_owned_size();
            auto owner = nodes.ghost_targets().begin();
            for (; ghost >= owner->second; ++owner)
              ghost -= owner->second;
            of_others[owner->first].push_back(share);
          }
      for (const auto &[sender, from_there] :
           dealii::Utilities::MPI::some_to_some(grid.communicator(), of_others))
        {
          (void)sender;
          result.insert(result.end(), from_there.begin(), from_there.end());
        }
      merge(result);
      density.compress(dealii::VectorOperation::max);
      return result;
    }

    /** Find how all nodes are fed; the threshold says which are free. */
    template <int dim>
    Feeding
    weigh(const Stencils<dim>       &stencils,
          const double              *mass,
          const double              *volume,
          const double               threshold,
          const BackgroundGrid<dim> &grid)
    {
      Feeding    result;
      Exchange   density(grid.nodes());
      const auto shares = collect_shares(stencils, mass, volume, grid, density);
      const unsigned int  n_owned = density.locally_owned_size();
      std::vector<double> total(n_owned), largest(n_owned);
      result.body.resize(n_owned);
      for (const Share &share : shares)
        {
          const unsigned int i = grid.nodes()->global_to_local(share.node_id);
          total[i] += share.mass;
          if (!reaches(largest[i], share.mass))
            {
              largest[i]     = share.mass;
              result.body[i] = share.body;
            }
        }

      result.part.reinit(grid.nodes());
      result.is_free.reinit(grid.nodes());
      for (unsigned int i = 0; i < n_owned; ++i)
        if (density.local_element(i) > 0.)
          {
            const auto id = grid.nodes()->local_to_global(i);
            result.part.local_element(i) =
              total[i] / (density.local_element(i) *
                          volume_of_node<dim>(grid.node_lattice(id), grid));
            result.is_free.local_element(i) =
              reaches(result.part.local_element(i), threshold);
            result.active.push_back(i);
          }
      result.part.update_ghost_values();
      return result;
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
    choose(const Feeding             &nodes,
           const Roots<dim>          &roots,
           const BackgroundGrid<dim> &grid)
    {
      Fields fields(dim + Follower<dim>::n_roots, Exchange(grid.nodes()));
      for (const unsigned int node : nodes.active)
        {
          if (nodes.is_free.local_element(node) > 0.)
            continue;
          const auto &lattice =
            grid.node_lattice(grid.nodes()->local_to_global(node));
          std::array<int, dim> first, place;
          for (unsigned int d = 0; d < dim; ++d)
            {
              first[d] = int(lattice[d]) - 1;
              place[d] = 2 * int(lattice[d]);
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
      const auto &lattice = grid.node_lattice(follower.node_id);
      for (unsigned int d = 0; d < dim; ++d)
        {
          follower.root[d]   = fields[d].local_element(node) - 1.;
          const int distance = int(lattice[d]) - int(follower.root[d]);
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
    typename BackgroundGrid<dim>::Lattice place;
    for (unsigned int d = 0; d < dim; ++d)
      place[d] = root[d] + ((vertex >> d) & 1);
    return grid.corner(place);
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
    Feeding          nodes       = weigh(stencils,
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
    // the order must not depend on which part of the grid has cells
    std::sort(result.followers.begin(),
              result.followers.end(),
              [&](const auto &a, const auto &b) {
                return grid.node_lattice(a.node_id) <
                       grid.node_lattice(b.node_id);
              });
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
