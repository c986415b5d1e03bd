#include <emmy/effects/body_contact.h>

#include <algorithm>
#include <numeric>

namespace emmy
{
  using dealii::Tensor;

  namespace
  {
    constexpr unsigned int none = std::numeric_limits<unsigned int>::max();
  } // namespace

  // Nodes of BodyContact: whose nodes couple.

  namespace
  {
    /** W of a point into [(dim + 1) a + l]; its place, as its nodes say. */
    template <int dim>
    dealii::Point<dim>
    set_weights(const Stencils<dim>                 &stencils,
                const typename Stencils<dim>::Group &group,
                const unsigned int                   q,
                const BackgroundGrid<dim>           &grid,
                std::vector<double>                 &weights)
    {
      weights.resize((dim + 1) * group.n_nodes);
      const auto        *id = &stencils.node_ids[group.first_node];
      dealii::Point<dim> place;
      for (unsigned int a = 0; a < group.n_nodes; ++a)
        {
          double *W = &weights[(dim + 1) * a];
          W[0]      = stencils.value(group, a)[q];
          for (unsigned int d = 0; d < dim; ++d)
            W[1 + d] = stencils.gradient(group, a, d)[q];
          place += W[0] * dealii::Tensor<1, dim>(grid.node_position(id[a]));
        }
      return place;
    }
  } // namespace

  template <int dim>
  void
  BodyContact<dim>::couple(const Stencils<dim>       &stencils,
                           const BackgroundGrid<dim> &grid,
                           const BoundaryConditions<dim> &,
                           Couplings<dim> &couplings)
  {
    find_where(stencils, grid);
    if (exchange.is_needed())
      exchange_nodes(grid, couplings);
    number_nodes();
    find_coupled(stencils.at_middle);

    cliques = cliques_now();
    for (Clique &clique : cliques)
      {
        const ParticlePair &pair = candidates.pairs[clique.pairs.front()];
        clique.coupled           = couplings.node_ids.size();
        unsigned int n           = 0;
        for (const unsigned int i : {pair.first, pair.second})
          {
            couplings.node_ids.insert(couplings.node_ids.end(),
                                      where[i].ids.begin(),
                                      where[i].ids.end());
            n += where[i].n_nodes();
          }
        couplings.group_sizes.push_back(n);
      }
  }

  template <int dim>
  bool
  BodyContact<dim>::take_weights(const Stencils<dim>       &stencils,
                                 const BackgroundGrid<dim> &grid)
  {
    renew_weights(stencils, grid);
    find_coupled(stencils.at_middle);
    std::vector<Clique> now     = cliques_now();
    const bool          is_same = std::equal(now.begin(),
                                    now.end(),
                                    cliques.begin(),
                                    cliques.end(),
                                    [](const Clique &one, const Clique &other) {
                                      return one.lists == other.lists;
                                    });
    if (exchange.is_needed() &&
        dealii::Utilities::MPI::min(is_same ? 1 : 0, grid.communicator()) == 0)
      return false;
    if (!is_same)
      return false;
    for (std::size_t n = 0; n < now.size(); ++n)
      now[n].coupled = cliques[n].coupled;
    cliques = std::move(now);
    return true;
  }

  template <int dim>
  void
  BodyContact<dim>::number_nodes()
  {
    // numbered by their nodes: the same couplings in any order of particles
    std::vector<unsigned int> order(where.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [this](const auto i, const auto j) {
      return is_before(i, j);
    });
    unsigned int number = 0;
    for (std::size_t n = 0; n < order.size(); ++n)
      {
        if (n > 0 && is_before(order[n - 1], order[n]))
          ++number;
        where[order[n]].nodes = number;
      }
  }

