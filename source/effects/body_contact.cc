#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/effects/body_contact.h>
#include <emmy/effects/moving_places.h>

#include <algorithm>

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
    , least_margin(rules.largest_reach() / rules.radius *
                   rules.points_per_direction)
    , margin(least_margin)
  {
    found.force.resize(this->group_names.size());
  }

  template <int dim>
  std::string
  BodyContact<dim>::mark(const BackgroundGrid<dim>               &grid,
                         dealii::Particles::ParticleHandler<dim> &given) const
  {
    AssertThrow(dealii::Utilities::MPI::n_mpi_processes(grid.communicator()) ==
                  1,
                ExcRun("Effects/Contact",
                       "pairs of particles on several ranks are not known yet",
                       "run on one rank."));
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
                             particles.size(),
                             particle.get_location(),
                             F});
      }
    const auto near = find_candidates(rules, std::move(particles), 0.);
    found.overlap   = 0.;
    double deepest  = 0.;
    for (const ParticlePair &pair : near.pairs)
      {
        const auto &one   = near.particles[pair.first],
                   &two   = near.particles[pair.second];
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
  BodyContact<dim>::memory() const
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
                              const PointArrays<dim> &points) const
  {
    std::vector<ContactParticle<dim>> result;
    for (std::size_t p = 0; p < points.n_points(); ++p)
      {
        const unsigned int body = points.component(fields.body)[p];
        if (rules.bodies[body].group != none)
          result.push_back(
            {stencils.particles[p]->get_id(),
             body,
             stencils.order[p],
             points.point(p),
             tensor_field(points, fields.deformation_gradient, p)});
      }
    return result;
  }

  template <int dim>
  void
  BodyContact<dim>::classify(const Stencils<dim>    &stencils,
                             const PointArrays<dim> &points,
                             const BackgroundGrid<dim> &)
  {
    candidates = find_candidates(rules, in_groups(stencils, points), margin);
  }

  template <int dim>
  void
  BodyContact<dim>::couple(const Stencils<dim> &stencils,
                           const BackgroundGrid<dim> &,
                           const BoundaryConditions<dim> &,
                           Couplings<dim> &couplings)
  {
    const auto               &particles = candidates.particles;
    std::vector<unsigned int> at_place(stencils.order.size(), none);
    for (unsigned int i = 0; i < particles.size(); ++i)
      at_place[particles[i].index] = i;
    where.resize(particles.size());
    at_point.assign(stencils.order.size(), none);
    in_order.clear();
    for (unsigned int g = 0; g < stencils.groups.size(); ++g)
      for (unsigned int q = 0; q < stencils.groups[g].n_points; ++q)
        {
          const std::size_t  p = stencils.groups[g].first_point + q;
          const unsigned int i = at_place[stencils.order[p]];
          if (i == none)
            continue;
          where[i]    = {g, q, g};
          at_point[p] = i;
          in_order.push_back(i);
        }

    std::map<std::pair<unsigned int, unsigned int>, std::vector<unsigned int>>
      by_nodes;
    for (unsigned int k = 0; k < candidates.pairs.size(); ++k)
      by_nodes[{where[candidates.pairs[k].first].nodes,
                where[candidates.pairs[k].second].nodes}]
        .push_back(k);
    cliques.clear();
    for (auto &[lists, pairs] : by_nodes)
      {
        cliques.push_back({lists.first,
                           lists.second,
                           couplings.node_ids.size(),
                           std::move(pairs)});
        unsigned int n = 0;
        for (const unsigned int list : {lists.first, lists.second})
          {
            const Group &group = stencils.groups[list];
            const auto   begin = stencils.node_ids.begin() + group.first_node;
            couplings.node_ids.insert(couplings.node_ids.end(),
                                      begin,
                                      begin + group.n_nodes);
            n += group.n_nodes;
          }
        couplings.group_sizes.push_back(n);
      }
  }

  template <int dim>
  CornerMotion<dim>
  BodyContact<dim>::particle(const StepData<dim>       &step,
                             const Group               &group,
                             const unsigned int         q,
                             const std::vector<double> &u) const
  {
    return corner_motion(step,
                         group,
                         q,
                         u,
                         corners_of_body[group.body],
                         fields.deformation_gradient);
  }

  template <int dim>
  PairPoint<dim>
  BodyContact<dim>::point(const State &state, const unsigned int index) const
  {
    const CornerMotion<dim> &motion = state.motion;
    PairPoint<dim>           result;
    result.particle  = motion.place;
    result.way       = motion.way;
    result.gradient  = motion.gradient;
    result.arm_old   = state.places[index] - motion.place;
    result.at_middle = motion.Z.norm_square() > 0.;
    result.Z         = motion.Z;
    result.arm = result.at_middle ? motion.Z * result.arm_old : result.arm_old;
    return result;
  }

  template <int dim>
  template <class Visit>
  std::vector<typename BodyContact<dim>::State>
  BodyContact<dim>::states(const StepData<dim>       &step,
                           const std::vector<double> &u,
                           const Visit               &visit) const
  {
    std::vector<State> result(candidates.particles.size());
    for (const Group &group : step.stencils.groups)
      for (unsigned int q = 0; q < group.n_points; ++q)
        {
          const auto motion = particle(step, group, q, u);
          visit(group, motion);
          const unsigned int i = at_point[motion.p];
          if (i == none)
            continue;
          State &state = result[i];
          state.motion = motion;
          for (unsigned int k = 0; k < rules.n_points(); ++k)
            {
              const Tensor<1, dim> xi = rules.point(group.body, k);
              state.places.push_back(motion.place + motion.F_old * xi);
              state.ways.push_back(motion.way_of(motion.F * xi));
            }
        }
    return result;
  }

  template <int dim>
  template <class Visit>
  void
  BodyContact<dim>::for_each_action(const std::vector<State> &states,
                                    const bool                with_derivative,
                                    const Visit              &visit) const
  {
    for (unsigned int k = 0; k < candidates.pairs.size(); ++k)
      {
        const ParticlePair &pair = candidates.pairs[k];
        const auto         &one  = candidates.particles[pair.first],
                   &two          = candidates.particles[pair.second];
        const PairLaw law        = rules.law(one.body, two.body);
        const double  reach      = law.reach * law.reach;
        for (const auto &[i, j] : pair.points)
          {
            const State &of_one         = states[pair.first],
                        &of_two         = states[pair.second];
            const Tensor<1, dim> before = of_one.places[i] - of_two.places[j];
            const Tensor<1, dim> after =
              before + of_one.ways[i] - of_two.ways[j];
            const PairKey  key{{one.id, two.id, i, j}};
            Tensor<1, dim> spring;
            if (!springs.empty())
              if (const auto held = springs.find(key); held != springs.end())
                spring = held->second;
            if (before.norm_square() >= reach && after.norm_square() >= reach &&
                spring.norm_square() == 0.)
              continue;
            visit(k,
                  key,
                  pair_action(law,
                              point(of_one, i),
                              point(of_two, j),
                              spring,
                              with_derivative));
          }
      }
  }

  template <int dim>
  std::string
  BodyContact<dim>::missing(const StepData<dim> &step,
                            const Vector        &displacement)
  {
    // how far any two particles have moved from one another, and their points
    const std::vector<double>   u   = step.start.active->to_local(displacement);
    constexpr double            all = std::numeric_limits<double>::max();
    std::vector<Tensor<1, dim>> ways;
    std::vector<double>         turns, bounds(2 * dim, -all);
    for (const Group &group : step.stencils.groups)
      for (unsigned int q = 0;
           q < group.n_points && rules.bodies[group.body].group != none;
           ++q)
        {
          const auto motion = particle(step, group, q, u);
          ways.push_back(motion.way);
          double arm = 0.;
          for (unsigned int d = 0; d < dim; ++d)
            {
              Tensor<1, dim> xi;
              xi[d] = motion.corners->half_length[d];
              arm += (motion.F * xi).norm();
              bounds[d]       = std::max(bounds[d], motion.way[d]);
              bounds[dim + d] = std::max(bounds[dim + d], -motion.way[d]);
            }
          turns.push_back(motion.gradient.norm() * arm);
        }
    const MPI_Comm communicator = step.start.active->communicator();
    dealii::Utilities::MPI::max(bounds, communicator, bounds);
    Tensor<1, dim> middle;
    for (unsigned int d = 0; d < dim; ++d)
      middle[d] = 0.5 * (bounds[d] - bounds[dim + d]);
    double need = 0.;
    for (std::size_t p = 0; p < ways.size(); ++p)
      need = std::max(need, 2. * ((ways[p] - middle).norm() + turns[p]));
    need = dealii::Utilities::MPI::max(need, communicator);

    const double looked = margin;
    if (need > looked)
      margin = 1.05 * need;
    else // for the next step
      margin = std::max(least_margin, 1.25 * need);
    return need > looked ? "bodies move by up to " + brief(need) +
                             " m past one another, and contact was looked for "
                             "in " +
                             brief(looked) + " m"
                         : "";
  }

  template <int dim>
  void
  BodyContact<dim>::end_step(const double, const double)
  {
    springs = std::move(found.springs);
    found.springs.clear();
  }

  template <int dim>
  std::string
  BodyContact<dim>::add(const StepData<dim> &step,
                        const Iterate<dim>  &iterate,
                        Vector              &force,
                        Matrix              *jacobian) const
  {
    const std::vector<double> &u = iterate.local_displacement;
    const auto                 now =
      states(step, u, [&](const Group &, const CornerMotion<dim> &motion) {
        const Tensor<2, dim> F = motion.F_new();
        for (unsigned int i = 0; i < dim * dim; ++i)
          iterate.trial.component(fields.deformation_gradient + i)[motion.p] =
            F[i / dim][i % dim];
      });
    std::vector<char>             acts(now.size(), false);
    std::vector<PointMotion<dim>> forces_on(now.size());
    std::vector<ByMotion>         by_own(jacobian ? now.size() : 0);
    std::vector<Across> across(jacobian ? candidates.pairs.size() : 0);
    for_each_action(now,
                    jacobian,
                    [&](const unsigned int k,
                        const PairKey &,
                        const PairAction<dim> &action) {
                      if (!action.acts)
                        return;
                      const auto &[first, second, points] = candidates.pairs[k];
                      (void)points;
                      acts[first] = acts[second] = true;
                      if (jacobian)
                        across[k].acts = true;
                      for (unsigned int i = 0; i < n_motion; ++i)
                        {
                          forces_on[first][i] += action.value[i];
                          forces_on[second][i] += action.value[n_motion + i];
                          for (unsigned int j = 0; jacobian && j < n_motion;
                               ++j)
                            {
                              by_own[first][i][j] += action.derivative[i][j];
                              by_own[second][i][j] +=
                                action.derivative[n_motion + i][n_motion + j];
                              across[k].first_by_second[i][j] +=
                                action.derivative[i][n_motion + j];
                              across[k].second_by_first[i][j] +=
                                action.derivative[n_motion + i][j];
                            }
                        }
                    });

    CornerForces<dim> forces(step, u, jacobian);
    for (unsigned int n = 0; n < in_order.size(); ++n)
      {
        const unsigned int i     = in_order[n];
        const Group       &group = step.stencils.groups[where[i].group];
        if (acts[i])
          {
            forces.add(forces_on[i], jacobian ? by_own[i] : ByMotion{});
            forces.finish(group, where[i].point);
          }
        if (n + 1 == in_order.size() ||
            where[in_order[n + 1]].group != where[i].group)
          forces.finish(group);
      }
    if (jacobian)
      add_across(step, u, across, *jacobian);
    forces.finish(force); // collective
    return "";
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
      for (unsigned int a = 0; a < group.n_nodes; ++a)
        {
          result.push_back(stencils.value(group, a)[q]);
          for (unsigned int d = 0; d < dim; ++d)
            result.push_back(stencils.gradient(group, a, d)[q]);
        }
      return result;
    }

    /** Subtract W_row E W_column, E by motion. */
    template <int dim>
    void
    subtract_products(const std::vector<double>                          &rows,
                      const std::array<PointMotion<dim>, dim *(dim + 1)> &E,
                      const std::vector<double>  &columns,
                      const unsigned int          first_row,
                      const unsigned int          first_column,
                      dealii::FullMatrix<double> &matrix)
    {
      constexpr unsigned int n = dim + 1;
      for (unsigned int a = 0; a < rows.size() / n; ++a)
        for (unsigned int i = 0; i < dim; ++i)
          {
            PointMotion<dim> row{};
            for (unsigned int l = 0; l < n; ++l)
              for (unsigned int c = 0; c < dim * n; ++c)
                row[c] += rows[n * a + l] * E[n * i + l][c];
            for (unsigned int b = 0; b < columns.size() / n; ++b)
              for (unsigned int j = 0; j < dim; ++j)
                for (unsigned int m = 0; m < n; ++m)
                  matrix(dim * (first_row + a) + i,
                         dim * (first_column + b) + j) -=
                    row[n * j + m] * columns[n * b + m];
          }
    }

    template <int dim>
    std::array<PointMotion<dim>, dim *(dim + 1)>
    times(const std::array<PointMotion<dim>, dim *(dim + 1)> &A,
          const std::array<PointMotion<dim>, dim *(dim + 1)> &B)
    {
      std::array<PointMotion<dim>, dim *(dim + 1)> result{};
      for (unsigned int i = 0; i < A.size(); ++i)
        for (unsigned int k = 0; k < A.size(); ++k)
          for (unsigned int j = 0; j < A.size(); ++j)
            result[i][j] += A[i][k] * B[k][j];
      return result;
    }
  } // namespace

  template <int dim>
  void
  BodyContact<dim>::add_across(const StepData<dim>       &step,
                               const std::vector<double> &u,
                               const std::vector<Across> &across,
                               Matrix                    &jacobian) const
  {
    const ActiveGrid<dim>     &active = *step.start.active;
    std::vector<double>        share(step.moving ? u.size() : 0);
    dealii::FullMatrix<double> matrix;
    for (const Clique &clique : cliques)
      {
        const unsigned int *nodes = active.coupled_nodes(clique.coupled);
        const unsigned int  n_first =
          step.stencils.groups[clique.first_nodes].n_nodes;
        const unsigned int n =
          n_first + step.stencils.groups[clique.second_nodes].n_nodes;
        bool is_empty = true;
        for (const unsigned int k : clique.pairs)
          {
            if (!across[k].acts)
              continue;
            if (is_empty)
              matrix.reinit(dim * n, dim * n);
            is_empty = false;
            // [0]: rows of the first particle, columns of the second
            const std::array<unsigned int, 2> sides{
              {candidates.pairs[k].first, candidates.pairs[k].second}};
            const std::array<const ByMotion *, 2> E{
              {&across[k].first_by_second, &across[k].second_by_first}};
            for (unsigned int side = 0; side < 2; ++side)
              {
                const Where &row    = where[sides[side]],
                            &column = where[sides[1 - side]];
                const auto &groups  = step.stencils.groups;
                const auto  rows =
                  weights_of(step.stencils, groups[row.group], row.point);
                const auto columns =
                  weights_of(step.stencils, groups[column.group], column.point);
                const auto followed =
                  followed_motion(step, groups[column.group], column.point, u);
                subtract_products<dim>(rows,
                                       step.moving
                                         ? times<dim>(*E[side],
                                                      followed.by_nodes)
                                         : *E[side],
                                       columns,
                                       side == 0 ? 0 : n_first,
                                       side == 0 ? n_first : 0,
                                       matrix);
                if (!step.moving)
                  continue;
                const unsigned int *of_row = nodes + (side == 0 ? 0 : n_first);
                for (unsigned int a = 0; a < rows.size() / (dim + 1); ++a)
                  for (unsigned int i = 0; i < dim; ++i)
                    for (unsigned int l = 0; l <= dim; ++l)
                      for (unsigned int c = 0; c < n_motion; ++c)
                        share[unknown<dim>(of_row[a], i)] -=
                          rows[(dim + 1) * a + l] *
                          (*E[side])[(dim + 1) * i + l][c] * followed.shift[c];
              }
          }
        if (!is_empty)
          active.graph().add(nodes, matrix, jacobian);
      }
    if (step.moving)
      step.moving->add_to_share(share);
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
  BodyContact<dim>::energies(const StepData<dim> &step,
                             const Vector        &displacement,
                             const PointArrays<dim> &) const
  {
    std::vector<EnergyEntry> entries = energy_entries();
    found.n_touching                 = 0.;
    found.springs.clear();
    for (Tensor<1, dim> &force : found.force)
      force = Tensor<1, dim>();
    const auto now = states(step,
                            step.start.active->to_local(displacement),
                            [](const Group &, const CornerMotion<dim> &) {});
    for_each_action(
      now,
      false,
      [&](const unsigned int     k,
          const PairKey         &key,
          const PairAction<dim> &action) {
        const auto &pair = candidates.pairs[k];
        entries[0].change += action.stored;
        found
          .force[rules.bodies[candidates.particles[pair.first].body].group] +=
          action.force;
        found
          .force[rules.bodies[candidates.particles[pair.second].body].group] -=
          action.force;
        found.n_touching += action.acts;
        if (!has_friction())
          return;
        entries[1].change += action.spring_stored;
        entries[2].change += action.slip;
        if (action.spring.norm_square() > 0.)
          found.springs[key] = action.spring;
      });
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
