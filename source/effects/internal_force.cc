#include <emmy/effects/internal_force.h>
#include <emmy/effects/moving_places.h>

#include <algorithm>

namespace emmy
{
  template <int dim>
  InternalForce<dim>::InternalForce(
    std::vector<const Material<dim> *> material_of_body,
    FieldLayout                       &layout,
    const StressRule<dim>             &rule,
    std::vector<std::string>           names)
    : rule(rule)
    , states(std::move(material_of_body), std::move(names), layout)
  {}

  template <int dim>
  EffectCard
  InternalForce<dim>::card()
  {
    EffectCard card = StressStates<dim>::card();
    card.enters     = "Newton: stress of the particles";
    return card;
  }

  template <int dim>
  std::string
  InternalForce<dim>::add(const StepData<dim> &step,
                          const Iterate<dim>  &iterate,
                          Vector              &force,
                          Matrix              *jacobian) const
  {
    // too large for the stack of a thread
    const auto work          = std::make_unique<Assembly>();
    work->batch.with_tangent = jacobian != nullptr;
    work->nodal_force.resize(dim * step.start.active->n_local_nodes());
    constexpr unsigned int few   = 4; // points in a group
    const NodeGraph<dim>  &graph = step.start.active->graph();
    if (jacobian &&
        step.stencils.particles.size() < few * step.stencils.groups.size())
      {
        if (step.moving)
          work->sum.emplace(graph, *jacobian);
        else
          work->pool.emplace(graph, *jacobian);
      }

    // what moves with the places goes to the matrix group by group
    const std::string problem = states.for_each_run(
      step.stencils,
      step.phases,
      jacobian && step.moving ? 0 : max_batch_points,
      [&](const Group *first, const Group *end) {
        return end - first == 1
                 ? add_group(step, iterate, *first, *work, jacobian)
                 : add_run(step, iterate, {first, end}, *work, jacobian);
      });
    if (work->sum)
      work->sum->flush();
    if (work->pool)
      work->pool->flush();
    step.start.active->add(work->nodal_force,
                           force); // collective: also after a problem
    return problem;
  }

  template <int dim>
  std::string
  InternalForce<dim>::add_run(const StepData<dim> &step,
                              const Iterate<dim>  &iterate,
                              const Run           &run,
                              Assembly            &work,
                              Matrix              *jacobian) const
  {
    const ActiveGrid<dim> &active   = *step.start.active;
    const unsigned int     body     = run.begin->body;
    const std::size_t      point    = run.begin->first_point;
    unsigned int           n_points = 0;
    for (const Group *group = run.begin; group != run.end; ++group)
      {
        displacement_gradients(step.stencils,
                               {*group, 0, group->n_points, n_points},
                               iterate.local_displacement.data(),
                               active.nodes(*group),
                               work.batch);
        n_points += group->n_points;
      }
    work.batch.n_points = n_points;
    const unsigned int inverted =
      find_stress(step, body, point, work.batch, work.middle);
    if (inverted < n_points)
      return inverted_particle(step.stencils, point + inverted);
    states.write(work.batch, step.points, body, point, iterate.trial);

    unsigned int in_batch = 0;
    for (const Group *group = run.begin; group != run.end; ++group)
      {
        const unsigned int *nodes = active.nodes(*group);
        const double       *volumes =
          states.reference_volumes(step.points) + group->first_point;
        add_forces(step.stencils,
                   {*group, 0, group->n_points, in_batch},
                   volumes,
                   nodes,
                   work.batch,
                   work.nodal_force);
        if (jacobian)
          add_stiffness({step.stencils,
                         *group,
                         0,
                         group->n_points,
                         work.batch,
                         in_batch,
                         volumes},
                        nodes,
                        active.graph(),
                        work,
                        *jacobian);
        in_batch += group->n_points;
      }
    return {};
  }

  template <int dim>
  void
  InternalForce<dim>::add_stiffness(
    const typename CellMatrix<dim>::Points &points,
    const unsigned int                     *nodes,
    const NodeGraph<dim>                   &graph,
    Assembly                               &work,
    Matrix                                 &jacobian) const
  {
    if (work.pool)
      return work.pool->add(nodes, points);
    if (points.first == 0)
      work.stiffness.reinit(points.group.n_nodes);
    work.stiffness.add(points);
    if (points.first + points.n_points == points.group.n_points)
      graph.add(nodes, work.stiffness.blocks(), jacobian);
  }

