#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/effects/inertia.h>
#include <emmy/effects/starved_nodes.h>
#include <emmy/step/stepper.h>
#include <emmy/step/velocity_map.h>

namespace emmy
{
  template <int dim>
  Stepper<dim>::Stepper(BackgroundGrid<dim>           &grid,
                        const BoundaryConditions<dim> &boundary_conditions,
                        const FieldLayout             &layout,
                        const StepMethod<dim>         &method,
                        const SolverParameters        &solver_parameters,
                        const TimeParameters          &time_parameters,
                        dealii::Particles::ParticleHandler<dim> &particles,
                        Phases                                  &phases)
    : grid(grid)
    , boundary_conditions(boundary_conditions)
    , layout(layout)
    , method(method)
    , solver_parameters(solver_parameters)
    , limits(time_parameters)
    , particles(particles)
    , phases(phases)
    , particles_to_grid(grid,
                        boundary_conditions,
                        layout,
                        method.mapping,
                        &phases)
    , domains(method.domain_update, grid, layout, phases)
    , detector({layout.has("half_length"),
                method.middle != nullptr,
                method.balance.has(starved_nodes_effect) ||
                  method.mapping.walls != PointMapping::Walls::constrained,
                method.mapping.flip_fraction < 1.})
  {}

  template <int dim>
  StepReport
  Stepper<dim>::advance()
  {
    // particles -> grid -> solve; as long as this fails, particles keep their
    // states
    Solution solution = solve();
    for (const std::string &finding : method.balance.findings())
      solution.findings.push_back(where() + ": " + finding);
    if (method.diagnosis.small_cuts)
      timed("diagnosis", [&] { examine(solution); });

    // grid -> particles
    const StepReport result = timed("accounts", [&] {
      follow(solution);
      return report(solution);
    });
    timed("grid to particles", [&] {
      grid_to_particles(solution.ground().stencils,
                        solution.equation().trial(),
                        layout,
                        grid,
                        particles);
    });
    count_points(solution.ground().points.n_points(),
                 solution.newton.residual_history.size());
    velocity    = std::move(solution.velocity);
    wall_travel = solution.wall_travel;
    time        = result.time;
    step_number = result.step;
    return result;
  }