  template <int dim>
  std::vector<typename BodyContact<dim>::Clique>
  BodyContact<dim>::cliques_now() const
  {
    std::vector<std::array<unsigned int, 3>> coupled;
    for (unsigned int k = 0; k < candidates.pairs.size(); ++k)
      if (is_coupled[k])
        coupled.push_back({{where[candidates.pairs[k].first].nodes,
                            where[candidates.pairs[k].second].nodes,
                            k}});
    std::sort(coupled.begin(), coupled.end());
    std::vector<Clique> result;
    for (const auto &[first, second, k] : coupled)
      {
        const std::array<unsigned int, 2> lists{{first, second}};
        if (result.empty() || result.back().lists != lists)
          result.push_back({lists, {}});
        result.back().pairs.push_back(k);
      }
    return result;
  }

  template <int dim>
  bool
  BodyContact<dim>::nearly_touch(const ParticlePair &pair) const
  {
    // arms may turn and stretch
    constexpr double            slack = 0.25;
    const ContactParticle<dim> &one   = candidates.particles[pair.first],
                               &two   = candidates.particles[pair.second];
    const double reach                = rules.reach(one.body, two.body);
    const double near                 = (1. + slack / rules.radius) * reach;
    // places are those of the middle of the step
    const Tensor<1, dim> between = one.place - two.place;
    const Tensor<1, dim> way =
      2. * (where[pair.first].place - where[pair.second].place - between);
    return std::any_of(pair.points.begin(),
                       pair.points.end(),
                       [&](const auto &points) {
                         const Tensor<1, dim> x =
                           between +
                           one.F * points_of_body[one.body][points[0]] -
                           two.F * points_of_body[two.body][points[1]];
                         return x.norm_square() < near * near ||
                                (x + way).norm_square() < near * near;
                       });
  }

  template <int dim>
  void
  BodyContact<dim>::find_coupled(const bool at_middle)
  {
    for (unsigned int k = 0; k < is_coupled.size(); ++k)
      is_coupled[k] =
        is_coupled[k] || !at_middle || nearly_touch(candidates.pairs[k]);
  }

  template <int dim>
  void
  BodyContact<dim>::find_where(const Stencils<dim>       &stencils,
                               const BackgroundGrid<dim> &grid)
  {
    const auto               &particles = candidates.particles;
    std::vector<unsigned int> at_place(stencils.order.size(), none);
    for (unsigned int i = 0; i < particles.size(); ++i)
      if (particles[i].owner == here)
        at_place[particles[i].index] = i;
    where.assign(particles.size(), {none, none, 0, {}, {}, {}});
    in_order.clear();
    for (unsigned int g = 0; g < stencils.groups.size(); ++g)
      for (unsigned int q = 0; q < stencils.groups[g].n_points; ++q)
        {
          const Group       &group = stencils.groups[g];
          const unsigned int i =
            at_place[stencils.order[group.first_point + q]];
          if (i == none)
            continue;
          const auto begin = stencils.node_ids.begin() + group.first_node;
          where[i].group   = g;
          where[i].point   = q;
          where[i].ids     = NodeIds(begin, begin + group.n_nodes);
          where[i].place =
            set_weights(stencils, group, q, grid, where[i].weights);
          in_order.push_back(i);
        }
  }

  namespace
  {
    template <int dim>
    void
    append(const dealii::Point<dim> &x, std::vector<double> &numbers)
    {
      numbers.insert(numbers.end(), x.begin_raw(), x.end_raw());
    }

    template <int dim>
    dealii::Point<dim>
    point_from(std::vector<double>::const_iterator &number)
    {
      dealii::Point<dim> x;
      for (unsigned int d = 0; d < dim; ++d)
        x[d] = *number++;
      return x;
    }

    /** How many masters, and of each its id, weight and position. */
    template <int dim>
    void
    append_masters(const TiedNode<dim> &node, std::vector<double> &numbers)
    {
      numbers.push_back(node.masters.size());
      for (const auto &master : node.masters)
        {
          numbers.push_back(master.id);
          numbers.push_back(master.weight);
          append(master.position, numbers);
        }
    }

    template <int dim>
    std::vector<typename TiedNode<dim>::Master>
    masters_from(std::vector<double>::const_iterator &number)
    {
      std::vector<typename TiedNode<dim>::Master> masters(
        static_cast<unsigned int>(*number++));
      for (auto &master : masters)
        {
          master.id = static_cast<dealii::types::global_dof_index>(*number++);
          master.weight   = *number++;
          master.position = point_from<dim>(number);
        }
      return masters;
    }
  } // namespace

