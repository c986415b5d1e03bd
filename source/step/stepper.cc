#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/effects/inertia.h>
#include <emmy/step/failure.h>
#include <emmy/step/stepper.h>
#include <emmy/step/velocity_map.h>
#include <emmy/transfer/grid_to_particles.h>

namespace emmy
{
  template <int dim>
  Stepper<dim>::Stepper(const StepSetting<dim> &setting,
                        const SolverParameters &solver_parameters,
                        RunState<dim>          &state)
    : Base(setting, state, remedies_in_use(setting))
    , solver_parameters(solver_parameters)
    , particles_to_grid(setting.grid,
                        setting.boundary_conditions,
                        setting.layout,
                        setting.method.mapping,
                        &setting.phases)
  {}

  template <int dim>
  StepReport
  Stepper<dim>::advance()
  {
    // particles -> grid -> solve; as long as this fails, particles keep their
    // states
    Solution solution = solve();
    for (const std::string &finding : setting.method.balance.findings())
      solution.findings.push_back(where() + ": " + finding);
    if (setting.method.diagnosis.small_cuts)
      timed("diagnosis", [&] { examine(solution); });

    solution.equation().drop_jacobian(); // its room is for the particles

    // grid -> particles
    const StepReport result = timed("accounts", [&] {
      follow(solution);
      return report(solution);
    });
    accept(solution.ground(), solution.equation().trial(), result);
    setting.phases.add_count("residual and tangent",
                             solution.ground().points.n_points() *
                               solution.newton.residual_history.size());
    velocity = std::move(solution.velocity);
    return result;
  }

  template <int dim>
  typename Stepper<dim>::Solution
  Stepper<dim>::solve()
  {
    Solution solution;
    failure = {};
    choose_size(solution);
    for (unsigned int halvings = 0;; ++halvings, solution.time_step *= 0.5)
      {
        setting.phases.begin_task(
          where() + (halvings == 0
                       ? std::string()
                       : ", halved " + std::to_string(halvings) + " times"));
        setting.method.balance.check_step(state.time,
                                          solution.time_step,
                                          where());
        try_size(solution);
        if (solution.newton.is_converged)
          move(solution);
        if (solution.newton.is_converged)
          break;
        failure.tries.push_back({solution.time_step,
                                 solution.newton.residual_history,
                                 solution.newton.problem});
        if (halvings == setting.limits.maximum_halvings)
          give_up(FailedStep<dim>{solution.ground(),
                                  *start,
                                  solution.equation(),
                                  solution.displacement,
                                  solution.leaves_grid},
                  setting,
                  where(),
                  failure);
        ++solution.halvings;
        const std::string halved =
          "halved to " + brief(0.5 * solution.time_step) + " s";
        tell(solution, halved, solution.newton.problem + "; " + halved);
      }
    if (solution.newton.is_damped)
      tell(solution,
           "Newton needed a damped matrix",
           "Newton converged only with a damped matrix (first " +
             solution.newton.first_try + ")" +
             (solution.newton.leaves_rest
                ? "; |r| stays at " +
                    brief(solution.equation().residual().l2_norm() /
                          solution.equation().system().scale) +
                    " of the forces"
                : std::string()));
    return solution;
  }

  template <int dim>
  void
  Stepper<dim>::try_size(Solution &solution)
  {
    constexpr unsigned int most = 10;
    for (unsigned int tries = 1;; ++tries)
      {
        if (setting.method.middle)
          try_in_middle(solution);
        else
          try_from_start(solution);
        if (!solution.newton.is_converged)
          return;
        const std::string missing = setting.method.balance.missing(
          data_of(solution.ground(), *start, solution.time_step),
          solution.displacement);
        if (missing.empty())
          return;
        if (tries == most)
          {
            solution.newton.is_converged = false;
            solution.newton.problem      = missing;
            return;
          }
        solution.findings.push_back(where() + ": " + missing +
                                    "; it is solved again");
        if (setting.method.middle)
          continue; // begins anew
        renew_grid(*solution.at_start);
        velocity_from_momentum(*solution.at_start, particles_to_grid.last());
      }
  }

