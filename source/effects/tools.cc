#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/effects/moving_places.h>
#include <emmy/effects/tools.h>

#include <algorithm>

namespace emmy
{
  using dealii::Tensor;

  namespace
  {
    /** A corner that goes through a tool deeper than this has jumped over it.
     */
    constexpr double missed = 0.05;

    /** d x f in space. */
    template <int dim>
    Tensor<1, 3>
    moment_of(const Tensor<1, dim> &d, const Tensor<1, dim> &f)
    {
      Tensor<1, 3> arm, force;
      for (unsigned int c = 0; c < dim; ++c)
        {
          arm[c]   = d[c];
          force[c] = f[c];
        }
      return cross_product_3d(arm, force);
    }
  } // namespace

  template <int dim>
  Tools<dim>::Tools(std::vector<Tool<dim>>            given,
                    const Fields                     &fields,
                    std::vector<ParticleCorners<dim>> corners_of_body)
    : tools(std::move(given))
    , fields(fields)
    , corners_of_body(std::move(corners_of_body))
  {
    for (const Tool<dim> &tool : tools)
      has_friction = has_friction || tool.friction > 0.;
    found.force.resize(tools.size());
    found.moment.resize(tools.size());
    found.sunk_in.resize(tools.size());
    found.way.resize(tools.size());
    found.speed.resize(tools.size());
    pushed.resize(tools.size());
    for (unsigned int t = 0; t < tools.size(); ++t)
      if (tools[t].push)
        pushed[t].speed = found.speed[t] = tools[t].push->initial_speed;
  }

  template <int dim>
  ContactLaw
  Tools<dim>::law(const Tool<dim>            &tool,
                  const ParticleCorners<dim> &corners) const
  {
    const double k = tool.stiffness * corners.stiffness;
    return {k, tool.friction, tool.spring_stiffness * k};
  }

  template <int dim>
  bool
  Tools<dim>::is_held(const Tool<dim>   &tool,
                      const double       bits,
                      const unsigned int corner) const
  {
    return tool.held != Tool<dim>::none &&
           (static_cast<unsigned int>(bits) >> corner & 1);
  }

  template <int dim>
  dealii::Point<dim>
  Tools<dim>::place_of(const unsigned int tool, const double time) const
  {
    const Tool<dim> &it = tools[tool];
    return it.push
             ? it.motion.place(time) + pushed[tool].travel * it.push->direction
             : it.motion.place(time);
  }

  template <int dim>
  typename Tools<dim>::Moves
  Tools<dim>::motions(const StepData<dim>       &step,
                      const std::vector<double> &u) const
  {
    Moves result;
    result.pushed.resize(tools.size());
    for (unsigned int t = 0; t < tools.size(); ++t)
      {
        result.tools.push_back(tools[t].motion.over(step.time, step.time_step));
        if (!tools[t].push)
          continue;
        result.tools[t].place = place_of(t, step.time);
        result.pushed[t]      = push(t, step, u, result.tools[t]);
        if (!result.pushed[t].problem.empty())
          result.problem = result.pushed[t].problem;
      }
    return result;
  }