  template <int dim>
  void
  BodyContact<dim>::renew_weights(const Stencils<dim>       &stencils,
                                  const BackgroundGrid<dim> &grid)
  {
    for (const unsigned int i : in_order)
      where[i].place = set_weights(stencils,
                                   stencils.groups[where[i].group],
                                   where[i].point,
                                   grid,
                                   where[i].weights);
    if (!exchange.is_needed())
      return;
    // by particle: its place, then W
    std::vector<std::vector<double>> numbers(where.size());
    for (const unsigned int i : in_order)
      {
        append(where[i].place, numbers[i]);
        numbers[i].insert(numbers[i].end(),
                          where[i].weights.begin(),
                          where[i].weights.end());
      }
    exchange(numbers);
    for (unsigned int i = 0; i < where.size(); ++i)
      if (!is_mine(i))
        {
          auto number      = numbers[i].cbegin();
          where[i].place   = point_from<dim>(number);
          where[i].weights = {number, numbers[i].cend()};
        }
  }

  template <int dim>
  void
  BodyContact<dim>::exchange_nodes(const BackgroundGrid<dim> &grid,
                                   Couplings<dim>            &couplings)
  {
    std::map<dealii::types::global_dof_index, std::size_t> tied;
    for (std::size_t i = 0; i < couplings.tied_nodes.size(); ++i)
      tied[couplings.tied_nodes[i].id] = i;
    // by node: id, position, W, whom it follows
    std::vector<std::vector<double>> numbers(where.size());
    for (const unsigned int i : in_order)
      for (unsigned int a = 0; a < where[i].n_nodes(); ++a)
        {
          const auto id = where[i].ids[a];
          numbers[i].push_back(id);
          append(grid.node_position(id), numbers[i]);
          const auto weights = where[i].weights.begin() + (dim + 1) * a;
          numbers[i].insert(numbers[i].end(), weights, weights + dim + 1);
          const auto found = tied.find(id);
          append_masters(found == tied.end()
                           ? TiedNode<dim>()
                           : couplings.tied_nodes[found->second],
                         numbers[i]);
        }
    exchange(numbers);

    std::map<dealii::types::global_dof_index, dealii::Point<dim>> far;
    for (unsigned int i = 0; i < where.size(); ++i)
      {
        const auto end    = numbers[i].cend();
        auto       number = is_mine(i) ? end : numbers[i].cbegin();
        while (number != end)
          {
            const auto id =
              static_cast<dealii::types::global_dof_index>(*number++);
            const auto x = point_from<dim>(number);
            where[i].ids.push_back(id);
            where[i].place += *number * Tensor<1, dim>(x);
            where[i].weights.insert(where[i].weights.end(),
                                    number,
                                    number + dim + 1);
            number += dim + 1;
            if (!grid.nodes()->in_local_range(id) &&
                !grid.nodes()->is_ghost_entry(id))
              far[id] = x;
            auto masters = masters_from<dim>(number);
            if (!masters.empty() &&
                tied.emplace(id, couplings.tied_nodes.size()).second)
              couplings.tied_nodes.push_back({id, std::move(masters)});
          }
      }
    couplings.far_nodes.assign(far.begin(), far.end());
    couplings.has_far_nodes =
      dealii::Utilities::MPI::max(far.empty() ? 0 : 1, grid.communicator()) > 0;
  }

  template void
  BodyContact<2>::couple(const Stencils<2> &,
                         const BackgroundGrid<2> &,
                         const BoundaryConditions<2> &,
                         Couplings<2> &);
  template bool
  BodyContact<2>::take_weights(const Stencils<2> &, const BackgroundGrid<2> &);
  template void
  BodyContact<3>::couple(const Stencils<3> &,
                         const BackgroundGrid<3> &,
                         const BoundaryConditions<3> &,
                         Couplings<3> &);
  template bool
  BodyContact<3>::take_weights(const Stencils<3> &, const BackgroundGrid<3> &);
} // namespace emmy
