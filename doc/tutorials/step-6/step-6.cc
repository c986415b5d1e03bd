// A time integrator of our own, with the pieces of the explicit one of emmy.
#include <emmy/output/ledger.h>
#include <emmy/run/scene.h>
#include <emmy/step/accounts.h>
#include <emmy/step/explicit_stepper.h>
#include <emmy/transfer/grid_to_particles.h>

#include <iomanip>
#include <iostream>

using namespace emmy;

// `TimeIntegrator` knows how a step begins (stencils and states of the
// particles), how it is accepted, and what is reported of any step. We say what
// happens between. The scenes have neither walls nor loads here.
class StressFirst : public TimeIntegrator<2>
{
public:
  StressFirst(const StepSetting<2>   &setting,
              const ExplicitForce<2> &force,
              RunState<2>            &state)
    : TimeIntegrator<2>(setting,
                        state,
                        {/*gimp=*/true,
                         /*middle=*/true,
                         /*followers=*/true,
                         /*is_dissipative=*/false})
    , force(force)
  {}

  StepReport
  advance() override
  {
    // Particles -> grid: lumped mass and momentum, and the velocity v_0.
    const Ground<2>      ground = ground_at_start();
    const ActiveGrid<2> &active = renew_grid(ground);
    const double         dt     = setting.limits.step_size;
    const StepData<2>    step{
      ground.stencils, ground.points, start, state.time, dt, &setting.phases};

    // The stress first: the particles strain with the velocity that they bring.
    std::vector<double> u = lumped.velocity;
    for (double &component : u)
      component *= dt;
    PointArrays<2> trial  = ground.points;
    const char    *remedy = "take a smaller Time/Step size.";
    throw_together(setting.grid.communicator(),
                   where(),
                   force.update(step, u, trial),
                   remedy);

    // Forces of that stress: the same data with other states of the points.
    const StepData<2> strained{
      ground.stencils, trial, start, state.time, dt, &setting.phases};
    std::vector<double> internal(u.size());
    force.add(strained, internal);
    active.share(internal);

    // v_1 = v_0 - dt f / m. What the force does to the energy is its work over
    // the mean velocity: exactly what kinetic energy changes by.
    std::vector<double> change(u.size()), u_new(u.size());
    double              work = 0.;
    for (unsigned int i = 0; i < u.size(); ++i)
      if (const double m = lumped.mass[i / 2]; !lumped.is_massless[i / 2])
        change[i] = -dt * internal[i] / m;
    for (unsigned int i = 0; i < u.size(); ++i)
      u_new[i] = u[i] + dt * change[i];
    for (unsigned int i = 0; i < 2 * active.n_owned_nodes(); ++i)
      work += internal[i] * dt * (lumped.velocity[i] + 0.5 * change[i]);

    // Grid -> particles: places, velocities and domains, still on trial. If a
    // particle leaves the grid all ranks throw, and nothing has happened.
    throw_together(setting.grid.communicator(),
                   where(),
                   move_points(ground.stencils,
                               ground.points,
                               active,
                               setting.grid,
                               setting.layout,
                               /*flip_fraction=*/1.,
                               u_new,
                               change,
                               trial),
                   remedy);
    std::vector<std::string> notes;
    follow_domains(ground, active, u, trial, notes);

    // The report, and then the particles get their new states.
    StepReport report = make_report(ground, step, trial, work, change);
    accept(ground, trial, report);
    return report;
  }

  // What the output may ask for.
  std::string
  solver_name() const override
  {
    return "none: stress first";
  }
  const GridStart<2> &
  grid_start() const override
  {
    return start;
  }
  const Vector &
  grid_velocity() const override
  {
    return velocity;
  }
  std::vector<double>
  nodal_mass() const override
  {
    return lumped.mass;
  }
  const StepDiagnosis<2> *
  diagnosis() const override
  {
    return nullptr;
  }

private:
  // The active nodes stay where particles keep their cells.
  const ActiveGrid<2> &
  renew_grid(const Ground<2> &ground) override
  {
    if (!start.active || !start.active->fits(ground.stencils, {}))
      start.active =
        std::make_unique<const ActiveGrid<2>>(ground.stencils,
                                              Couplings<2>(),
                                              setting.grid,
                                              setting.boundary_conditions,
                                              ActiveGrid<2>::Matrices::none);
    lumped = particles_to_lumped_grid(ground.stencils,
                                      ground.points,
                                      setting.layout,
                                      *start.active);
    return *start.active;
  }

