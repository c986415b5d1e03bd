#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/effects/moving_places.h>
#include <emmy/effects/tool_surface.h>
#include <emmy/effects/tools.h>

#include <algorithm>

namespace emmy
{
  using dealii::Tensor;

  namespace
  {
    /** Deeper than this share of the spacing is worth a line. */
    constexpr double deep = 0.05;
    /** A corner that goes through a tool deeper than this has jumped over it.
     */
    constexpr double missed = 0.05;
    /** Nearer than this share of the spacing touches at the start. */
    constexpr double touching = 1e-6;

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
  std::vector<ToolStep<dim>>
  Tools<dim>::motions(const StepData<dim> &step) const
  {
    std::vector<ToolStep<dim>> result;
    for (const Tool<dim> &tool : tools)
      result.push_back(tool.motion.over(step.time, step.time_step));
    return result;
  }

  template <int dim>
  std::string
  Tools<dim>::mark(const BackgroundGrid<dim>               &grid,
                   dealii::Particles::ParticleHandler<dim> &particles) const
  {
    std::string text;
    for (const Tool<dim> &tool : tools)
      text += (text.empty() ? "" : "\n" + std::string(24, ' ')) +
              mark(tool, grid, particles);
    return text;
  }

  template <int dim>
  std::string
  Tools<dim>::mark(const Tool<dim>                         &tool,
                   const BackgroundGrid<dim>               &grid,
                   dealii::Particles::ParticleHandler<dim> &particles) const
  {
    using namespace dealii::Utilities::MPI;
    const bool    holds    = tool.held != Tool<dim>::none;
    const auto    place    = tool.motion.place(0.);
    const auto    to_frame = transpose(tool.motion.directions(0.));
    std::uint64_t n_near   = 0;
    double        stored = 0., deepest = 0.;
    for (auto &particle : particles)
      {
        const auto                  properties = particle.get_properties();
        const ParticleCorners<dim> &corners =
          corners_of_body[properties[fields.body]];
        unsigned int held = 0;
        for (unsigned int i = 0; i < corners.n; ++i)
          {
            const Tensor<1, dim> from =
              particle.get_location() + corners[i] - place;
            const double gap = tool.shape->distance(to_frame * from).value;
            if (gap <= touching * corners.spacing)
              {
                ++n_near;
                held |= 1u << i;
              }
            deepest = std::max(deepest, -gap / corners.spacing);
            stored += contact_energy(law(tool, corners).stiffness,
                                     gap,
                                     holds && (held >> i & 1));
          }
        if (holds)
          properties[tool.held] = held;
      }
    n_near  = sum(n_near, grid.communicator());
    stored  = sum(stored, grid.communicator());
    deepest = max(deepest, grid.communicator());
    AssertThrow(!holds || n_near > 0,
                ExcRun("Effects/Tools/" + tool.name,
                       "nothing touches the tool at the start, so it can "
                       "hold nothing",
                       "put its <Reference point> on the surface of the "
                       "body, or set Holds = false."));
    return "tool <" + tool.name + ">: " +
           (holds ? "holds " + std::to_string(n_near) + " corners, " : "") +
           (deepest > touching
              ? "overlaps bodies by up to " + brief(deepest) +
                  " of their spacing, which stores " + brief(stored) + " J, "
              : "") +
           "stiffness " + brief(tool.stiffness) +
           " M/s: a pressure of 1 % of the P-wave modulus M sinks in by " +
           brief(0.01 / tool.stiffness) + " of the spacing s";
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
    return tool.shape->distance(motion.to_frame * from).value > reach;
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
        const Tool<dim>     &tool   = tools[t];
        const ToolStep<dim> &motion = motions[t];
        if (is_far(motion, tool, particle))
          continue;
        const ParticleCorners<dim> &corners = *particle.corners;
        const ContactLaw            law     = this->law(tool, corners);
        const double                held    = tool.held == Tool<dim>::none
                                                ? 0.
                                                : step.points.component(tool.held)[particle.p];
        for (unsigned int i = 0; i < corners.n; ++i)
          {
            const Tensor<1, dim> arm = particle.F * corners[i];
            const Tensor<1, dim> from_old =
              particle.place + particle.F_old * corners[i] - motion.place;
            const Tensor<1, dim> seen =
              particle.way_of(arm) - motion.displacement;
            const Tensor<1, dim> from = from_old + 0.5 * seen;
            const Tensor<1, dim> way =
              (seen - motion.spin * from) * motion.to_space;
            ContactPoint<dim> point;
            point.place   = motion.to_frame * from_old;
            point.is_held = is_held(tool, held, i);
            if (tool.springs != Tool<dim>::none)
              point.spring =
                step.points.template get<dim>(tool.springs + dim * i,
                                              particle.p);
            const Contact<dim> here = contact(*tool.shape, law, point, way);
            if (!here.acts && here.gap_old + here.gap_new < way.norm() &&
                depth_on_way(*tool.shape,
                             point.place,
                             way,
                             0.1 * missed * corners.spacing) >
                  missed * corners.spacing)
              problem =
                "particle " +
                std::to_string(step.stencils.particles[particle.p]->get_id()) +
                " goes through the tool <" + tool.name + "> within the step";
            if (!here.acts && here.slip == 0.)
              continue;
            Tensor<2, dim> by_seen = -0.5 * motion.spin;
            for (unsigned int d = 0; d < dim; ++d)
              by_seen[d][d] += 1.;
            visit(Touch{t,
                        i,
                        arm,
                        from,
                        motion.to_space * here.force,
                        motion.to_space * here.derivative *
                          transpose(motion.to_space) * by_seen,
                        here});
          }
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
  std::string
  Tools<dim>::add(const StepData<dim> &step,
                  const Iterate<dim>  &iterate,
                  Vector              &force,
                  Matrix              *jacobian) const
  {
    const auto                 motions = this->motions(step);
    const std::vector<double> &u       = iterate.local_displacement;
    CornerForces<dim>          forces(step, u, jacobian);
    std::string                problem;
    found.communicator = step.start.active->communicator();
    found.deepest      = 0.;
    for (const Group &group : step.stencils.groups)
      {
        for (unsigned int q = 0; q < group.n_points; ++q)
          {
            const auto particle = this->particle(step, group, q, u);
            begin_trial(particle, iterate.trial);
            const std::string wrong =
              for_each_touch(step, motions, particle, [&](const Touch &touch) {
                forces.add(particle, touch.arm, touch.force, touch.derivative);
                found.deepest =
                  std::max(found.deepest,
                           -touch.contact.gap_new / particle.corners->spacing);
                const unsigned int springs = tools[touch.tool].springs;
                if (springs != Tool<dim>::none)
                  iterate.trial.set(springs + dim * touch.corner,
                                    particle.p,
                                    touch.contact.spring);
              });
            if (!wrong.empty())
              problem = wrong;
            forces.finish(group, q);
          }
        forces.finish(group);
      }
    forces.finish(force); // collective: also after a problem
    return problem;
  }

  template <int dim>
  std::vector<EnergyEntry>
  Tools<dim>::energy_entries() const
  {
    using Kind = EnergyEntry::Kind;
    std::vector<EnergyEntry> entries{{"contact_energy", Kind::stored, 0.}};
    if (has_friction)
      {
        entries.push_back({"friction_energy", Kind::stored, 0.});
        entries.push_back({"friction_dissipation", Kind::dissipated, 0.});
      }
    for (const Tool<dim> &tool : tools)
      entries.push_back({"tool_" + tool.name + "_work", Kind::work, 0.});
    return entries;
  }

  template <int dim>
  std::vector<EnergyEntry>
  Tools<dim>::energies(const StepData<dim> &step,
                       const Vector        &displacement,
                       const PointArrays<dim> &) const
  {
    std::vector<EnergyEntry>  entries    = energy_entries();
    const unsigned int        first_work = entries.size() - tools.size();
    const auto                motions    = this->motions(step);
    const std::vector<double> u = step.start.active->to_local(displacement);
    for (unsigned int t = 0; t < tools.size(); ++t)
      {
        found.force[t]   = Tensor<1, dim>();
        found.moment[t]  = Tensor<1, 3>();
        found.sunk_in[t] = 0.;
      }
    for (const Group &group : step.stencils.groups)
      for (unsigned int q = 0; q < group.n_points; ++q)
        {
          const auto particle = this->particle(step, group, q, u);
          for_each_touch(step, motions, particle, [&](const Touch &touch) {
            const unsigned int   t      = touch.tool;
            const ToolStep<dim> &motion = motions[t];
            entries[0].change += touch.contact.stored;
            if (has_friction)
              {
                entries[1].change += touch.contact.spring_stored;
                entries[2].change += touch.contact.slip;
              }
            entries[first_work + t].change +=
              touch.force * (motion.displacement + motion.spin * touch.from);
            found.force[t] -= touch.force;
            found.moment[t] -= moment_of(touch.from, touch.force);
            found.sunk_in[t] =
              std::max(found.sunk_in[t],
                       -touch.contact.gap_new / particle.corners->spacing);
          });
        }
    return entries;
  }

  template <int dim>
  std::vector<EnergyEntry>
  Tools<dim>::energies_at_start(const PointArrays<dim> &points,
                                const double            time) const
  {
    std::vector<EnergyEntry> entries = energy_entries();
    for (unsigned int t = 0; t < tools.size(); ++t)
      {
        const Tool<dim> &tool     = tools[t];
        const auto       place    = tool.motion.place(time);
        const auto       to_frame = transpose(tool.motion.directions(time));
        double           stored   = 0.;
        for (std::size_t p = 0; p < points.n_points(); ++p)
          {
            const ParticleCorners<dim> &corners =
              corners_of_body[points.component(fields.body)[p]];
            const auto F = tensor_field(points, fields.deformation_gradient, p);
            for (unsigned int i = 0; i < corners.n; ++i)
              {
                const Tensor<1, dim> from =
                  points.point(p) + F * corners[i] - place;
                const bool held =
                  tool.held != Tool<dim>::none &&
                  is_held(tool, points.component(tool.held)[p], i);
                stored +=
                  contact_energy(law(tool, corners).stiffness,
                                 tool.shape->distance(to_frame * from).value,
                                 held);
              }
          }
        entries[0].change += stored;
        entries[entries.size() - tools.size() + t].change = stored;
      }
    return entries;
  }

  template <int dim>
  std::vector<std::string>
  Tools<dim>::columns_of(const std::string &name, const bool is_turning)
  {
    const std::string        tool = "tool_" + name + "_";
    std::vector<std::string> columns;
    for (const char *what : {"", "force_"})
      for (unsigned int d = 0; d < dim; ++d)
        columns.push_back(tool + what + "xyz"[d]);
    for (unsigned int d = dim == 2 ? 2 : 0; d < 3; ++d)
      columns.push_back(tool + "moment_" + "xyz"[d]);
    columns.push_back(tool + "sinking");
    if (is_turning)
      columns.push_back(tool + "angle");
    return columns;
  }

  template <int dim>
  std::vector<StepMeasure>
  Tools<dim>::measure(const PointArrays<dim> &,
                      const double               time,
                      const BackgroundGrid<dim> &grid)
  {
    std::vector<StepMeasure> result;
    for (unsigned int t = 0; t < tools.size(); ++t)
      {
        const auto    &motion = tools[t].motion;
        const MPI_Comm ranks  = grid.communicator();
        const auto     place  = motion.place(time);
        const auto force  = dealii::Utilities::MPI::sum(found.force[t], ranks);
        const auto moment = dealii::Utilities::MPI::sum(found.moment[t], ranks);
        std::vector<double> values;
        for (unsigned int d = 0; d < dim; ++d)
          values.push_back(place[d]);
        for (unsigned int d = 0; d < dim; ++d)
          values.push_back(force[d]);
        for (unsigned int d = dim == 2 ? 2 : 0; d < 3; ++d)
          values.push_back(moment[d]);
        values.push_back(dealii::Utilities::MPI::max(found.sunk_in[t], ranks));
        if (motion.is_turning())
          values.push_back(motion.angle(time));
        const auto names = columns_of(tools[t].name, motion.is_turning());
        for (unsigned int i = 0; i < values.size(); ++i)
          result.push_back({names[i], values[i]});
      }
    return result;
  }

  template <int dim>
  std::vector<Surface<dim>>
  Tools<dim>::surfaces(const double              time,
                       const dealii::Point<dim> &lower,
                       const dealii::Point<dim> &upper) const
  {
    std::vector<Surface<dim>> result;
    for (const Tool<dim> &tool : tools)
      result.push_back(
        surface_of(*tool.shape, tool.motion, time, lower, upper));
    return result;
  }

  template <int dim>
  std::string
  Tools<dim>::finding()
  {
    if (!found.communicator)
      return "";
    const double deepest =
      dealii::Utilities::MPI::max(found.deepest, *found.communicator);
    if (deepest <= std::max(deep, 2. * told_depth))
      return "";
    told_depth = deepest;
    return "particles sink into a tool by up to " + brief(deepest) +
           " of their spacing; a larger <Stiffness> of the tool, or smaller "
           "steps, let them sink in less";
  }

  template class Tools<2>;
  template class Tools<3>;
} // namespace emmy