  template <int dim>
  PushMotion
  Tools<dim>::push(const unsigned int         t,
                   const StepData<dim>       &step,
                   const std::vector<double> &u,
                   ToolStep<dim>             &motion) const
  {
    const ToolPush<dim>  &push   = *tools[t].push;
    const Tensor<1, dim> &e      = push.direction;
    const ToolStep<dim>   across = motion;
    const double          told   = across.displacement * e;
    AssertThrow(std::abs(told) <= 1e-12 * across.displacement.norm(),
                ExcRun(push.section,
                       "<Displacement> moves the tool by " + brief(told) +
                         " m along the direction in which it is pushed, in "
                         "the step from t = " +
                         brief(step.time) + " s",
                       "let <Displacement> be across that direction, or "
                       "remove <Pushed along>."));
    const MPI_Comm ranks = step.start.active->communicator();
    for (double reach = step.time_step * std::abs(pushed[t].speed);;)
      {
        // what the tool may touch if it goes no farther than that
        motion.displacement = across.displacement + reach * e;
        std::vector<CornerMotion<dim>> near;
        for (const Group &group : step.stencils.groups)
          for (unsigned int q = 0; q < group.n_points; ++q)
            {
              auto particle = this->particle(step, group, q, u);
              if (!is_far(motion, tools[t], particle))
                near.push_back(std::move(particle));
            }
        const auto resistance = [&](const double way) {
          motion.displacement = across.displacement + way * e;
          std::vector<double> sums(3);
          for (const CornerMotion<dim> &particle : near)
            for_each_touch_of(
              t, motion, step, particle, [&](const Touch &touch) {
                sums[0] += e * touch.force;
                sums[1] -= e * touch.derivative * e;
                sums[2] += std::abs(e * touch.force);
              });
          dealii::Utilities::MPI::sum(sums, ranks, sums);
          return PushResistance{sums[0], sums[1], sums[2]};
        };
        const PushMotion result =
          pushed_motion(push, pushed[t], step.time, step.time_step, resistance);
        motion.displacement = across.displacement + result.way * e;
        if (std::abs(result.way) <= reach)
          return result;
        reach = 2. * std::abs(result.way);
      }
  }

