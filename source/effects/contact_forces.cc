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
  CornerMotion<dim>
  BodyContact<dim>::motion_of(const unsigned int         candidate,
                              const StepData<dim>       &step,
                              const std::vector<double> &u) const
  {
    const Where        &it    = where[candidate];
    const Group        &group = step.stencils.groups[it.group];
    const unsigned int *nodes = step.start.active->nodes(group);
    const double       *W     = it.weights.data();
    CornerMotion<dim>   result{};
    for (unsigned int a = 0; a < group.n_nodes; ++a, W += dim + 1)
      for (unsigned int c = 0; c < dim; ++c)
        {
          const double u_a = u[unknown<dim>(nodes[a], c)];
          result.way[c] += W[0] * u_a;
          for (unsigned int d = 0; d < dim; ++d)
            result.gradient[c][d] += u_a * W[1 + d];
        }
    return result;
  }

  template <int dim>
  PairPoint<dim>
  BodyContact<dim>::point(const States      &states,
                          const unsigned int candidate,
                          const unsigned int index) const
  {
    const CornerMotion<dim> &motion = states.motions[candidate];
    PairPoint<dim>           result;
    result.particle = motion.place;
    result.way      = motion.way;
    result.gradient = motion.gradient;
    result.arm_old =
      places[candidate * rules.n_points() + index] - motion.place;
    result.at_middle = motion.Z.norm_square() > 0.;
    result.Z         = motion.Z;
    result.arm = result.at_middle ? motion.Z * result.arm_old : result.arm_old;
    return result;
  }

  template <int dim>
  void
  BodyContact<dim>::follow(const Stencils<dim>       &stencils,
                           const PointArrays<dim>    &points,
                           const ActiveGrid<dim>     &active,
                           const std::vector<double> &displacement,
                           PointArrays<dim>          &trial) const
  {
    const unsigned int first = fields.deformation_gradient;
    for (const Group &group : stencils.groups)
      for (unsigned int q = 0; q < group.n_points; ++q)
        {
          const std::size_t p = group.first_point + q;
          CornerMotion<dim> motion;
          motion.gradient = stencils.displacement_gradient(group,
                                                           q,
                                                           active.nodes(group),
                                                           displacement);
          motion.F_old    = tensor_field(points, first, p);
          motion.find_arms(stencils.at_middle);
          const Tensor<2, dim> F = motion.F_new();
          for (unsigned int i = 0; i < dim * dim; ++i)
            trial.component(first + i)[p] = F[i / dim][i % dim];
        }
  }

  template <int dim>
  typename BodyContact<dim>::States
  BodyContact<dim>::states(const StepData<dim>       &step,
                           const std::vector<double> &u) const
  {
    const std::size_t n = candidates.particles.size();
    States            result;
    result.motions.resize(n);
    for (const unsigned int i : in_order)
      result.motions[i] = motion_of(i, step, u);
    if (exchange.is_needed())
      {
        std::vector<std::vector<double>> numbers(n);
        for (const unsigned int i : in_order)
          {
            const CornerMotion<dim> &motion = result.motions[i];
            numbers[i].assign(motion.way.begin_raw(), motion.way.end_raw());
            for (unsigned int d = 0; d < dim; ++d)
              numbers[i].insert(numbers[i].end(),
                                motion.gradient[d].begin_raw(),
                                motion.gradient[d].end_raw());
          }
        exchange(numbers);
        for (unsigned int i = 0; i < n; ++i)
          for (unsigned int d = 0; d < dim && !is_mine(i); ++d)
            {
              result.motions[i].way[d] = numbers[i][d];
              for (unsigned int e = 0; e < dim; ++e)
                result.motions[i].gradient[d][e] =
                  numbers[i][dim + dim * d + e];
            }
      }
    result.ways.reserve(places.size());
    for (unsigned int i = 0; i < n; ++i)
      {
        const ContactParticle<dim> &particle = candidates.particles[i];
        CornerMotion<dim>          &motion   = result.motions[i];
        motion.place                         = particle.place;
        motion.F_old                         = particle.F;
        motion.find_arms(step.stencils.at_middle);
        for (const Tensor<1, dim> &xi : points_of_body[particle.body])
          result.ways.push_back(motion.way_of(motion.F * xi));
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
  BodyContact<dim>::for_each_action(const States       &states,
                                    PairMatrices *const derivatives,
                                    const Visit        &visit) const
  {
    const unsigned int n = rules.n_points();
    for (unsigned int k = 0; k < candidates.pairs.size(); ++k)
      {
        const auto &[first, second, points] = candidates.pairs[k];
        const PairLaw &law                  = laws[k];
        const double   reach                = law.reach * law.reach;
        // springs are held where points touched, but for round-off
        const double held = (1. + 1e-6) * reach;
        for (const auto &[i, j] : points)
          {
            const Tensor<1, dim> before =
              places[n * first + i] - places[n * second + j];
            const Tensor<1, dim> after =
              before + states.ways[n * first + i] - states.ways[n * second + j];
            const double square = before.norm_square();
            const bool   is_apart =
              square >= reach && after.norm_square() >= reach;
            if (is_apart && (square >= held || springs_held.empty()))
              continue;
            const PairKey  key{{candidates.particles[first].id,
                                candidates.particles[second].id,
                                i,
                                j}};
            Tensor<1, dim> spring;
            if (!springs_held.empty())
              if (const auto found = springs_held.find(key);
                  found != springs_held.end())
                spring = found->second;
            if (is_apart && spring.norm_square() == 0.)
              continue;
            PairDerivative<dim> *derivative = nullptr;
            if (derivatives)
              {
                unsigned int &number = derivatives->of_pair[k];
                if (number == none)
                  {
                    number = derivatives->matrices.size();
                    derivatives->matrices.emplace_back();
                  }
                derivative = &derivatives->matrices[number];
              }
            visit(k,
                  key,
                  pair_action(law,
                              point(states, first, i),
                              point(states, second, j),
                              spring,
                              derivative));
          }
      }
  }

  namespace
  {
    /** sum += matrix. */
    template <class Block>
    void
    add_block(const Block &matrix, Block &sum)
    {
      for (unsigned int i = 0; i < sum.size(); ++i)
        for (unsigned int j = 0; j < sum.size(); ++j)
          sum[i][j] += matrix[i][j];
    }
  } // namespace

  template <int dim>
  std::string
  BodyContact<dim>::add(const StepData<dim> &step,
                        const Iterate<dim>  &iterate,
                        Vector              &force,
                        Matrix              *jacobian) const
  {
    const std::vector<double>    &u            = iterate.local_displacement;
    const States                  now          = states(step, u);
    const std::size_t             n_candidates = now.motions.size();
    std::vector<char>             acts(n_candidates, false);
    std::vector<PointMotion<dim>> forces_on(n_candidates);
    PairMatrices                  derivatives;
    if (jacobian)
      derivatives.of_pair.assign(candidates.pairs.size(), none);
    for_each_action(now,
                    jacobian ? &derivatives : nullptr,
                    [&](const unsigned int k,
                        const PairKey &,
                        const PairAction<dim> &action) {
                      if (!action.acts)
                        return;
                      const ParticlePair &pair = candidates.pairs[k];
                      acts[pair.first] = acts[pair.second] = true;
                      is_coupled[k]                        = true;
                      for (unsigned int i = 0; i < n_motion; ++i)
                        {
                          forces_on[pair.first][i] += action.value[i];
                          forces_on[pair.second][i] +=
                            action.value[n_motion + i];
                        }
                    });
    std::vector<ByMotion> by_own(jacobian ? n_candidates : 0);
    for (unsigned int k = 0; k < derivatives.of_pair.size(); ++k)
      if (const unsigned int number = derivatives.of_pair[k]; number != none)
        {
          const auto &of = derivatives.matrices[number].of;
          add_block(of[0][0], by_own[candidates.pairs[k].first]);
          add_block(of[1][1], by_own[candidates.pairs[k].second]);
        }

    std::vector<FollowedMotion<dim>> followed(
      jacobian && step.moving ? n_candidates : 0);
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
      add_across(step, followed, derivatives, *jacobian);
    forces.finish(force); // collective
    return "";
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
    const States now = states(step, step.start.active->to_local(displacement));
    for_each_action(
      now,
      nullptr,
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

  template void
  BodyContact<2>::follow(const Stencils<2> &,
                         const PointArrays<2> &,
                         const ActiveGrid<2> &,
                         const std::vector<double> &,
                         PointArrays<2> &) const;
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
  template void
  BodyContact<3>::follow(const Stencils<3> &,
                         const PointArrays<3> &,
                         const ActiveGrid<3> &,
                         const std::vector<double> &,
                         PointArrays<3> &) const;
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