  template <int dim>
  void
  Stepper<dim>::choose_size(Solution &solution)
  {
    StepSize chosen;
    if (setting.method.middle)
      chosen = size_in_middle();
    else
      {
        solution.at_start =
          std::make_unique<Ground<dim>>(this->ground_at_start());
        const Ground<dim> &ground = *solution.at_start;
        timed("particles to grid", [&] { renew_grid(ground); });
        timed("velocity from momentum", [&] {
          velocity_from_momentum(ground, particles_to_grid.last());
        });
        chosen = choose_step_size(setting.method,
                                  setting.limits,
                                  setting.layout,
                                  ground.stencils,
                                  ground.points,
                                  *start->active,
                                  state.time);
      }
    solution.time_step = chosen.time_step;
    this->note_limit(chosen, solution.notes);
  }

  template <int dim>
  StepSize
  Stepper<dim>::size_in_middle()
  {
    // most rules know nothing of nodes, and a step begins with others
    if (const auto rule = setting.method.step_rule.constant())
      return limited_step_size(*rule,
                               setting.method,
                               setting.limits,
                               setting.layout,
                               gather(setting.method.shape_functions.places(
                                        state.particles, setting.grid),
                                      setting.layout),
                               state.time);
    const auto            ground = this->ground_at_start();
    const ActiveGrid<dim> active(ground.stencils,
                                 {},
                                 setting.grid,
                                 setting.boundary_conditions,
                                 ActiveGrid<dim>::Matrices::none);
    return choose_step_size(setting.method,
                            setting.limits,
                            setting.layout,
                            ground.stencils,
                            ground.points,
                            active,
                            state.time);
  }

  template <int dim>
  const ActiveGrid<dim> &
  Stepper<dim>::renew_grid(const Ground<dim> &ground)
  {
    const Balance<dim> &balance = setting.method.balance;
    balance.classify(ground.stencils,
                     ground.points,
                     setting.grid,
                     &setting.phases);
    start = &particles_to_grid(ground.stencils,
                               ground.points,
                               balance.couplings(ground.stencils,
                                                 setting.grid,
                                                 setting.boundary_conditions,
                                                 &setting.phases));
    return *start->active;
  }

  template <int dim>
  StepData<dim>
  Stepper<dim>::data_of(const Ground<dim>    &ground,
                        const GridStart<dim> &start,
                        const double          time_step) const
  {
    return {ground.stencils,
            ground.points,
            start,
            state.time,
            time_step,
            &setting.phases};
  }

  template <int dim>
  void
  Stepper<dim>::try_from_start(Solution &solution)
  {
    const Ground<dim>  &ground = *solution.at_start;
    const StepData<dim> step   = data_of(ground, *start, solution.time_step);
    solution.of_start          = timed("loads and matrices", [&] {
      return setting.method.balance.over(step);
    });
    solution.displacement      = start->mean_velocity;
    solution.displacement *= step.time_step;
    start->active->constraints().set_zero(solution.displacement);
    setting.method.balance.add_given_displacement(*start->active,
                                                  state.time,
                                                  step.time_step,
                                                  solution.displacement,
                                                  &setting.phases);
    start->active->constraints().expand(solution.displacement);
    solution.newton = Newton(solver_parameters, *linear_solver, setting.phases)
                        .solve(*solution.of_start, solution.displacement);
  }

