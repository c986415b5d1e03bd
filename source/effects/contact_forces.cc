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

  // Forces, derivatives and energies of BodyContact.

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
  void
  BodyContact<dim>::follow_deformation(const StepData<dim> &step,
                                       const Iterate<dim>  &iterate) const
  {
    const unsigned int first = fields.deformation_gradient;
    for (const Group &group : step.stencils.groups)
      for (unsigned int q = 0; q < group.n_points; ++q)
        {
          const std::size_t p = group.first_point + q;
          CornerMotion<dim> motion;
          motion.gradient =
            step.stencils.displacement_gradient(group,
                                                q,
                                                step.start.active->nodes(group),
                                                iterate.local_displacement);
          motion.F_old = tensor_field(step.points, first, p);
          motion.find_arms(step.stencils.at_middle);
          const Tensor<2, dim> F = motion.F_new();
          for (unsigned int i = 0; i < dim * dim; ++i)
            iterate.trial.component(first + i)[p] = F[i / dim][i % dim];
        }
  }

  template <int dim>
  std::vector<typename BodyContact<dim>::State>
  BodyContact<dim>::states(const StepData<dim>       &step,
                           const std::vector<double> &u) const
  {
    std::vector<State>               result(candidates.particles.size());
    std::vector<std::vector<double>> numbers(result.size());
    for (const unsigned int i : in_order)
      {
        CornerMotion<dim> &motion = result[i].motion;
        motion                    = particle(step,
                          step.stencils.groups[where[i].group],
                          where[i].point,
                          u);
        if (!exchange.is_needed())
          continue;
        numbers[i].assign(motion.way.begin_raw(), motion.way.end_raw());
        for (unsigned int d = 0; d < dim; ++d)
          numbers[i].insert(numbers[i].end(),
                            motion.gradient[d].begin_raw(),
                            motion.gradient[d].end_raw());
      }
    exchange(numbers);
    for (unsigned int i = 0; i < result.size(); ++i)
      {
        const ContactParticle<dim> &particle = candidates.particles[i];
        CornerMotion<dim>          &motion   = result[i].motion;
        if (!is_mine(i))
          {
            motion.place = particle.place;
            motion.F_old = particle.F;
            for (unsigned int d = 0; d < dim; ++d)
              {
                motion.way[d] = numbers[i][d];
                for (unsigned int e = 0; e < dim; ++e)
                  motion.gradient[d][e] = numbers[i][dim + dim * d + e];
              }
            motion.find_arms(step.stencils.at_middle);
          }
        result[i].places.reserve(rules.n_points());
        result[i].ways.reserve(rules.n_points());
        for (unsigned int k = 0; k < rules.n_points(); ++k)
          {
            const Tensor<1, dim> &xi = points_of_body[particle.body][k];
            result[i].places.push_back(motion.place + motion.F_old * xi);
            result[i].ways.push_back(motion.way_of(motion.F * xi));
          }
      }
    return result;
  }

  template <int dim>
  void
  BodyContact<dim>::exchange_followed(
    const std::vector<char>          &acts,
    std::vector<FollowedMotion<dim>> &result) const
  {
    if (!exchange.is_needed())
      return;
    std::vector<std::vector<double>> numbers(acts.size());
    for (const unsigned int i : in_order)
      if (acts[i])
        {
          numbers[i].assign(result[i].shift.begin(), result[i].shift.end());
          for (const PointMotion<dim> &row : result[i].by_nodes)
            numbers[i].insert(numbers[i].end(), row.begin(), row.end());
        }
    exchange(numbers);
    for (unsigned int i = 0; i < acts.size(); ++i)
      if (!is_mine(i) && acts[i])
        {
          auto number = numbers[i].begin();
          std::copy_n(number, n_motion, result[i].shift.begin());
          for (PointMotion<dim> &row : result[i].by_nodes)
            std::copy_n(number += n_motion, n_motion, row.begin());
        }
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
        const PairLaw &law       = laws[k];
        const double   reach     = law.reach * law.reach;
        // springs are held where points touched, but for round-off
        const double held   = (1. + 1e-6) * reach;
        const State &of_one = states[pair.first], &of_two = states[pair.second];
        for (const auto &[i, j] : pair.points)
          {
            const Tensor<1, dim> before = of_one.places[i] - of_two.places[j];
            const Tensor<1, dim> after =
              before + of_one.ways[i] - of_two.ways[j];
            if (before.norm_square() >= held && after.norm_square() >= reach)
              continue;
            const PairKey  key{{one.id, two.id, i, j}};
            Tensor<1, dim> spring;
            if (!springs_held.empty())
              if (const auto found = springs_held.find(key);
                  found != springs_held.end())
                spring = found->second;
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
  BodyContact<dim>::add(const StepData<dim> &step,
                        const Iterate<dim>  &iterate,
                        Vector              &force,
                        Matrix              *jacobian) const
  {
    const std::vector<double> &u = iterate.local_displacement;
    follow_deformation(step, iterate);
    const auto                    now = states(step, u);
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
                      is_coupled[k]              = true;
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

    std::vector<FollowedMotion<dim>> followed(
      jacobian && step.moving ? now.size() : 0);
    CornerForces<dim> forces(step, u, jacobian);
    for (unsigned int n = 0; n < in_order.size(); ++n)
      {
        const unsigned int i     = in_order[n];
        const Group       &group = step.stencils.groups[where[i].group];
        if (acts[i])
          {
            forces.add(forces_on[i], jacobian ? by_own[i] : ByMotion{});
            forces.finish(group,
                          where[i].point,
                          followed.empty() ? nullptr : &followed[i]);
          }
        if (n + 1 == in_order.size() ||
            where[in_order[n + 1]].group != where[i].group)
          forces.finish(group);
      }
    if (jacobian && step.moving)
      exchange_followed(acts, followed);
    if (jacobian)
      add_across(step, followed, across, *jacobian);
    forces.finish(force); // collective
    return "";
  }

  namespace
  {
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

    /** Subtract W E c at some nodes. */
    template <int dim>
    void
    subtract_share(const std::vector<double>                          &weights,
                   const std::array<PointMotion<dim>, dim *(dim + 1)> &E,
                   const PointMotion<dim>                             &c,
                   const unsigned int                                 *nodes,
                   std::vector<double>                                &share)
    {
      constexpr unsigned int n = dim + 1;
      for (unsigned int i = 0; i < dim; ++i)
        for (unsigned int l = 0; l < n; ++l)
          {
            double sum = 0.;
            for (unsigned int m = 0; m < dim * n; ++m)
              sum += E[n * i + l][m] * c[m];
            for (unsigned int a = 0; a < weights.size() / n; ++a)
              share[unknown<dim>(nodes[a], i)] -= weights[n * a + l] * sum;
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
  BodyContact<dim>::add_across(const StepData<dim>                    &step,
                               const std::vector<FollowedMotion<dim>> &followed,
                               const std::vector<Across>              &across,
                               Matrix &jacobian) const
  {
    const ActiveGrid<dim> &active = *step.start.active;
    std::vector<double> share(step.moving ? dim * active.n_local_nodes() : 0);
    dealii::FullMatrix<double> matrix;
    for (const Clique &clique : cliques)
      {
        const unsigned int *nodes    = active.coupled_nodes(clique.coupled);
        const ParticlePair &any      = candidates.pairs[clique.pairs.front()];
        const unsigned int  n_first  = where[any.first].n_nodes();
        bool                is_empty = true;
        for (const unsigned int k : clique.pairs)
          {
            if (!across[k].acts)
              continue;
            if (is_empty)
              matrix.reinit(dim * (n_first + where[any.second].n_nodes()),
                            dim * (n_first + where[any.second].n_nodes()));
            is_empty                 = false;
            const ParticlePair &pair = candidates.pairs[k];
            for (const bool of_first : {true, false})
              {
                // rows of one particle, columns of the other
                const unsigned int i = of_first ? pair.first : pair.second,
                                   j = of_first ? pair.second : pair.first;
                if (!is_mine(i))
                  continue;
                const ByMotion &E = of_first ? across[k].first_by_second
                                             : across[k].second_by_first;
                subtract_products<dim>(where[i].weights,
                                       step.moving
                                         ? times<dim>(E, followed[j].by_nodes)
                                         : E,
                                       where[j].weights,
                                       of_first ? 0 : n_first,
                                       of_first ? n_first : 0,
                                       matrix);
                if (step.moving)
                  subtract_share<dim>(where[i].weights,
                                      E,
                                      followed[j].shift,
                                      nodes + (of_first ? 0 : n_first),
                                      share);
              }
          }
        if (!is_empty)
          active.graph().add(nodes, matrix, jacobian);
      }
    if (step.moving)
      step.moving->add_to_share(share);
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
    const auto now = states(step, step.start.active->to_local(displacement));
    for_each_action(
      now,
      false,
      [&](const unsigned int     k,
          const PairKey         &key,
          const PairAction<dim> &action) {
        const auto &pair = candidates.pairs[k];
        if (!is_mine(pair.first))
          return; // the other rank has it
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

  template std::string
  BodyContact<2>::missing(const StepData<2> &, const Vector &);
  template std::string
  BodyContact<2>::add(const StepData<2> &,
                      const Iterate<2> &,
                      Vector &,
                      Matrix *) const;
  template std::vector<EnergyEntry>
  BodyContact<2>::energies(const StepData<2> &,
                           const Vector &,
                           const PointArrays<2> &) const;
  template std::string
  BodyContact<3>::missing(const StepData<3> &, const Vector &);
  template std::string
  BodyContact<3>::add(const StepData<3> &,
                      const Iterate<3> &,
                      Vector &,
                      Matrix *) const;
  template std::vector<EnergyEntry>
  BodyContact<3>::energies(const StepData<3> &,
                           const Vector &,
                           const PointArrays<3> &) const;
} // namespace emmy
