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
    template <int dim>
    constexpr unsigned int n_corners = 1u << dim;

    /** Deeper than this share of the spacing is worth a line. */
    constexpr double deep = 0.05;
    /** A corner that goes through a tool deeper than this has jumped over it.
     */
    constexpr double missed = 0.05;
    /** Nearer than this share of the spacing touches at the start. */
    constexpr double touching = 1e-6;

    template <int dim>
    Tensor<2, dim>
    gradient_field(const PointArrays<dim> &points,
                   const unsigned int      first,
                   const std::size_t       p)
    {
      Tensor<2, dim> F;
      for (unsigned int i = 0; i < dim; ++i)
        for (unsigned int j = 0; j < dim; ++j)
          F[i][j] = points.component(first + dim * i + j)[p];
      return F;
    }

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
  Tools<dim>::Tools(std::vector<Tool<dim>> given,
                    const Fields          &fields,
                    std::vector<Corners>   corners_of_body)
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
  Tensor<1, dim>
  Tools<dim>::corner(const Tensor<1, dim> &half_length, const unsigned int i)
  {
    Tensor<1, dim> result = half_length;
    for (unsigned int d = 0; d < dim; ++d)
      if (!(i >> d & 1))
        result[d] *= -1.;
    return result;
  }

  template <int dim>
  ContactLaw
  Tools<dim>::law(const Tool<dim> &tool, const Corners &corners) const
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
  Tools<dim>::motions(const double time, const double time_step) const
  {
    std::vector<ToolStep<dim>> result;
    for (const Tool<dim> &tool : tools)
      result.push_back(tool.motion.over(time, time_step));
    return result;
  }

  template <int dim>
  std::string
  Tools<dim>::mark(const BackgroundGrid<dim>               &grid,
                   dealii::Particles::ParticleHandler<dim> &particles) const
  {
    using namespace dealii::Utilities::MPI;
    std::string text;
    for (const Tool<dim> &tool : tools)
      {
        const auto   place    = tool.motion.place(0.);
        const auto   to_frame = transpose(tool.motion.directions(0.));
        unsigned int n_near   = 0;
        double       stored = 0., deepest = 0.;
        for (auto &particle : particles)
          {
            const auto     properties = particle.get_properties();
            const Corners &box  = corners_of_body[properties[fields.body]];
            unsigned int   held = 0;
            for (unsigned int i = 0; i < n_corners<dim>; ++i)
              {
                const Tensor<1, dim> from =
                  particle.get_location() + corner(box.half_length, i) - place;
                const double gap = tool.shape->distance(to_frame * from).value;
                const bool   is_near = gap <= touching * box.spacing;
                n_near += is_near;
                held |= is_near ? 1u << i : 0u;
                deepest = std::max(deepest, -gap / box.spacing);
                stored += contact_energy(law(tool, box).stiffness, gap, false);
              }
            if (tool.held != Tool<dim>::none)
              properties[tool.held] = held;
          }
        n_near  = sum(n_near, grid.communicator());
        stored  = sum(stored, grid.communicator());
        deepest = max(deepest, grid.communicator());
        AssertThrow(tool.held == Tool<dim>::none || n_near > 0,
                    ExcRun("Effects/Tools/" + tool.name,
                           "nothing touches the tool at the start, so it can "
                           "hold nothing",
                           "put its <Reference point> on the surface of the "
                           "body, or set Holds = false."));
        text +=
          (text.empty() ? "tool <" : "\n" + std::string(24, ' ') + "tool <") +
          tool.name + ">: ";
        if (tool.held != Tool<dim>::none)
          text += "holds " + std::to_string(n_near) + " corners, ";
        if (deepest > touching)
          text += "overlaps bodies by up to " + brief(deepest) +
                  " of their spacing, which stores " + brief(stored) + " J, ";
        text += "stiffness " + brief(tool.stiffness) +
                " M/s: a pressure of 1 % of the P-wave modulus M sinks in by " +
                brief(0.01 / tool.stiffness) + " of the spacing s";
      }
    return text;
  }

  template <int dim>
  typename Tools<dim>::Particle
  Tools<dim>::particle(const StepData<dim>       &step,
                       const Group               &group,
                       const unsigned int         q,
                       const std::vector<double> &u) const
  {
    const unsigned int *nodes = step.start.active->nodes(group);
    Particle            result;
    result.p       = group.first_point + q;
    result.corners = &corners_of_body[group.body];
    result.place   = step.points.point(result.p);
    for (unsigned int a = 0; a < group.n_nodes; ++a)
      for (unsigned int c = 0; c < dim; ++c)
        result.way[c] +=
          step.stencils.value(group, a)[q] * u[dim * nodes[a] + c];
    result.gradient = step.stencils.displacement_gradient(group, q, nodes, u);
    result.F_old =
      gradient_field(step.points, fields.deformation_gradient, result.p);
    result.F = result.F_old;
    if (step.stencils.at_middle)
      {
        Tensor<2, dim> from_start = -0.5 * result.gradient;
        for (unsigned int d = 0; d < dim; ++d)
          from_start[d][d] += 1.;
        result.Z = invert(from_start);
        result.F = result.Z * result.F_old;
      }
    return result;
  }

  template <int dim>
  bool
  Tools<dim>::is_far(const ToolStep<dim> &motion,
                     const Tool<dim>     &tool,
                     const Particle      &particle) const
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
                             const Particle                   &particle,
                             const Visit                      &visit) const
  {
    std::string problem;
    for (unsigned int t = 0; t < tools.size(); ++t)
      {
        const Tool<dim>     &tool   = tools[t];
        const ToolStep<dim> &motion = motions[t];
        if (is_far(motion, tool, particle))
          continue;
        const Corners   &box  = *particle.corners;
        const ContactLaw law  = this->law(tool, box);
        const double     held = tool.held == Tool<dim>::none
                                  ? 0.
                                  : step.points.component(tool.held)[particle.p];
        for (unsigned int i = 0; i < n_corners<dim>; ++i)
          {
            const Tensor<1, dim> xi  = corner(box.half_length, i);
            const Tensor<1, dim> arm = particle.F * xi;
            const Tensor<1, dim> from_old =
              particle.place + particle.F_old * xi - motion.place;
            const Tensor<1, dim> seen =
              particle.way + particle.gradient * arm - motion.displacement;
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
                             0.1 * missed * box.spacing) > missed * box.spacing)
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
  Tools<dim>::PointForce::add(const Touch &touch, const Particle &particle)
  {
    acts          = true;
    const auto &a = touch.arm;
    // the arm of the middle turns with L: da = Z dL a/2
    Tensor<2, dim> by_gradient =
      touch.derivative +
      0.5 * (touch.derivative * (particle.gradient * particle.Z));
    for (unsigned int i = 0; i < dim; ++i)
      for (unsigned int l = 0; l <= dim; ++l)
        {
          const double       weight = l == 0 ? 1. : a[l - 1];
          const unsigned int row    = (dim + 1) * i + l;
          value[row] += weight * touch.force[i];
          for (unsigned int j = 0; j < dim; ++j)
            for (unsigned int m = 0; m <= dim; ++m)
              {
                double &entry = by_motion[row][(dim + 1) * j + m];
                if (m == 0)
                  entry += weight * touch.derivative[i][j];
                else
                  entry += weight * by_gradient[i][j] * a[m - 1];
                if (m > 0 && l > 0)
                  entry +=
                    0.5 * touch.force[i] * particle.Z[l - 1][j] * a[m - 1];
              }
        }
  }

  template <int dim>
  void
  Tools<dim>::follow_places(const StepData<dim>       &step,
                            const Group               &group,
                            const unsigned int         q,
                            const std::vector<double> &u,
                            PointForce                &force,
                            Assembly                  &work) const
  {
    // dr = W dG + W,k G dq_k; dG = E (dz + z,k dq_k); dq = shift + R dz
    constexpr unsigned int nq    = PlaceDerivatives<dim>::n;
    const unsigned int    *nodes = step.start.active->nodes(group);
    const auto &response = step.moving->response_of(group.first_point + q);
    step.moving->differentiate(step, group, q, work.by_place);
    const auto weight_by_place =
      [&](const unsigned int k, const unsigned int l, const unsigned int a) {
        return l == 0 ? work.by_place.value(k)[a]
                      : work.by_place.gradient(k, l - 1)[a];
      };
    Motion     moved{}; // E z,k shift_k
    const auto by_motion = force.by_motion;
    for (unsigned int k = 0; k < nq; ++k)
      {
        Motion z{}, along{};
        for (unsigned int a = 0; a < group.n_nodes; ++a)
          for (unsigned int j = 0; j < dim; ++j)
            for (unsigned int m = 0; m <= dim; ++m)
              z[(dim + 1) * j + m] +=
                weight_by_place(k, m, a) * u[dim * nodes[a] + j];
        for (unsigned int row = 0; row < n_motion; ++row)
          for (unsigned int column = 0; column < n_motion; ++column)
            along[row] += by_motion[row][column] * z[column];
        for (unsigned int row = 0; row < n_motion; ++row)
          {
            moved[row] += along[row] * response.shift[k];
            for (unsigned int j = 0; j < dim; ++j)
              for (unsigned int m = 0; m <= dim; ++m)
                force.by_motion[row][(dim + 1) * j + m] +=
                  along[row] * response.by_motion[k][j][m];
          }
        for (unsigned int a = 0; a < group.n_nodes; ++a)
          for (unsigned int i = 0; i < dim; ++i)
            {
              double sum = 0.;
              for (unsigned int l = 0; l <= dim; ++l)
                sum +=
                  weight_by_place(k, l, a) * force.value[(dim + 1) * i + l];
              work.share[dim * nodes[a] + i] -= sum * response.shift[k];
              for (unsigned int j = 0; j < dim; ++j)
                for (unsigned int m = 0; m <= dim; ++m)
                  work.along[dim * a + i][(dim + 1) * j + m] +=
                    sum * response.by_motion[k][j][m];
            }
      }
    for (unsigned int a = 0; a < group.n_nodes; ++a)
      for (unsigned int i = 0; i < dim; ++i)
        {
          double sum = step.stencils.value(group, a)[q] * moved[(dim + 1) * i];
          for (unsigned int d = 0; d < dim; ++d)
            sum += step.stencils.gradient(group, a, d)[q] *
                   moved[(dim + 1) * i + 1 + d];
          work.share[dim * nodes[a] + i] -= sum;
        }
  }

  template <int dim>
  void
  Tools<dim>::add_to_nodes(const StepData<dim>       &step,
                           const Group               &group,
                           const unsigned int         q,
                           const std::vector<double> &u,
                           const bool                 with_matrix,
                           PointForce                &force,
                           Assembly                  &work) const
  {
    const unsigned int  n     = group.n_nodes;
    const unsigned int *nodes = step.start.active->nodes(group);
    std::vector<std::array<double, dim + 1>> weights(n);
    for (unsigned int a = 0; a < n; ++a)
      {
        weights[a][0] = step.stencils.value(group, a)[q];
        for (unsigned int d = 0; d < dim; ++d)
          weights[a][1 + d] = step.stencils.gradient(group, a, d)[q];
        for (unsigned int i = 0; i < dim; ++i)
          for (unsigned int l = 0; l <= dim; ++l)
            work.nodal_force[dim * nodes[a] + i] -=
              weights[a][l] * force.value[(dim + 1) * i + l];
      }
    if (!with_matrix)
      return;
    if (!work.has_matrix)
      work.matrix.reinit(dim * n, dim * n);
    work.has_matrix = true;
    work.along.assign(dim * n, Motion{});
    if (step.moving)
      follow_places(step, group, q, u, force, work);
    for (unsigned int a = 0; a < n; ++a)
      for (unsigned int i = 0; i < dim; ++i)
        {
          Motion &along = work.along[dim * a + i];
          for (unsigned int l = 0; l <= dim; ++l)
            for (unsigned int column = 0; column < n_motion; ++column)
              along[column] +=
                weights[a][l] * force.by_motion[(dim + 1) * i + l][column];
          for (unsigned int b = 0; b < n; ++b)
            for (unsigned int j = 0; j < dim; ++j)
              for (unsigned int m = 0; m <= dim; ++m)
                work.matrix(dim * a + i, dim * b + j) -=
                  along[(dim + 1) * j + m] * weights[b][m];
        }
  }

  template <int dim>
  std::string
  Tools<dim>::add(const StepData<dim> &step,
                  const Iterate<dim>  &iterate,
                  Vector              &force,
                  Matrix              *jacobian) const
  {
    const ActiveGrid<dim> &active  = *step.start.active;
    const auto             motions = this->motions(step.time, step.time_step);
    const std::vector<double> &u   = iterate.local_displacement;
    Assembly                   work;
    work.nodal_force.resize(dim * active.n_local_nodes());
    if (jacobian && step.moving)
      work.share.resize(work.nodal_force.size());
    std::string problem;
    found.communicator = active.communicator();
    found.deepest      = 0.;
    for (const Group &group : step.stencils.groups)
      {
        work.has_matrix = false;
        for (unsigned int q = 0; q < group.n_points; ++q)
          {
            const Particle       particle = this->particle(step, group, q, u);
            const Tensor<2, dim> F_new =
              particle.F_old + particle.gradient * particle.F;
            for (unsigned int i = 0; i < dim * dim; ++i)
              iterate.trial.component(fields.deformation_gradient +
                                      i)[particle.p] = F_new[i / dim][i % dim];
            for (const Tool<dim> &tool : tools)
              if (tool.springs != Tool<dim>::none)
                for (unsigned int i = 0; i < dim * n_corners<dim>; ++i)
                  iterate.trial.component(tool.springs + i)[particle.p] = 0.;

            PointForce        total;
            const std::string wrong =
              for_each_touch(step, motions, particle, [&](const Touch &touch) {
                total.add(touch, particle);
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
            if (total.acts)
              add_to_nodes(step, group, q, u, jacobian != nullptr, total, work);
          }
        if (jacobian && work.has_matrix)
          active.graph().add(active.nodes(group), work.matrix, *jacobian);
      }
    active.add(work.nodal_force, force); // collective: also after a problem
    if (jacobian && step.moving)
      step.moving->add_to_share(work.share);
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
    std::vector<EnergyEntry> entries    = energy_entries();
    const unsigned int       first_work = entries.size() - tools.size();
    const auto               motions = this->motions(step.time, step.time_step);
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
          const Particle particle = this->particle(step, group, q, u);
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
            const Corners &box =
              corners_of_body[points.component(fields.body)[p]];
            const auto F =
              gradient_field(points, fields.deformation_gradient, p);
            for (unsigned int i = 0; i < n_corners<dim>; ++i)
              {
                const Tensor<1, dim> from =
                  points.point(p) + F * corner(box.half_length, i) - place;
                const bool held =
                  tool.held != Tool<dim>::none &&
                  is_held(tool, points.component(tool.held)[p], i);
                stored +=
                  contact_energy(law(tool, box).stiffness,
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
