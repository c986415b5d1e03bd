#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/step/accounts.h>
#include <emmy/step/failure.h>
#include <emmy/step/static_stepper.h>
#include <emmy/transfer/grid_to_particles.h>

#include <algorithm>

namespace emmy
{
  namespace
  {
    constexpr const char *imbalance_work = "imbalance_work";

    /** What may be out of balance at the end, of the forces: below what Newton
     * counts as round-off, so that steps in time see a body at rest. */
    constexpr double settled = 5e-13;
    /** How often the loads are held for that. */
    constexpr unsigned int most_rounds = 25;

    /**
     * The rigid motions that fixed unknowns hold: sum of m m^T over them, with
     * m the values of the motions there; scaled with @p size, m. Collective.
     */
    template <int dim>
    dealii::Tensor<2, (dim == 2 ? 3 : 6)>
    held_motions(const ActiveGrid<dim>         &active,
                 const BoundaryConditions<dim> &boundary_conditions,
                 const dealii::Point<dim>      &centre,
                 const double                   size)
    {
      constexpr int        n = dim == 2 ? 3 : 6;
      dealii::Tensor<2, n> result;
      for (unsigned int node = 0; node < active.n_owned_nodes(); ++node)
        {
          const auto x = (active.position(node) - centre) / size;
          const auto fixed =
            boundary_conditions.fixed_components(active.position(node));
          for (unsigned int c = 0; c < dim; ++c)
            if (fixed[c])
              {
                dealii::Tensor<1, n> m;
                m[c] = 1.;
                if (dim == 2)
                  m[2] = c == 0 ? -x[1] : x[0];
                else // e_a x (x), component c
                  for (unsigned int a = 0; a < 3; ++a)
                    if (a != c)
                      m[dim + a] =
                        ((a + 1) % 3 == (c + 2) % 3 ? 1. : -1.) * x[3 - a - c];
                result += outer_product(m, m);
              }
        }
      dealii::Tensor<2, n> sum;
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
          sum[i][j] =
            dealii::Utilities::MPI::sum(result[i][j], active.communicator());
      return sum;
    }

    /** The number of motions that are held: rank by elimination. */
    template <int n>
    unsigned int
    rank_of(dealii::Tensor<2, n> a)
    {
      double largest = 0.;
      for (unsigned int i = 0; i < n; ++i)
        largest = std::max(largest, a[i][i]);
      unsigned int rank = 0;
      for (unsigned int step = 0; step < n; ++step)
        {
          unsigned int pivot = 0;
          for (unsigned int i = 1; i < n; ++i)
            if (a[i][i] > a[pivot][pivot])
              pivot = i;
          if (!(a[pivot][pivot] > 1e-9 * largest))
            break;
          ++rank;
          const auto row = a[pivot];
          a -= outer_product(row, row) / row[pivot];
        }
      return rank;
    }
  } // namespace

  EffectCard
  static_card(const bool is_present)
  {
    EffectCard card;
    card.name           = "static steps";
    card.setting        = "Time/Integrator = static";
    card.enters         = "Newton: no inertia, loads are raised";
    card.ledger_columns = {imbalance_work};
    card.is_present     = is_present;
    return card;
  }