  template <int dim>
  typename Stepper<dim>::Solution
  Stepper<dim>::solve()
  {
    Solution solution;
    choose_size(solution);
    for (unsigned int halvings = 0;; ++halvings, solution.time_step *= 0.5)
      {
        phases.begin_task(
          where() + (halvings == 0
                       ? std::string()
                       : ", halved " + std::to_string(halvings) + " times"));
        if (method.middle)
          try_in_middle(solution);
        else
          try_from_start(solution);
        if (solution.newton.is_converged)
          move(solution);
        if (solution.newton.is_converged)
          break;
        if (halvings == limits.maximum_halvings)
          give_up(solution.equation().data(), solution);
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
                          solution.equation().scale()) +
                    " of the forces"
                : std::string()));
    return solution;
  }

  template <int dim>
  void
  Stepper<dim>::choose_size(Solution &solution)
  {
    StepSize chosen;
    if (method.middle)
      chosen = size_in_middle();
    else
      {
        solution.at_start = std::make_unique<Ground<dim>>(ground_at_start());
        const auto &[stencils, points] = *solution.at_start;
        GridStart<dim> &at_start =
          timed("particles to grid", [&]() -> GridStart<dim> & {
            method.balance.classify(stencils, points, grid, &phases);
            return particles_to_grid(
              stencils,
              points,
              method.balance.couplings(
                stencils, grid, boundary_conditions, &phases));
          });
        start = &at_start;
        timed("velocity from momentum",
              [&] { velocity_from_momentum(stencils, points, at_start); });
        chosen = choose_step_size(
          method, limits, layout, stencils, points, *start->active, time);
      }
    solution.time_step = chosen.time_step;
    if (!chosen.note.empty() && !has_limited_travel)
      {
        has_limited_travel = true;
        solution.notes.push_back(where() + ": " + chosen.note);
      }
  }

  template <int dim>
  StepSize
  Stepper<dim>::size_in_middle()
  {
    // most rules know nothing of nodes, and a step begins with others
    if (const auto rule = method.step_rule.constant())
      return limited_step_size(
        *rule,
        method,
        limits,
        layout,
        gather(method.shape_functions.places(particles, grid), layout),
        time);
    const auto            ground = ground_at_start();
    const ActiveGrid<dim> active(ground.stencils,
                                 {},
                                 grid,
                                 boundary_conditions,
                                 ActiveGrid<dim>::Matrices::none);
    return choose_step_size(
      method, limits, layout, ground.stencils, ground.points, active, time);
  }

  template <int dim>
  Ground<dim>
  Stepper<dim>::ground_at_start()
  {
    Ground<dim> ground;
    ground.stencils = timed("stencils", [&] {
      return method.shape_functions.evaluate(particles, grid);
    });
    ground.points =
      timed("gather", [&] { return gather(ground.stencils, layout); });
    return ground;
  }

  template <int dim>
  void
  Stepper<dim>::try_from_start(Solution &solution)
  {
    const Ground<dim>  &ground = *solution.at_start;
    const StepData<dim> step{ground.stencils,
                             ground.points,
                             *start,
                             time,
                             solution.time_step,
                             &phases};
    solution.of_start =
      timed("loads and matrices", [&] { return method.balance.over(step); });
    solution.displacement = start->mean_velocity;
    solution.displacement *= step.time_step;
    start->active->constraints().set_zero(solution.displacement);
    if (boundary_conditions.has_moving_walls())
      {
        const auto timed = phases.effect(moving_walls_effect);
        solution.displacement +=
          start->active->on_walls(boundary_conditions, move_walls(solution));
      }
    start->active->constraints().expand(solution.displacement);
    solution.newton = Newton(solver_parameters, *linear_solver, phases)
                        .solve(*solution.of_start, solution.displacement);
  }

  template <int dim>
  void
  Stepper<dim>::try_in_middle(Solution &solution)
  {
    // cells may be others afterwards, so nothing of before may be used
    solution.in_middle.reset();
    solution.at_start.reset();
    timed("grid to particles", [&] {
      method.middle->hand_over(solution.time_step, grid, particles);
    });
    Places<dim>      places = method.shape_functions.places(particles, grid);
    PointArrays<dim> states =
      timed("gather", [&] { return gather(places, layout); });
    places = method.middle->first(std::move(places),
                                  states,
                                  solution.time_step,
                                  method.domain_update,
                                  grid);
    const PlaceRules<dim> rules{method.shape_functions,
                                method.domain_update,
                                grid,
                                layout,
                                method.mapping};
    solution.in_middle = std::make_unique<MiddleEquation<dim>>(
      typename MiddleEquation<dim>::Start{rules,
                                          method.balance,
                                          boundary_conditions,
                                          particles_to_grid,
                                          std::move(states),
                                          time,
                                          solution.time_step,
                                          method.geometry_tolerance,
                                          &phases},
      std::move(places));
    if (boundary_conditions.has_moving_walls())
      move_walls(solution);
    solution.displacement = solution.in_middle->first_displacement();
    if (!linear_solver)
      linear_solver = make_linear_solver(solver_parameters,
                                         solution.displacement.size(),
                                         dim);
    solution.newton = Newton(solver_parameters, *linear_solver, phases)
                        .solve(*solution.in_middle, solution.displacement);
    GridStart<dim> &middle = solution.in_middle->grid_start();
    start                  = &middle;
    timed("particles to grid", [&] {
      particles_to_grid.assemble_mass(solution.ground().stencils,
                                      solution.ground().points);
    });
    if (!solution.newton.is_converged)
      return;
    if (solution.in_middle->has_given_up())
      tell_of_held_places(solution);
    timed("velocity from momentum", [&] {
      velocity_from_momentum(solution.ground().stencils,
                             solution.ground().points,
                             middle);
    });
    solution.equation().set_velocity_at_start();
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
    if (!has_held_places)
      solution.notes.push_back(text + ". Later ones: run.log");
    has_held_places = true;
  }

  template <int dim>
  typename BoundaryConditions<dim>::Sides
  Stepper<dim>::move_walls(Solution &solution) const
  {
    const auto moved =
      boundary_conditions.wall_displacements(time, solution.time_step);
    for (unsigned int side = 0; side < 2 * dim; ++side)
      solution.wall_travel[side] = wall_travel[side] + moved[side];
    boundary_conditions.check_travel(solution.wall_travel, where());
    return moved;
  }

  template <int dim>
  void
  Stepper<dim>::tell(Solution          &solution,
                     const std::string &for_screen,
                     const std::string &for_log)
  {
    solution.notes.push_back(where() + ": " + for_screen);
    solution.findings.push_back(where() + ": " + for_log);
    if (has_struggled || solution.leaves_grid)
      return;
    has_struggled = true;
    solution.notes.push_back("  why, and why later ones: run.log. " + remedy());
  }

  template <int dim>
  std::string
  Stepper<dim>::remedy() const
  {
    std::vector<std::string> settings;
    if (!layout.has("half_length"))
      settings.push_back("Method/Shape functions = GIMP");
    if (!method.balance.has(starved_nodes_effect))
      settings.push_back("Method/Starved nodes = follow");
    return settings.empty()
             ? std::string()
             : "What helps most often: " + join(settings, " and ") + ". ";
  }

  template <int dim>
  void
  Stepper<dim>::give_up(const StepData<dim> &step, Solution &solution) const
  {
    throw_together(grid.communicator(),
                   where(),
                   solution.leaves_grid
                     ? solution.newton.problem + ", with the step halved " +
                         std::to_string(limits.maximum_halvings) +
                         " times to " + brief(step.time_step) + " s"
                     : std::string(),
                   "the last accepted state was kept. Enlarge the grid "
                   "(Grid/Lower corner, Upper corner), end the run earlier "
                   "(Time/End time), fix that side (Boundary conditions), or, "
                   "where it is a wall already, take smaller steps "
                   "(Time/Factor or Step size).");
    std::string verdict, cut_remedy;
    if (can_diagnose())
      {
        // What Newton left may be damped. Where the equation has no meaning
        // there is no derivative, but there is a mass.
        const bool has_jacobian =
          solution.equation().evaluate(solution.displacement,
                                       /*with_jacobian=*/true);
        const Diagnosis<dim> diagnosis =
          has_jacobian ? diagnose_matrix(undamped_jacobian(solution.equation(),
                                                           step.start,
                                                           step.time_step),
                                         step.stencils,
                                         step.points)
                       : diagnose_matrix(examined_mass(step.start),
                                         step.stencils,
                                         step.points);
        const double limit = method.diagnosis.report_above;
        verdict =
          "; " +
          diagnosis.verdict(has_jacobian ? "Jacobian" : "mass matrix", limit);
        if (diagnosis.is_above(limit) && !diagnosis.nodes.empty())
          cut_remedy = small_cut_remedy(method.balance, method.mapping);
      }
    throw_together(
      grid.communicator(),
      where(),
      "Newton does not converge, with the step halved " +
        std::to_string(limits.maximum_halvings) + " times to " +
        brief(step.time_step) + " s: " + solution.newton.problem + verdict,
      "the last accepted state was kept. " + remedy() + cut_remedy +
        "Use more Points per direction, a larger Solver/Maximum iterations, a "
        "smaller Time/Factor or Step size, or a stiffer or finer model; "
        "Time/Maximum halvings allows smaller steps.");
  }

  template <int dim>
  bool
  Stepper<dim>::can_diagnose() const
  {
    return start->active->n_dofs() <= largest_direct_size(dim);
  }

  template <int dim>
  Diagnosis<dim>
  Stepper<dim>::diagnose_matrix(const Matrix           &matrix,
                                const Stencils<dim>    &stencils,
                                const PointArrays<dim> &points) const
  {
    return diagnose(matrix, stencils, points, layout, *start->active);
  }

  template <int dim>
  void
  Stepper<dim>::examine(Solution &solution)
  {
    const auto &[stencils, points] = solution.ground();
    findings                       = std::make_unique<StepDiagnosis<dim>>();
    // Newton's last evaluation may have made no matrix
    solution.equation().evaluate(solution.displacement, /*with_jacobian=*/true);
    if (method.middle)
      solution.equation().set_velocity_at_start();
    *findings = {diagnose_matrix(examined_mass(*start), stencils, points),
                 diagnose_matrix(undamped_jacobian(solution.equation(),
                                                   *start,
                                                   solution.time_step),
                                 stencils,
                                 points)};
    for (const auto &[name, diagnosis] :
         {std::make_pair("mass matrix", &findings->mass),
          std::make_pair("Jacobian", &findings->jacobian)})
      if (diagnosis->is_above(method.diagnosis.report_above))
        solution.findings.push_back(where() + ": " + diagnosis->text(name));
  }

  template <int dim>
  void
  Stepper<dim>::add_measures(const PointArrays<dim>   &points,
                             const double              time,
                             std::vector<StepMeasure> &measures) const
  {
    if (method.diagnosis.small_cuts)
      {
        measures.push_back(
          {"mass_condition", findings ? findings->mass.condition : 0.});
        measures.push_back(
          {"jacobian_condition", findings ? findings->jacobian.condition : 0.});
      }
    for (StepMeasure &measure :
         method.balance.measures(points, time, grid, &phases))
      measures.push_back(std::move(measure));
  }

  template <int dim>
  void
  Stepper<dim>::move(Solution &solution)
  {
    solution.velocity =
      velocity_new(solution.displacement, start->velocity, solution.time_step);
    const auto timed               = phases.scope("accounts");
    const auto &[stencils, points] = solution.ground();
    const std::string problem =
      agree_on_problem(grid.communicator(),
                       move_points(stencils,
                                   points,
                                   *start,
                                   grid,
                                   layout,
                                   method.mapping.flip_fraction,
                                   solution.displacement,
                                   solution.velocity,
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
    const auto &[stencils, points] = solution.ground();
    PointArrays<dim> &trial        = solution.equation().trial();
    const std::string note =
      domains.follow(stencils,
                     points,
                     *start->active,
                     start->active->to_local(solution.displacement),
                     where(),
                     trial);
    if (!note.empty())
      solution.notes.push_back(note);
    if (method.middle)
      method.middle->leave(stencils,
                           *start->active,
                           start->active->to_local(solution.velocity),
                           trial);
  }

  template <int dim>
  std::string
  Stepper<dim>::where() const
  {
    return step_name(step_number + 1, time);
  }

  template <int dim>
  void
  Stepper<dim>::count_points(const std::size_t n_points,
                             const std::size_t n_evaluations)
  {
    for (const char *phase :
         {"stencils", "gather", "particles to grid", "grid to particles"})
      phases.add_count(phase, n_points);
    phases.add_count("residual and tangent", n_points * n_evaluations);
  }

  template <int dim>
  void
  Stepper<dim>::velocity_from_momentum(const Stencils<dim>    &stencils,
                                       const PointArrays<dim> &points,
                                       GridStart<dim>         &start)
  {
    if (!linear_solver)
      linear_solver =
        make_linear_solver(solver_parameters, start.active->n_dofs(), dim);
    Vector wall_velocity = start.active->make_vector();
    if (boundary_conditions.has_moving_walls())
      {
        const auto timed = phases.effect(moving_walls_effect);
        wall_velocity =
          start.active->on_walls(boundary_conditions,
                                 boundary_conditions.wall_velocities(time));
      }
    const LinearResult result = map_velocity(
      method.mapping, wall_velocity, *linear_solver, start, &phases);
    if (result.is_solved)
      return;
    std::string verdict, remedy;
    if (can_diagnose())
      {
        const Diagnosis<dim> diagnosis =
          diagnose_matrix(examined_mass(start), stencils, points);
        const double limit = method.diagnosis.report_above;
        verdict            = "; " + diagnosis.verdict("mass matrix", limit);
        if (diagnosis.is_above(limit) && !diagnosis.nodes.empty())
          remedy = small_cut_remedy(method.balance, method.mapping);
      }
    throw_together(grid.communicator(),
                   where(),
                   "the velocity of the grid could not be found: " +
                     result.problem + verdict,
                   remedy + "Use more Points per direction, or Solver/Linear "
                            "solver = direct.");
  }

  template <int dim>
  StepReport
  Stepper<dim>::initial_report()
  {
    const auto &[stencils, points] = ground_at_start();
    method.balance.classify(stencils, points, grid, &phases);
    start = &particles_to_grid(
      stencils,
      points,
      method.balance.couplings(stencils, grid, boundary_conditions, &phases));

    StepReport result;
    result.time_step =
      choose_step_size(
        method, limits, layout, stencils, points, *start->active, time)
        .time_step;
    result.totals   = measure(points, layout, grid.communicator());
    result.energies = method.balance.energy_entries();
    StepAccounts no_accounts;
    no_accounts.mass_losses = method.balance.mass_loss_entries();
    for (const EnergyEntry &entry : account_entries(no_accounts))
      result.energies.push_back(entry);
    detector.begin(
      overfill(stencils, points, points, layout, *start->active, grid), result);
    add_measures(points, time, result.measures);
    if (method.middle)
      add_geometry_measures(Solution(), result.measures);
    result.active_cells =
      dealii::Utilities::MPI::sum(static_cast<std::uint64_t>(
                                    start->active->cells().size()),
                                  grid.communicator());
    result.active_dofs = start->active->n_dofs();
    return result;
  }

  template <int dim>
  StepReport
  Stepper<dim>::report(const Solution &solution)
  {
    const auto &[stencils, points]    = solution.ground();
    const StepEquation<dim> &equation = solution.equation();
    StepReport               result;
    result.step      = step_number + 1;
    result.time_step = solution.time_step;
    result.time      = time + solution.time_step;
    result.totals    = measure(equation.trial(), layout, grid.communicator());
    const double kinetic_energy =
      measure(points, layout, grid.communicator()).kinetic_energy;
    result.kinetic_energy_change =
      result.totals.kinetic_energy - kinetic_energy;
    result.kinetic_energy_grid_old =
      0.5 * start->mass.matrix_norm_square(start->velocity);
    result.kinetic_energy_grid_new =
      0.5 * start->mass.matrix_norm_square(solution.velocity);
    result.energies          = equation.energies(solution.displacement);
    const StepAccounts books = accounts(
      StepData<dim>{
        stencils, points, *start, time, solution.time_step, &phases},
      method.balance,
      equation,
      layout,
      method.mapping,
      solution.displacement,
      solution.velocity,
      kinetic_energy);
    for (const EnergyEntry &entry : account_entries(books))
      result.energies.push_back(entry);
    result.residual_work     = books.residual_work;
    result.newton_iterations = solution.newton.iterations;
    result.linear_iterations = solution.newton.linear_iterations;
    result.active_cells =
      dealii::Utilities::MPI::sum(static_cast<std::uint64_t>(
                                    start->active->cells().size()),
                                  grid.communicator());
    result.active_dofs = start->active->n_dofs();
    result.is_damped   = solution.newton.is_damped;
    result.notes       = solution.notes;
    detector.look(
      books.hidden_kinetic_energy,
      overfill(
        stencils, points, equation.trial(), layout, *start->active, grid),
      where(),
      result);
    add_measures(equation.trial(), result.time, result.measures);
    if (method.middle)
      add_geometry_measures(solution, result.measures);
    result.halvings = solution.halvings;
    result.findings = solution.findings;
    return result;
  }

  template <int dim>
  void
  Stepper<dim>::add_geometry_measures(const Solution           &solution,
                                      std::vector<StepMeasure> &measures) const
  {
    std::array<double, 4> left{}; // angular momentum x, y, z; cells
    if (solution.in_middle)
      {
        const dealii::Tensor<1, 3> J =
          solution.in_middle->angular_momentum_left(
            solution.displacement, solution.equation().trial());
        for (unsigned int d = 0; d < 3; ++d)
          left[d] = J[d];
        left[3] = solution.in_middle->largest_defect();
      }
    for (unsigned int d = dim == 2 ? 2 : 0; d < 3; ++d)
      measures.push_back(
        {std::string("angular_momentum_left_") + "xyz"[d], left[d]});
    measures.push_back({"place_defect", left[3]});
  }

  template <int dim>
  std::vector<EnergyEntry>
  Stepper<dim>::account_entries(const StepAccounts &accounts) const
  {
    return emmy::account_entries(accounts,
                                 method.mapping,
                                 boundary_conditions.has_moving_walls());
  }

  template <int dim>
  std::string
  Stepper<dim>::solver_name() const
  {
    return linear_solver ? linear_solver->name() : "none yet";
  }

  template <int dim>
  const GridStart<dim> &
  Stepper<dim>::grid_start() const
  {
    return *start;
  }

  template <int dim>
  const Vector &
  Stepper<dim>::grid_velocity() const
  {
    return velocity;
  }

  template <int dim>
  std::vector<double>
  Stepper<dim>::nodal_mass() const
  {
    // row sums of the mass matrix
    Vector ones = start->active->make_vector(), sums = ones;
    ones = 1.;
    start->mass.vmult(sums, ones);
    const std::vector<double> local = start->active->to_local(sums);
    std::vector<double>       result(start->active->n_local_nodes());
    for (unsigned int node = 0; node < result.size(); ++node)
      result[node] = local[dim * node];
    return result;
  }

  template <int dim>
  const StepDiagnosis<dim> *
  Stepper<dim>::diagnosis() const
  {
    return findings.get();
  }

  template class Stepper<2>;
  template class Stepper<3>;
} // namespace emmy
