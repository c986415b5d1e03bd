#include <emmy/base/exceptions.h>
#include <emmy/step/start_balance.h>
#include <emmy/step/time_integrator.h>
#include <emmy/transfer/grid_to_particles.h>

namespace emmy
{
  template <int dim>
  TimeIntegrator<dim>::TimeIntegrator(const StepSetting<dim> &setting,
                                      RunState<dim>          &state,
                                      const RemediesInUse    &in_use)
    : setting(setting)
    , state(state)
    , detector(in_use, state.detector, state.told)
  {}

  template <int dim>
  std::string
  TimeIntegrator<dim>::where() const
  {
    return step_name(state.step + 1, state.time);
  }

  template <int dim>
  StepReport
  TimeIntegrator<dim>::initial_report()
  {
    const Ground<dim>      ground  = ground_at_start();
    const ActiveGrid<dim> *on_grid = nullptr;
    timed("particles to grid", [&] { on_grid = &renew_grid(ground); });
    const ActiveGrid<dim> &active = *on_grid;
    StepReport             result;
    result.time_step = choose_step_size(setting.method,
                                        setting.limits,
                                        setting.layout,
                                        ground.stencils,
                                        ground.points,
                                        active,
                                        state.time)
                         .time_step;
    result.totals =
      measure(ground.points, setting.layout, active.communicator());
    state.kinetic_energy = result.totals.kinetic_energy;
    result.energies      = energy_entries();
    setting.method.balance.set_energies_at_start(ground.points,
                                                 state.time,
                                                 active.communicator(),
                                                 result.energies);
    detector.begin(overfill(ground.stencils,
                            ground.points,
                            ground.points,
                            setting.layout,
                            active,
                            setting.grid),
                   result);
    add_measures(ground.points, state.time, result.measures);
    add_size(active, result);
    return result;
  }

  template <int dim>
  double
  TimeIntegrator<dim>::imbalance()
  {
    const Ground<dim> ground = ground_at_start();
    return start_imbalance(
      ground.stencils, ground.points, renew_grid(ground), setting, state.time);
  }

  template <int dim>
  Ground<dim>
  TimeIntegrator<dim>::ground_at_start()
  {
    Ground<dim> ground;
    ground.stencils = timed("stencils", [&] {
      return setting.method.shape_functions.evaluate(state.particles,
                                                     setting.grid);
    });
    ground.points =
      timed("gather", [&] { return gather(ground.stencils, setting.layout); });
    return ground;
  }

  template <int dim>
  void
  TimeIntegrator<dim>::note_limit(const StepSize           &size,
                                  std::vector<std::string> &notes)
  {
    if (size.note.empty() || state.told.limited_travel)
      return;
    state.told.limited_travel = true;
    notes.push_back(where() + ": " + size.note);
  }

  template <int dim>
  void
  TimeIntegrator<dim>::follow_domains(const Ground<dim>         &ground,
                                      const ActiveGrid<dim>     &active,
                                      const std::vector<double> &displacement,
                                      PointArrays<dim>          &trial,
                                      std::vector<std::string>  &notes)
  {
    setting.method.balance.follow(
      ground.stencils, ground.points, active, displacement, trial);
    if (!setting.method.domain_update)
      return;
    const auto timed = setting.phases.effect(domain_update_effect);
    (*setting.method.domain_update)(
      ground.stencils, ground.points, active, displacement, trial);
    throw_together(setting.grid.communicator(),
                   where(),
                   DomainUpdate<dim>::problem(
                     ground.stencils, setting.layout, setting.grid, trial),
                   "the step was not accepted. Use another Method/Domain "
                   "update (stretch does not vanish under rotation, none "
                   "keeps the size), or more Points per direction.");
    const std::uint64_t n_cut =
      DomainUpdate<dim>::n_cut(setting.layout, setting.grid, trial);
    if (n_cut < 2 * state.told.most_cut_domains || n_cut == 0)
      return;
    state.told.most_cut_domains = n_cut;
    notes.push_back(where() + ": domains of " + std::to_string(n_cut) +
                    " particles are longer than two cells and act as if cut "
                    "at that size; more Points per direction or larger cells "
                    "avoid it");
  }

  template <int dim>
  StepReport
  TimeIntegrator<dim>::begin_report(const double            time_step,
                                    const PointArrays<dim> &trial) const
  {
    StepReport result;
    result.step      = state.step + 1;
    result.time_step = time_step;
    result.time      = state.time + time_step;
    result.totals = measure(trial, setting.layout, setting.grid.communicator());
    return result;
  }

  template <int dim>
  void
  TimeIntegrator<dim>::end_report(const Ground<dim>      &ground,
                                  const PointArrays<dim> &trial,
                                  const ActiveGrid<dim>  &active,
                                  const double            hidden,
                                  StepReport             &report)
  {
    detector.look(hidden,
                  overfill(ground.stencils,
                           ground.points,
                           trial,
                           setting.layout,
                           active,
                           setting.grid),
                  where(),
                  report);
    add_measures(trial, report.time, report.measures);
    add_size(active, report);
  }

  template <int dim>
  void
  TimeIntegrator<dim>::add_measures(const PointArrays<dim>   &points,
                                    const double              time,
                                    std::vector<StepMeasure> &measures)
  {
    for (StepMeasure &measure : setting.method.balance.measures(
           points, time, setting.grid, &setting.phases))
      measures.push_back(std::move(measure));
  }

  template <int dim>
  void
  TimeIntegrator<dim>::add_size(const ActiveGrid<dim> &active,
                                StepReport            &report)
  {
    report.active_cells = dealii::Utilities::MPI::sum(
      static_cast<std::uint64_t>(active.cells().size()), active.communicator());
    report.active_dofs = active.n_dofs();
  }

  template <int dim>
  void
  TimeIntegrator<dim>::accept(const Ground<dim>      &ground,
                              const PointArrays<dim> &trial,
                              const StepReport       &report)
  {
    timed("grid to particles", [&] {
      grid_to_particles(
        ground.stencils, trial, setting.layout, setting.grid, state.particles);
    });
    for (const char *phase :
         {"stencils", "gather", "particles to grid", "grid to particles"})
      setting.phases.add_count(phase, ground.points.n_points());
    state.kinetic_energy = report.totals.kinetic_energy;
    setting.method.balance.end_step(state.time, report.time_step);
    state.time = report.time;
    state.step = report.step;
  }

  template class TimeIntegrator<2>;
  template class TimeIntegrator<3>;
} // namespace emmy