  template <int dim>
  void
  Stepper<dim>::try_in_middle(Solution &solution)
  {
    const StepMethod<dim> &method = setting.method;
    // cells may be others afterwards, so nothing of before may be used
    solution.in_middle.reset();
    solution.at_start.reset();
    timed("grid to particles", [&] {
      method.middle->hand_over(solution.time_step,
                               setting.grid,
                               state.particles);
    });
    Places<dim> places =
      method.shape_functions.places(state.particles, setting.grid);
    {
      const PointArrays<dim> states =
        timed("gather", [&] { return gather(places, setting.layout); });
      places = method.middle->first(std::move(places),
                                    states,
                                    solution.time_step,
                                    method.domain_update,
                                    setting.grid);
    }
    const PlaceRules<dim> rules{method.shape_functions,
                                method.domain_update,
                                setting.grid,
                                setting.layout,
                                method.mapping};
    solution.in_middle = std::make_unique<MiddleEquation<dim>>(
      typename MiddleEquation<dim>::Start{rules,
                                          method.balance,
                                          setting.boundary_conditions,
                                          particles_to_grid,
                                          state.time,
                                          solution.time_step,
                                          method.geometry_tolerance,
                                          &setting.phases},
      std::move(places));
    solution.displacement = solution.in_middle->first_displacement();
    if (!linear_solver)
      linear_solver = make_linear_solver(solver_parameters,
                                         solution.displacement.size(),
                                         dim,
                                         &state.linear_solver,
                                         this->empty_pairs());
    solution.newton = Newton(solver_parameters, *linear_solver, setting.phases)
                        .solve(*solution.in_middle, solution.displacement);
    start = &solution.in_middle->grid_start();
    solution.equation().drop_jacobian(); // the map makes a matrix of its own
    timed("particles to grid", [&] {
      particles_to_grid.assemble_mass(solution.ground().stencils,
                                      solution.ground().points);
    });
    if (!solution.newton.is_converged)
      return;
    if (solution.in_middle->has_given_up() &&
        solution.in_middle->largest_defect() >
          setting.method.geometry_tolerance)
      tell_of_held_places(solution);
    timed("velocity from momentum", [&] {
      velocity_from_momentum(solution.ground(),
                             solution.in_middle->grid_start());
    });
    solution.equation().set_velocity_at_start();
  }

  template <int dim>
  void
  Stepper<dim>::velocity_from_momentum(const Ground<dim> &ground,
                                       GridStart<dim>    &start)
  {
    if (!linear_solver)
      linear_solver = make_linear_solver(solver_parameters,
                                         start.active->n_dofs(),
                                         dim,
                                         &state.linear_solver,
                                         this->empty_pairs());
    const LinearResult result = map_velocity(setting.method.balance,
                                             data_of(ground, start, 0.),
                                             *linear_solver,
                                             start);
    if (result.is_solved)
      return;
    const CutVerdict verdict = verdict_on(
      examined_mass(start), "mass matrix", ground, *start.active, setting);
    throw_together(setting.grid.communicator(),
                   where(),
                   "the velocity of the grid could not be found: " +
                     result.problem + verdict.text,
                   verdict.remedy +
                     "Use more Points per direction, or Solver/Linear "
                     "solver = direct.");
  }

  template <int dim>
  void
  Stepper<dim>::move(Solution &solution)
  {
    solution.velocity =
      velocity_new(solution.displacement, start->velocity, solution.time_step);
    const auto timed               = setting.phases.scope("accounts");
    const auto &[stencils, points] = solution.ground();
    const double           alpha   = setting.method.mapping.flip_fraction;
    const ActiveGrid<dim> &active  = *start->active;
    // v_p <- alpha v_p + sum S (v_new - alpha v_mapped)
    Vector change = solution.velocity;
    change.add(-alpha, setting.method.balance.velocity_map().mapped(*start));
    const std::string problem =
      agree_on_problem(setting.grid.communicator(),
                       move_points(stencils,
                                   points,
                                   active,
                                   setting.grid,
                                   setting.layout,
                                   alpha,
                                   active.to_local(solution.displacement),
                                   active.to_local(change),
                                   solution.equation().trial()));
    solution.leaves_grid = !problem.empty();
    if (!solution.leaves_grid)
      return;
    solution.newton.is_converged = false;
    solution.newton.problem      = problem;
  }