  // The columns of the ledger, those of the force and those of the map. What
  // the work of the force does not leave as strain energy is
  // *stress_update_loss*; what lumping takes is *lumping_loss*.
  std::vector<EnergyEntry>
  energy_entries() const override
  {
    std::vector<EnergyEntry> entries = force.energy_entries();
    for (const auto &entry : account_entries(StepAccounts(), setting.method))
      entries.push_back(entry);
    return entries;
  }

  StepReport
  make_report(const Ground<2>           &ground,
              const StepData<2>         &step,
              const PointArrays<2>      &trial,
              const double               work,
              const std::vector<double> &change)
  {
    StepReport report = begin_report(step.time_step, trial);
    report.kinetic_energy_change =
      report.totals.kinetic_energy - state.kinetic_energy;
    report.energies = force.energies(step.points, trial, work);
    for (EnergyEntry &entry : report.energies)
      entry.change =
        dealii::Utilities::MPI::sum(entry.change, setting.grid.communicator());
    std::vector<double> velocity_new = lumped.velocity;
    for (unsigned int i = 0; i < change.size(); ++i)
      velocity_new[i] += change[i];
    StepAccounts books;
    add_mapping_losses(step,
                       setting.layout,
                       setting.method.mapping,
                       lumped.velocity,
                       velocity_new,
                       books);
    for (const auto &entry : account_entries(books, setting.method))
      report.energies.push_back(entry);
    end_report(
      ground, trial, *start.active, books.hidden_kinetic_energy, report);
    return report;
  }

  const ExplicitForce<2> &force;
  GridStart<2>            start;
  LumpedGrid<2>           lumped;
  Vector                  velocity;
};

// A scene takes any integrator. It has made one that fits its parameters; we
// make ours of the same parts and put it in its place.
void
put_ours(Scene<2> &scene, const SceneParameters<2> &parameters)
{
  const StepMethod<2> method{*scene.shape_functions,
                             scene.domain_update.get(),
                             scene.mapping,
                             *scene.step_rule,
                             scene.travel_limit.get(),
                             scene.balance,
                             parameters.diagnosis};
  scene.stepper =
    std::make_unique<StressFirst>(StepSetting<2>{scene.grid,
                                                 scene.boundary_conditions,
                                                 scene.layout,
                                                 method,
                                                 parameters.time,
                                                 scene.phases},
                                  *scene.explicit_force,
                                  scene.state);
}

// Run the scene with one of three integrators, and say what became of energy
// and momentum. The balance closes for all, as what is lost is booked.
void
run_with(const std::string &integrator, const std::string &filename)
{
  ParameterFile file(filename);
  file.set(integrator == "implicit" ? "Time/Integrator=implicit"
                                    : "Time/Integrator=explicit");
  const SceneParameters<2> parameters(file);
  Scene<2>                 scene(parameters, MPI_COMM_WORLD);
  if (integrator == "stress first")
    put_ours(scene, parameters);
  Ledger       ledger(scene.initial_report(), 2);
  const double energy = ledger.total_energy();
  while (ledger["time"] < parameters.time.end_time * (1. - 1e-12))
    ledger.add(scene.advance());
  std::cout << std::setw(14) << integrator << std::fixed << std::setprecision(2)
            << std::setw(8) << 100. * (ledger.total_energy() / energy - 1.)
            << " %   balance closes: "
            << (std::abs(ledger["balance_error"]) < 1e-9 * energy)
            << "   momentum stays: "
            << (std::abs(ledger["linear_momentum_x"]) < 1e-9) << '\n';
}

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  std::cout << "change of energy until the end\n";
  for (const std::string name : {"implicit", "explicit", "stress first"})
    run_with(name, argc > 1 ? argv[1] : "step-6.prm");
}
