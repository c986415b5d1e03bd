#include <emmy/base/text.h>
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

  template <int dim>
  BodyContact<dim>::BodyContact(ContactRules<dim>                 given,
                                std::vector<std::string>          group_names,
                                const Fields                     &fields,
                                std::vector<ParticleCorners<dim>> corners)
    : rules(std::move(given))
    , group_names(std::move(group_names))
    , fields(fields)
    , corners_of_body(std::move(corners))
    , points_of_body(contact_points(rules))
    , least_margin(rules.largest_reach() / rules.radius *
                   rules.points_per_direction)
    , margin(least_margin)
  {
    found.force.resize(this->group_names.size());
  }

  template <int dim>
  std::vector<std::vector<Tensor<1, dim>>>
  BodyContact<dim>::contact_points(const ContactRules<dim> &rules)
  {
    std::vector<std::vector<Tensor<1, dim>>> result(rules.bodies.size());
    for (unsigned int body = 0; body < result.size(); ++body)
      for (unsigned int k = 0; k < rules.n_points(); ++k)
        result[body].push_back(rules.point(body, k));
    return result;
  }

  template <int dim>
  std::string
  BodyContact<dim>::mark(const BackgroundGrid<dim>               &grid,
                         dealii::Particles::ParticleHandler<dim> &given) const
  {
    const MPI_Comm     communicator = grid.communicator();
    const unsigned int here =
      dealii::Utilities::MPI::this_mpi_process(communicator);
    std::vector<ContactParticle<dim>> particles;
    for (const auto &particle : given)
      {
        const auto         properties = particle.get_properties();
        const unsigned int body       = properties[fields.body];
        if (rules.bodies[body].group == none)
          continue;
        Tensor<2, dim> F;
        for (unsigned int i = 0; i < dim * dim; ++i)
          F[i / dim][i % dim] = properties[fields.deformation_gradient + i];
        particles.push_back({particle.get_id(),
                             body,
                             here,
                             particles.size(),
                             particle.get_location(),
                             F});
      }
    const auto near = find_candidates(
      rules,
      with_those_near(rules, std::move(particles), 0., communicator),
      0.,
      here);
    found.overlap  = 0.;
    double deepest = 0.;
    for (const ParticlePair &pair : near.pairs)
      {
        const auto &one = near.particles[pair.first],
                   &two = near.particles[pair.second];
        if (one.owner != here)
          continue;
        const PairLaw law = rules.law(one.body, two.body);
        for (const auto &[i, j] : pair.points)
          {
            const Tensor<1, dim> x =
              one.place + one.F * rules.point(one.body, i) - two.place -
              two.F * rules.point(two.body, j);
            const double gap = x.norm() - law.reach;
            found.overlap += pair_energy(law, gap);
            deepest = std::max(deepest, -gap / law.reach);
          }
      }
    const double stored =
      dealii::Utilities::MPI::sum(found.overlap, grid.communicator());
    deepest = dealii::Utilities::MPI::max(deepest, grid.communicator());
    return "contact between " + join(group_names) + ": points act from " +
           brief(rules.largest_reach()) + " m on" +
           (stored > 0.
              ? "; some are nearer at the start, by up to " + brief(deepest) +
                  " of that, which stores " + brief(stored) + " J"
              : std::string());
  }

  template <int dim>
  std::vector<double>
  BodyContact<dim>::contents() const
  {
    std::vector<double> result{margin};
    for (const auto &[key, spring] : springs)
      {
        for (const std::uint64_t part : key)
          result.push_back(part); // exact up to 2^53
        for (unsigned int d = 0; d < dim; ++d)
          result.push_back(spring[d]);
      }
    return result;
  }

  template <int dim>
  void
  BodyContact<dim>::recall(const std::vector<std::vector<double>> &parts)
  {
    margin = parts.at(0).at(0);
    springs.clear();
    for (std::size_t part = 1; part < parts.size(); ++part)
      for (std::size_t i = 1; i < parts[part].size(); i += 4 + dim)
        {
          const auto from = parts[part].begin() + i;
          PairKey    key;
          std::copy_n(from, key.size(), key.begin());
          Tensor<1, dim> &spring = springs[key];
          for (unsigned int d = 0; d < dim; ++d)
            spring[d] = from[4 + d];
        }
  }

  template <int dim>
  std::vector<ContactParticle<dim>>
  BodyContact<dim>::in_groups(const Stencils<dim>    &stencils,
                              const PointArrays<dim> &points,
                              const unsigned int      rank) const
  {
    std::vector<ContactParticle<dim>> result;
    for (std::size_t p = 0; p < points.n_points(); ++p)
      {
        const unsigned int body = points.component(fields.body)[p];
        if (rules.bodies[body].group != none)
          result.push_back(
            {stencils.particles[p]->get_id(),
             body,
             rank,
             stencils.order[p],
             points.point(p),
             tensor_field(points, fields.deformation_gradient, p)});
      }
    return result;
  }

  template <int dim>
  void
  BodyContact<dim>::classify(const Stencils<dim>       &stencils,
                             const PointArrays<dim>    &points,
                             const BackgroundGrid<dim> &grid)
  {
    const MPI_Comm communicator = grid.communicator();
    here = dealii::Utilities::MPI::this_mpi_process(communicator);
    candidates =
      find_candidates(rules,
                      with_those_near(rules,
                                      in_groups(stencils, points, here),
                                      margin,
                                      communicator),
                      margin,
                      here);
    laws.clear();
    for (const ParticlePair &pair : candidates.pairs)
      laws.push_back(rules.law(candidates.particles[pair.first].body,
                               candidates.particles[pair.second].body));
    is_coupled.assign(candidates.pairs.size(), false);
    exchange.begin(candidates, communicator);
    if (has_friction())
      springs_held = exchange.springs_of(candidates, springs);
  }

  namespace
  {
    /** W of a point, [(dim + 1) a + l]. */
    template <int dim>
    std::vector<double>
    weights_of(const Stencils<dim>                 &stencils,
               const typename Stencils<dim>::Group &group,
               const unsigned int                   q)
    {
      std::vector<double> result;
      result.reserve((dim + 1) * group.n_nodes);
      for (unsigned int a = 0; a < group.n_nodes; ++a)
        {
          result.push_back(stencils.value(group, a)[q]);
          for (unsigned int d = 0; d < dim; ++d)
            result.push_back(stencils.gradient(group, a, d)[q]);
        }
      return result;
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
    find_coupled(stencils.at_middle);

    find_cliques();
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
  void
  BodyContact<dim>::find_cliques()
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
    std::vector<std::array<unsigned int, 3>> coupled;
    for (unsigned int k = 0; k < candidates.pairs.size(); ++k)
      if (is_coupled[k])
        coupled.push_back({{where[candidates.pairs[k].first].nodes,
                            where[candidates.pairs[k].second].nodes,
                            k}});
    std::sort(coupled.begin(), coupled.end());
    cliques.clear();
    for (std::size_t n = 0; n < coupled.size(); ++n)
      {
        const auto &[first, second, k] = coupled[n];
        if (n == 0 || coupled[n - 1][0] != first || coupled[n - 1][1] != second)
          cliques.emplace_back();
        cliques.back().pairs.push_back(k);
      }
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
    at_point.assign(stencils.order.size(), none);
    in_order.clear();
    for (unsigned int g = 0; g < stencils.groups.size(); ++g)
      for (unsigned int q = 0; q < stencils.groups[g].n_points; ++q)
        {
          const Group       &group = stencils.groups[g];
          const std::size_t  p     = group.first_point + q;
          const unsigned int i     = at_place[stencils.order[p]];
          if (i == none)
            continue;
          const auto begin = stencils.node_ids.begin() + group.first_node;
          dealii::Point<dim> place;
          for (unsigned int a = 0; a < group.n_nodes; ++a)
            place += stencils.value(group, a)[q] *
                     dealii::Tensor<1, dim>(grid.node_position(begin[a]));
          where[i]    = {g,
                         q,
                         0,
                         place,
                         NodeIds(begin, begin + group.n_nodes),
                         weights_of(stencils, group, q)};
          at_point[p] = i;
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

  template <int dim>
  void
  BodyContact<dim>::end_step(const double, const double)
  {
    springs = std::move(found.springs);
    found.springs.clear();
  }

  template <int dim>
  std::vector<EnergyEntry>
  BodyContact<dim>::energy_entries() const
  {
    using Kind = EnergyEntry::Kind;
    std::vector<EnergyEntry> entries{{"contact_energy", Kind::stored, 0.}};
    if (has_friction())
      {
        entries.push_back({"friction_energy", Kind::stored, 0.});
        entries.push_back({"friction_dissipation", Kind::dissipated, 0.});
      }
    entries.push_back({"contact_overlap_work", Kind::work, 0.});
    return entries;
  }

  template <int dim>
  std::vector<EnergyEntry>
  BodyContact<dim>::energies_at_start(const PointArrays<dim> &,
                                      const double) const
  {
    std::vector<EnergyEntry> entries = energy_entries();
    entries.front().change = entries.back().change = found.overlap;
    return entries;
  }

  template <int dim>
  std::vector<std::string>
  BodyContact<dim>::columns_of(const std::vector<std::string> &group_names)
  {
    std::vector<std::string> columns;
    for (const std::string &name : group_names)
      for (unsigned int d = 0; d < dim; ++d)
        columns.push_back("contact_" + name + "_force_" + "xyz"[d]);
    columns.push_back("contact_pairs");
    return columns;
  }

  template <int dim>
  std::vector<StepMeasure>
  BodyContact<dim>::measure(const PointArrays<dim> &,
                            const double,
                            const BackgroundGrid<dim> &grid)
  {
    std::vector<double> values;
    for (const Tensor<1, dim> &force : found.force)
      for (unsigned int d = 0; d < dim; ++d)
        values.push_back(force[d]);
    values.push_back(found.n_touching);
    dealii::Utilities::MPI::sum(values, grid.communicator(), values);
    const auto               names = columns_of(group_names);
    std::vector<StepMeasure> result;
    for (unsigned int i = 0; i < values.size(); ++i)
      result.push_back({names[i], values[i]});
    return result;
  }

  template class BodyContact<2>;
  template class BodyContact<3>;
} // namespace emmy