  template <int dim>
  void
  Stepper<dim>::follow(Solution &solution)
  {
    const ActiveGrid<dim> &active = *start->active;
    PointArrays<dim>      &trial  = solution.equation().trial();
    this->follow_domains(solution.ground(),
                         active,
                         active.to_local(solution.displacement),
                         trial,
                         solution.notes);
    if (setting.method.middle)
      setting.method.middle->leave(solution.ground().stencils,
                                   active,
                                   active.to_local(solution.velocity),
                                   trial);
  }

  template <int dim>
  StepReport
  Stepper<dim>::report(const Solution &solution)
  {
    const Ground<dim>       &ground   = solution.ground();
    const StepEquation<dim> &equation = solution.equation();
    StepReport               result =
      this->begin_report(solution.time_step, equation.trial());
    const double kinetic_energy =
      measure(ground.points, setting.layout, setting.grid.communicator())
        .kinetic_energy;
    result.kinetic_energy_change =
      result.totals.kinetic_energy - kinetic_energy;
    result.kinetic_energy_grid_old =
      0.5 * start->mass.matrix_norm_square(start->velocity);
    result.kinetic_energy_grid_new =
      0.5 * start->mass.matrix_norm_square(solution.velocity);
    result.energies          = equation.energies(solution.displacement);
    const StepAccounts books = accounts(
      data_of(ground, *start, solution.time_step),
      setting.method.balance,
      equation,
      setting.layout,
      setting.method.mapping,
      GridMotion{solution.displacement, solution.velocity, kinetic_energy});
    for (const EnergyEntry &entry : account_entries(books, setting.method))
      result.energies.push_back(entry);
    result.residual_work     = books.residual_work;
    result.newton_iterations = solution.newton.iterations;
    result.linear_iterations = solution.newton.linear_iterations;
    result.is_damped         = solution.newton.is_damped;
    result.notes             = solution.notes;
    if (solution.in_middle)
      {
        angular_momentum_left =
          solution.in_middle->angular_momentum_left(solution.displacement,
                                                    equation.trial());
        place_defect = solution.in_middle->largest_defect();
      }
    this->end_report(ground,
                     equation.trial(),
                     *start->active,
                     books.hidden_kinetic_energy,
                     result);
    result.halvings = solution.halvings;
    result.findings = solution.findings;
    return result;
  }

  template <int dim>
  std::vector<EnergyEntry>
  Stepper<dim>::energy_entries() const
  {
    const StepMethod<dim>   &method  = setting.method;
    std::vector<EnergyEntry> entries = method.balance.energy_entries();
    const StepAccounts       none    = empty_accounts(method.balance);
    for (const EnergyEntry &entry : account_entries(none, method))
      entries.push_back(entry);
    return entries;
  }

  template <int dim>
  void
  Stepper<dim>::tell_of_held_places(Solution &solution)
  {
    const std::string text =
      where() +
      ": the particles' places in the middle of the step do not "
      "settle and were held, " +
      brief(solution.in_middle->largest_defect()) +
      " cells from it; the ledger's angular_momentum_left has what that costs";
    solution.findings.push_back(text);
    if (!state.told.held_places)
      solution.notes.push_back(text + ". Later ones: run.log");
    state.told.held_places = true;
  }

  template <int dim>
  void
  Stepper<dim>::tell(Solution          &solution,
                     const std::string &for_screen,
                     const std::string &for_log)
  {
    solution.notes.push_back(where() + ": " + for_screen);
    solution.findings.push_back(where() + ": " + for_log);
    if (state.told.struggled || solution.leaves_grid)
      return;
    state.told.struggled = true;
    solution.notes.push_back("  why, and why later ones: run.log. " +
                             usual_remedy(setting));
  }

  template <int dim>
  std::vector<double>
  Stepper<dim>::nodal_mass() const
  {
    return lumped_mass(*start);
  }

  template class Stepper<2>;
  template class Stepper<3>;
} // namespace emmy