  template <int dim>
  StaticStepper<dim>::StaticStepper(const StepSetting<dim> &setting,
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
  StaticStepper<dim>::advance()
  {
    failure              = {};
    const auto increment = raise_loads();
    StepReport report    = accept_increment(*increment, increment->time_step);
    report.halvings      = increment->halvings;
    if (report.time >= setting.limits.end_time * (1. - 1e-12))
      settle(report);
    return report;
  }

  template <int dim>
  double
  StaticStepper<dim>::factor_at(const double time) const
  {
    return std::min(1., time / setting.limits.end_time);
  }

  template <int dim>
  const ActiveGrid<dim> &
  StaticStepper<dim>::renew_grid(const Ground<dim> &ground)
  {
    const Balance<dim> &balance = setting.method.balance;
    balance.classify(ground.stencils,
                     ground.points,
                     setting.grid,
                     &setting.phases);
    start                = &particles_to_grid(ground.stencils,
                               ground.points,
                               balance.couplings(ground.stencils,
                                                 setting.grid,
                                                 setting.boundary_conditions,
                                                 &setting.phases));
    start->velocity      = start->active->make_vector();
    start->mean_velocity = start->velocity;
    return *start->active;
  }

  template <int dim>
  std::unique_ptr<typename StaticStepper<dim>::Increment>
  StaticStepper<dim>::begin()
  {
    auto increment    = std::make_unique<Increment>();
    increment->ground = this->ground_at_start();
    increment->time   = state.time;
    this->timed("particles to grid", [&] { renew_grid(increment->ground); });
    increment->ramp.names = setting.limits.raised_loads;
    if (!linear_solver)
      linear_solver = make_linear_solver(solver_parameters,
                                         start->active->n_dofs(),
                                         dim,
                                         &state.linear_solver,
                                         this->empty_pairs());
    return increment;
  }

  template <int dim>
  void
  StaticStepper<dim>::refuse_what_moves(const Increment &increment) const
  {
    const ActiveGrid<dim> &active = *start->active;
    AssertThrow(measure(increment.ground.points,
                        setting.layout,
                        active.communicator())
                    .kinetic_energy == 0.,
                ExcRun(where(),
                       "the bodies move, but static steps know no velocity",
                       "remove their Initial velocity, let the run that this "
                       "one starts from come to rest, or set Time/Integrator = "
                       "implicit."));
    const auto lower            = setting.grid.lower_corner(),
               upper            = setting.grid.upper_corner();
    const auto             held = held_motions<dim>(active,
                                        setting.boundary_conditions,
                                        lower + 0.5 * (upper - lower),
                                        lower.distance(upper));
    constexpr unsigned int n    = dim == 2 ? 3 : 6;
    std::string            free;
    for (unsigned int c = 0; c < dim; ++c)
      if (held[c][c] == 0.)
        free += std::string(free.empty() ? "" : " and ") + "xyz"[c];
    AssertThrow(rank_of<n>(held) == n,
                ExcRun(where(),
                       free.empty() ? "nothing keeps the bodies from turning"
                                    : "nothing holds the bodies along " + free,
                       "static steps look for the place where forces balance, "
                       "and what can move as a whole has none. Make a side "
                       "that the bodies touch fixed or roller (section "
                       "Boundary conditions), or set Time/Integrator = "
                       "implicit."));
  }

  template <int dim>
  bool
  StaticStepper<dim>::prepare(Increment   &increment,
                              const double from,
                              const double to,
                              const double time_step)
  {
    const Balance<dim>    &balance = setting.method.balance;
    const ActiveGrid<dim> &active  = *start->active;
    increment.time_step            = time_step;
    const StepData<dim> step{increment.ground.stencils,
                             increment.ground.points,
                             *start,
                             increment.time,
                             time_step,
                             &setting.phases,
                             nullptr,
                             &increment.ramp};
    increment.load_before = active.make_vector();
    increment.ramp.factor = from;
    if (balance.has_loads())
      active.add(balance.loads(step), increment.load_before);
    increment.ramp.factor = to;
    increment.equation =
      this->timed("loads and matrices", [&] { return balance.over(step); });
    increment.displacement = active.make_vector();
    if (!increment.equation->evaluate(increment.displacement, false))
      {
        increment.newton.problem = increment.equation->problem();
        return false;
      }
    // of the load that was balanced before
    increment.residual_before = increment.equation->unconstrained_residual();
    increment.residual_before += increment.equation->load();
    increment.residual_before -= increment.load_before;
    return true;
  }

  template <int dim>
  void
  StaticStepper<dim>::solve(Increment &increment)
  {
    const ActiveGrid<dim> &active = *start->active;
    active.constraints().set_zero(increment.displacement);
    if (!increment.is_held)
      setting.method.balance.add_given_displacement(active,
                                                    state.time,
                                                    increment.time_step,
                                                    increment.displacement,
                                                    &setting.phases);
    active.constraints().expand(increment.displacement);
    increment.newton = Newton(solver_parameters, *linear_solver, setting.phases)
                         .solve(*increment.equation, increment.displacement);
    if (!increment.newton.is_converged)
      return;
    const auto        local = active.to_local(increment.displacement);
    const std::string problem =
      agree_on_problem(setting.grid.communicator(),
                       move_points(increment.ground.stencils,
                                   increment.ground.points,
                                   active,
                                   setting.grid,
                                   setting.layout,
                                   /*flip_fraction=*/1.,
                                   local,
                                   std::vector<double>(local.size()),
                                   increment.equation->trial()));
    increment.leaves_grid = !problem.empty();
    if (increment.leaves_grid)
      {
        increment.newton.is_converged = false;
        increment.newton.problem      = problem;
      }
  }

  template <int dim>
  std::unique_ptr<typename StaticStepper<dim>::Increment>
  StaticStepper<dim>::raise_loads()
  {
    const double usual = setting.limits.end_time / setting.limits.increments;
    if (state.increment == 0.)
      state.increment = usual;
    auto increment = begin();
    refuse_what_moves(*increment);
    // what is left of round-off belongs to the last one
    const double left      = setting.limits.end_time - state.time;
    double       time_step = std::min(state.increment, left);
    if (left - time_step < 1e-6 * usual)
      time_step = left;
    for (;; time_step *= 0.5)
      {
        setting.phases.begin_task(where());
        setting.method.balance.check_step(state.time, time_step, where());
        if (prepare(*increment,
                    factor_at(state.time),
                    factor_at(state.time + time_step),
                    time_step))
          solve(*increment);
        if (increment->newton.is_converged)
          break;
        failure.tries.push_back({time_step,
                                 increment->newton.residual_history,
                                 increment->newton.problem});
        if (increment->halvings == setting.limits.maximum_halvings)
          give_up(FailedStep<dim>{increment->ground,
                                  *start,
                                  *increment->equation,
                                  increment->displacement,
                                  increment->leaves_grid},
                  setting,
                  where(),
                  failure);
        ++increment->halvings;
      }
    state.increment = increment->halvings > 0
                        ? time_step
                        : std::min(usual, 2. * state.increment);
    return increment;
  }

  template <int dim>
  StepReport
  StaticStepper<dim>::accept_increment(Increment   &increment,
                                       const double passed)
  {
    const auto               scope    = setting.phases.scope("accounts");
    const ActiveGrid<dim>   &active   = *start->active;
    StepEquation<dim>       &equation = *increment.equation;
    const Vector            &u        = increment.displacement;
    std::vector<std::string> notes;
    this->follow_domains(
      increment.ground, active, active.to_local(u), equation.trial(), notes);
    StepReport report = this->begin_report(passed, equation.trial());
    report.notes      = notes;

    // forces on unknowns that are fixed, and on the others, at both ends
    const auto before =
      free_and_fixed(active.constraints(), increment.residual_before);
    const auto after =
      free_and_fixed(active.constraints(), equation.unconstrained_residual());
    setting.method.balance.see_reactions(active, after.second);
    const double load_change = increment.load_before * u - equation.load() * u;
    const double imbalance   = 0.5 * (before.first * u - after.first * u);
    const double reaction_change = before.second * u - after.second * u;
    report.energies              = equation.energies(u);
    for (EnergyEntry &entry : report.energies)
      {
        if (entry.name == "load_work")
          entry.change += 0.5 * load_change;
        if (entry.name == "stress_rule_loss")
          entry.change += 0.5 * (load_change + reaction_change) + imbalance;
      }
    StepAccounts books  = empty_accounts(setting.method.balance);
    books.reaction_work = after.second * u + 0.5 * reaction_change;
    for (const EnergyEntry &entry : account_entries(books, setting.method))
      report.energies.push_back(entry);
    report.energies.push_back(
      {imbalance_work, EnergyEntry::Kind::work, imbalance});
    report.residual_work     = equation.residual() * u;
    report.newton_iterations = increment.newton.iterations;
    report.linear_iterations = increment.newton.linear_iterations;
    report.is_damped         = increment.newton.is_damped;
    this->end_report(
      increment.ground, equation.trial(), active, /*hidden=*/0., report);
    this->accept(increment.ground, equation.trial(), report);
    return report;
  }

  template <int dim>
  void
  StaticStepper<dim>::settle(StepReport &report)
  {
    const unsigned int number = report.step;
    double             left   = 0.;
    unsigned int       rounds = 0;
    for (;; ++rounds)
      {
        const auto increment = begin();
        increment->time -= report.time_step; // amplitudes of the last increment
        if (!prepare(*increment, 1., 1., report.time_step))
          break;
        StepEquation<dim> &equation = *increment->equation;
        left = equation.residual().l2_norm() / equation.system().scale;
        if (!(left > settled) || rounds == most_rounds)
          break;
        increment->is_held = true;
        solve(*increment);
        if (!increment->newton.is_converged)
          break;
        state.step            = number - 1;
        const StepReport next = accept_increment(*increment, 0.);
        report.totals         = next.totals;
        report.measures       = next.measures;
        report.active_cells   = next.active_cells;
        report.active_dofs    = next.active_dofs;
        for (unsigned int i = 0; i < report.energies.size(); ++i)
          report.energies[i].change += next.energies[i].change;
        report.residual_work += next.residual_work;
        report.linear_iterations += next.linear_iterations;
      }
    report.findings.push_back("The loads were held for " +
                              std::to_string(rounds) +
                              " more solves; what is left out of balance is " +
                              brief(left) + " of the forces");
    if (left > 1e-6)
      report.notes.push_back(
        "the end is out of balance by " + brief(left) +
        " of the forces: a run that starts from it will not be at rest");
  }

  template <int dim>
  std::vector<EnergyEntry>
  StaticStepper<dim>::energy_entries() const
  {
    const StepMethod<dim>   &method  = setting.method;
    std::vector<EnergyEntry> entries = method.balance.energy_entries();
    const StepAccounts       none    = empty_accounts(method.balance);
    for (const EnergyEntry &entry : account_entries(none, method))
      entries.push_back(entry);
    entries.push_back({imbalance_work, EnergyEntry::Kind::work, 0.});
    return entries;
  }

  template <int dim>
  std::vector<double>
  StaticStepper<dim>::nodal_mass() const
  {
    return lumped_mass(*start);
  }

  template class StaticStepper<2>;
  template class StaticStepper<3>;
} // namespace emmy