  template <int dim>
  std::string
  InternalForce<dim>::add_group(const StepData<dim> &step,
                                const Iterate<dim>  &iterate,
                                const Group         &group,
                                Assembly            &work,
                                Matrix              *jacobian) const
  {
    const ActiveGrid<dim> &active = *step.start.active;
    const unsigned int    *nodes  = active.nodes(group);
    if (jacobian && step.moving)
      step.moving->begin_group(group.n_nodes);

    for (unsigned int first = 0; first < group.n_points;
         first += max_batch_points)
      {
        const std::size_t  point    = group.first_point + first;
        const unsigned int inverted = evaluate(step,
                                               group,
                                               first,
                                               iterate.local_displacement,
                                               work.batch,
                                               work.middle);
        const unsigned int n_points = work.batch.n_points;
        if (inverted < n_points)
          return inverted_particle(step.stencils, point + inverted);

        states.write(work.batch, step.points, group.body, point, iterate.trial);
        const double *volumes = states.reference_volumes(step.points) + point;
        add_forces(step.stencils,
                   {group, first, n_points, 0},
                   volumes,
                   nodes,
                   work.batch,
                   work.nodal_force);
        if (jacobian && step.moving)
          step.moving->add({step,
                            group,
                            first,
                            iterate.local_displacement,
                            work.batch,
                            work.middle,
                            volumes});
        else if (jacobian)
          add_stiffness(
            {step.stencils, group, first, n_points, work.batch, 0, volumes},
            nodes,
            active.graph(),
            work,
            *jacobian);
      }
    if (!jacobian || !step.moving)
      return {};
    const ComponentBlocks blocks = step.moving->finish_group(nodes);
    if (work.sum)
      work.sum->add(nodes, blocks);
    else
      active.graph().add(nodes, blocks, *jacobian);
    return {};
  }

  template <int dim>
  unsigned int
  InternalForce<dim>::evaluate(const StepData<dim>       &step,
                               const Group               &group,
                               const unsigned int         first,
                               const std::vector<double> &local_displacement,
                               StressBatch<dim>          &batch,
                               MiddleStep<dim>           &middle) const
  {
    batch.n_points = std::min(max_batch_points, group.n_points - first);
    displacement_gradients(step.stencils,
                           {group, first, batch.n_points, 0},
                           local_displacement.data(),
                           step.start.active->nodes(group),
                           batch);
    return find_stress(
      step, group.body, group.first_point + first, batch, middle);
  }

  template <int dim>
  unsigned int
  InternalForce<dim>::find_stress(const StepData<dim> &step,
                                  const unsigned int   body,
                                  const std::size_t    point,
                                  StressBatch<dim>    &batch,
                                  MiddleStep<dim>     &middle) const
  {
    states.read(step.points, body, point, batch);
    if (!step.stencils.at_middle)
      return rule.evaluate(states.material(body), batch);
    unsigned int inverted = middle.to_start(batch);
    if (inverted == batch.n_points)
      inverted = rule.evaluate(states.material(body), batch);
    if (inverted == batch.n_points)
      middle.to_middle(batch);
    return inverted;
  }

  template <int dim>
  double
  InternalForce<dim>::work(const StepData<dim> &step,
                           const Vector        &displacement) const
  {
    const auto    local  = step.start.active->to_local(displacement);
    const double *volume = states.reference_volumes(step.points);
    const auto    batch  = std::make_unique<StressBatch<dim>>();
    batch->with_tangent  = false;
    MiddleStep<dim> middle;
    double          result = 0.;
    for (const Group &group : step.stencils.groups)
      for (unsigned int first = 0; first < group.n_points;
           first += max_batch_points)
        {
          evaluate(step, group, first, local, *batch, middle);
          for (unsigned int q = 0; q < batch->n_points; ++q)
            result += volume[group.first_point + first + q] *
                      scalar_product(batch->nominal_stress[q],
                                     batch->displacement_gradient[q]);
        }
    return result;
  }

  template <int dim>
  std::vector<EnergyEntry>
  InternalForce<dim>::energies(const StepData<dim>    &step,
                               const Vector           &displacement,
                               const PointArrays<dim> &accepted) const
  {
    std::vector<EnergyEntry> entries = states.energies(step.points, accepted);
    if (!rule.is_conserving)
      {
        const auto timed = effect_scope(step.phases, stress_rule_effect);
        double     known = 0.;
        for (const EnergyEntry &entry : entries)
          known += entry.change;
        entries.push_back({"stress_rule_loss",
                           EnergyEntry::Kind::dissipated,
                           work(step, displacement) - known});
      }
    return entries;
  }

  template <int dim>
  std::vector<EnergyEntry>
  InternalForce<dim>::energy_entries() const
  {
    std::vector<EnergyEntry> entries = states.energy_entries();
    if (!rule.is_conserving)
      entries.push_back(
        {"stress_rule_loss", EnergyEntry::Kind::dissipated, 0.});
    return entries;
  }

  template class InternalForce<2>;
  template class InternalForce<3>;
} // namespace emmy