  template <int dim>
  CornerMotion<dim>
  Tools<dim>::particle(const StepData<dim>       &step,
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
  bool
  Tools<dim>::is_far(const ToolStep<dim>     &motion,
                     const Tool<dim>         &tool,
                     const CornerMotion<dim> &particle) const
  {
    if (tool.held != Tool<dim>::none)
      return false;
    // distances change by no more than what moves
    double arm = 0., arm_old = 0.;
    for (unsigned int d = 0; d < dim; ++d)
      {
        Tensor<1, dim> xi;
        xi[d] = particle.corners->half_length[d];
        arm += (particle.F * xi).norm();
        arm_old += (particle.F_old * xi).norm();
      }
    const Tensor<1, dim> from = particle.place - motion.place;
    const double moved = particle.way.norm() + particle.gradient.norm() * arm +
                         motion.displacement.norm();
    const double reach =
      arm_old + moved + 2. * motion.turn * (from.norm() + arm_old + moved);
    const Tensor<1, dim> in_frame = motion.to_frame * from;
    return tool.shape->least_distance(in_frame) > reach ||
           tool.shape->distance(in_frame).value > reach;
  }

  template <int dim>
  ContactPoint<dim>
  Tools<dim>::point_of(const Tool<dim>         &tool,
                       const unsigned int       corner,
                       const ToolStep<dim>     &motion,
                       const StepData<dim>     &step,
                       const CornerMotion<dim> &particle) const
  {
    const Tensor<1, dim> from = particle.place +
                                particle.F_old * (*particle.corners)[corner] -
                                motion.place;
    ContactPoint<dim> point;
    point.place = motion.to_frame * from;
    if (tool.held != Tool<dim>::none)
      point.is_held =
        is_held(tool, step.points.component(tool.held)[particle.p], corner);
    if (tool.springs != Tool<dim>::none)
      point.spring =
        step.points.template get<dim>(tool.springs + dim * corner, particle.p);
    return point;
  }

  template <int dim>
  template <class Visit>
  std::string
  Tools<dim>::for_each_touch_of(const unsigned int       t,
                                const ToolStep<dim>     &motion,
                                const StepData<dim>     &step,
                                const CornerMotion<dim> &particle,
                                const Visit             &visit) const
  {
    const Tool<dim> &tool = tools[t];
    std::string      problem;
    if (is_far(motion, tool, particle))
      return problem;
    const ParticleCorners<dim> &corners = *particle.corners;
    const ContactLaw            law     = this->law(tool, corners);
    Tensor<2, dim>              by_seen = -0.5 * motion.spin;
    for (unsigned int d = 0; d < dim; ++d)
      by_seen[d][d] += 1.;
    for (unsigned int i = 0; i < corners.n; ++i)
      {
        const auto           point = point_of(tool, i, motion, step, particle);
        const Tensor<1, dim> arm   = particle.F * corners[i];
        const Tensor<1, dim> seen  = particle.way_of(arm) - motion.displacement;
        const Tensor<1, dim> from  = particle.place +
                                    particle.F_old * corners[i] - motion.place +
                                    0.5 * seen;
        const Tensor<1, dim> way =
          (seen - motion.spin * from) * motion.to_space;
        const Contact<dim> here = contact(*tool.shape, law, point, way);
        if (!here.acts && here.gap_old + here.gap_new < way.norm() &&
            depth_on_way(
              *tool.shape, point.place, way, 0.1 * missed * corners.spacing) >
              missed * corners.spacing)
          problem =
            "particle " +
            std::to_string(step.stencils.particles[particle.p]->get_id()) +
            " goes through the tool <" + tool.name + "> within the step";
        if (!here.acts && here.slip == 0.)
          continue;
        visit(Touch{t,
                    i,
                    arm,
                    from,
                    motion.to_space * here.force,
                    motion.to_space * here.derivative *
                      transpose(motion.to_space) * by_seen,
                    here});
      }
    return problem;
  }

  template <int dim>
  template <class Visit>
  std::string
  Tools<dim>::for_each_touch(const StepData<dim>              &step,
                             const std::vector<ToolStep<dim>> &motions,
                             const CornerMotion<dim>          &particle,
                             const Visit                      &visit) const
  {
    std::string problem;
    for (unsigned int t = 0; t < tools.size(); ++t)
      {
        const std::string wrong =
          for_each_touch_of(t, motions[t], step, particle, visit);
        if (!wrong.empty())
          problem = wrong;
      }
    return problem;
  }

  template <int dim>
  void
  Tools<dim>::begin_trial(const CornerMotion<dim> &particle,
                          PointArrays<dim>        &trial) const
  {
    const Tensor<2, dim> F = particle.F_new();
    for (unsigned int i = 0; i < dim * dim; ++i)
      trial.component(fields.deformation_gradient + i)[particle.p] =
        F[i / dim][i % dim];
    for (const Tool<dim> &tool : tools)
      if (tool.springs != Tool<dim>::none)
        for (unsigned int i = 0; i < dim * particle.corners->n; ++i)
          trial.component(tool.springs + i)[particle.p] = 0.;
  }

  template <int dim>
  std::vector<std::unique_ptr<PushCoupling<dim>>>
  Tools<dim>::push_couplings(const StepData<dim>       &step,
                             const std::vector<double> &u) const
  {
    std::vector<std::unique_ptr<PushCoupling<dim>>> result(tools.size());
    for (unsigned int t = 0; t < tools.size(); ++t)
      if (tools[t].push)
        result[t] =
          std::make_unique<PushCoupling<dim>>(step,
                                              u,
                                              tools[t].push->direction);
    return result;
  }

  template <int dim>
  std::string
  Tools<dim>::add(const StepData<dim> &step,
                  const Iterate<dim>  &iterate,
                  Vector              &force,
                  Matrix              *jacobian) const
  {
    const std::vector<double> &u     = iterate.local_displacement;
    const Moves                moves = motions(step, u);
    CornerForces<dim>          forces(step, u, jacobian);
    std::string                problem;
    std::vector<std::unique_ptr<PushCoupling<dim>>> couplings(tools.size());
    if (jacobian)
      couplings = push_couplings(step, u);
    found.communicator = step.start.active->communicator();
    found.deepest      = 0.;
    const auto take    = [&](const CornerMotion<dim> &particle,
                          const Touch             &touch) {
      forces.add(particle, touch.arm, touch.force, touch.derivative);
      if (couplings[touch.tool])
        couplings[touch.tool]->add(particle, touch.arm, touch.derivative);
      found.deepest =
        std::max(found.deepest,
                 -touch.contact.gap_new / particle.corners->spacing);
      const unsigned int springs = tools[touch.tool].springs;
      if (springs != Tool<dim>::none)
        iterate.trial.set(springs + dim * touch.corner,
                          particle.p,
                          touch.contact.spring);
    };
    for (const Group &group : step.stencils.groups)
      {
        for (unsigned int q = 0; q < group.n_points; ++q)
          {
            const auto particle = this->particle(step, group, q, u);
            begin_trial(particle, iterate.trial);
            const std::string wrong = for_each_touch(step,
                                                     moves.tools,
                                                     particle,
                                                     [&](const Touch &touch) {
                                                       take(particle, touch);
                                                     });
            if (!wrong.empty())
              problem = wrong;
            forces.finish(group, q);
            for (const auto &coupling : couplings)
              if (coupling)
                coupling->finish(group, q);
          }
        forces.finish(group);
      }
    // collective: also after a problem
    forces.finish(force);
    if (jacobian)
      found.rank_ones.clear();
    for (unsigned int t = 0; t < tools.size(); ++t)
      if (couplings[t])
        couplings[t]->finish(moves.pushed[t].stiffness, found.rank_ones);
    return moves.problem.empty() ? problem : moves.problem;
  }

  template <int dim>
  std::vector<EnergyEntry>
  Tools<dim>::energies(const StepData<dim> &step,
                       const Vector        &displacement,
                       const PointArrays<dim> &) const
  {
    std::vector<EnergyEntry>  entries = energy_entries();
    const std::vector<double> u     = step.start.active->to_local(displacement);
    const Moves               moves = motions(step, u);
    const double              share = // of what is the same on all ranks
      1. / dealii::Utilities::MPI::n_mpi_processes(
             step.start.active->communicator());
    for (unsigned int t = 0; t < tools.size(); ++t)
      {
        found.force[t]   = Tensor<1, dim>();
        found.moment[t]  = Tensor<1, 3>();
        found.sunk_in[t] = 0.;
        found.way[t]     = moves.pushed[t].way;
        if (!tools[t].push)
          continue;
        const ToolPush<dim> &push   = *tools[t].push;
        const double         way    = found.way[t];
        const double         speed  = pushed[t].speed;
        const double         change = 2. * (way / step.time_step - speed);
        found.speed[t]              = speed + change;
        entries[work_of(t)].change +=
          share * push.force(step.time + 0.5 * step.time_step) * way;
        entries[kinetic_energy_of(t)].change +=
          share * push.mass * change * way / step.time_step;
      }
    for (const Group &group : step.stencils.groups)
      for (unsigned int q = 0; q < group.n_points; ++q)
        {
          const auto particle = this->particle(step, group, q, u);
          for_each_touch(step, moves.tools, particle, [&](const Touch &touch) {
            const unsigned int   t      = touch.tool;
            const ToolStep<dim> &motion = moves.tools[t];
            Tensor<1, dim>       told   = motion.displacement;
            if (tools[t].push)
              told -= found.way[t] * tools[t].push->direction;
            entries[0].change += touch.contact.stored;
            if (has_friction)
              {
                entries[1].change += touch.contact.spring_stored;
                entries[2].change += touch.contact.slip;
              }
            entries[work_of(t)].change +=
              touch.force * (told + motion.spin * touch.from);
            found.force[t] -= touch.force;
            found.moment[t] -= moment_of(touch.from, touch.force);
            found.sunk_in[t] =
              std::max(found.sunk_in[t],
                       -touch.contact.gap_new / particle.corners->spacing);
          });
        }
    return entries;
  }

  template class Tools<2>;
  template class Tools<3>;
} // namespace emmy
