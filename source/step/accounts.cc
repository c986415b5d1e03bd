#include <emmy/step/accounts.h>

namespace emmy
{
  namespace
  {
    /** Works of residuals and walls, and the loss of inelastic walls. */
    template <int dim>
    void
    add_works(const GridStart<dim>    &start,
              const StepEquation<dim> &equation,
              const PointMapping      &mapping,
              const Vector            &displacement,
              const Vector            &velocity_new,
              StepAccounts            &result)
    {
      // a vector's part on free unknowns, and that on fixed ones; followers
      // have handed theirs over
      const auto split = [&start](Vector vector) {
        const Constraints &constraints = start.active->constraints();
        constraints.fold(vector);
        std::pair<Vector, Vector> parts(vector, vector);
        constraints.set_zero(parts.first);
        parts.second -= parts.first;
        return parts;
      };
      const auto misfit_of = [&start](const Vector &velocity) {
        Vector misfit = start.momentum;
        start.mass.residual(misfit, velocity, start.momentum);
        return misfit;
      };

      result.residual_work = equation.residual() * displacement;
      result.reaction_work =
        split(equation.unconstrained_residual()).second * displacement;

      Vector change = velocity_new;
      change -= start.mapped_velocity;
      Vector misfit = misfit_of(start.mapped_velocity);
      // v.M~ v / 2 - v.p, with M~ v = p - misfit
      result.hidden_kinetic_energy =
        -0.5 * (start.mapped_velocity * start.momentum +
                start.mapped_velocity * misfit);
      switch (mapping.walls)
        {
          case PointMapping::Walls::constrained:
            {
              // what the map leaves on fixed unknowns is the walls' impulse
              const auto [free, fixed] = split(misfit);
              result.residual_work += free * change;
              result.reaction_work += fixed * change;
              break;
            }
          case PointMapping::Walls::unconstrained:
            result.residual_work += misfit * change;
            break;
          case PointMapping::Walls::inelastic:
            {
              result.residual_work += misfit * change;
              // M~ w is the impulse with which the walls stop the grid
              Vector impulse = misfit_of(start.velocity);
              impulse -= misfit;
              Vector stopped = start.mapped_velocity;
              stopped -= start.velocity;
              const auto [free, fixed] = split(impulse);
              result.wall_loss         = 0.5 * (stopped * impulse);
              result.residual_work -= start.velocity * free;
              result.reaction_work -= start.velocity * fixed;
              break;
            }
        }
    }
  } // namespace

  std::vector<EffectCard>
  account_cards(const PointMapping &mapping, const bool has_moving_walls)
  {
    using Walls = PointMapping::Walls;
    std::vector<EffectCard> cards(5);
    EffectCard &lumping = cards[0], &pic = cards[1], &inelastic = cards[2],
               &unconstrained = cards[3], &moving = cards[4];

    lumping.name           = lumping_effect;
    lumping.setting        = "Method/Lumping above 0";
    lumping.enters         = "particles to grid: mass; accounts: a pass over "
                             "the particles for its loss";
    lumping.ledger_columns = {"lumping_loss"};
    lumping.is_present     = mapping.lumping > 0.;

    pic.name           = pic_effect;
    pic.setting        = "Method/Mapping = PIC or blend";
    pic.enters         = "grid to particles: velocity; accounts: a pass over "
                         "the particles for its loss";
    pic.ledger_columns = {"mapping_loss"};
    pic.is_present     = mapping.flip_fraction < 1.;

    inelastic.name           = inelastic_walls_effect;
    inelastic.setting        = "Method/Wall mapping = inelastic";
    inelastic.enters         = "velocity from momentum: a second solve, with "
                               "one more mass matrix";
    inelastic.ledger_columns = {"wall_loss"};
    inelastic.is_present     = mapping.walls == Walls::inelastic;

    unconstrained.name       = unconstrained_walls_effect;
    unconstrained.setting    = "Method/Wall mapping = unconstrained";
    unconstrained.enters     = "velocity from momentum: one more mass matrix";
    unconstrained.is_present = mapping.walls == Walls::unconstrained;

    moving.name           = moving_walls_effect;
    moving.setting        = "Boundary conditions/Velocity of a side";
    moving.enters         = "velocity from momentum, Newton: given values";
    moving.ledger_columns = {"reaction_work"};
    moving.is_present     = has_moving_walls;
    return cards;
  }

  std::vector<EnergyEntry>
  account_entries(const StepAccounts &accounts,
                  const PointMapping &mapping,
                  const bool          has_moving_walls)
  {
    using Kind = EnergyEntry::Kind;
    std::vector<EnergyEntry> entries;
    if (has_moving_walls)
      entries.push_back({"reaction_work", Kind::work, accounts.reaction_work});
    if (mapping.lumping > 0.)
      entries.push_back(
        {"lumping_loss", Kind::dissipated, accounts.lumping_loss});
    if (mapping.flip_fraction < 1.)
      entries.push_back(
        {"mapping_loss", Kind::dissipated, accounts.mapping_loss});
    for (const EnergyEntry &loss : accounts.mass_losses)
      entries.push_back(loss);
    if (mapping.walls == PointMapping::Walls::inelastic)
      entries.push_back({"wall_loss", Kind::dissipated, accounts.wall_loss});
    return entries;
  }

  template <int dim>
  void
  add_mapping_losses(const StepData<dim>       &step,
                     const FieldLayout         &layout,
                     const PointMapping        &mapping,
                     const std::vector<double> &v_mapped,
                     const std::vector<double> &v_new,
                     StepAccounts              &result)
  {
    const GridStart<dim> &start    = step.start;
    const double         *mass     = step.points.component(layout["mass"]);
    const unsigned int    velocity = layout["velocity"];
    const double          alpha    = mapping.flip_fraction;

    double lumping = 0., pic = 0., hidden = 0.;
    for (const auto &group : step.stencils.groups)
      for (unsigned int q = 0; q < group.n_points; ++q)
        {
          const std::size_t      p = group.first_point + q;
          dealii::Tensor<1, dim> change, w, d;
          double                 mean_square = 0.;
          for (unsigned int c = 0; c < dim; ++c)
            d[c] = step.points.component(velocity + c)[p];
          for (unsigned int a = 0; a < group.n_nodes; ++a)
            {
              const double       S    = step.stencils.value(group, a)[q];
              const unsigned int node = start.active->nodes(group)[a];
              for (unsigned int c = 0; c < dim; ++c)
                {
                  const double v0 = v_mapped[dim * node + c],
                               v1 = v_new[dim * node + c];
                  change[c] += S * (v1 - v0);
                  mean_square += S * (v1 - v0) * (v1 - v0);
                  w[c] += S * v1;
                  d[c] -= S * v0;
                }
            }
          lumping += mass[p] * (mean_square - change.norm_square());
          hidden += 0.5 * mass[p] * d.norm_square();
          pic += mass[p] * (w * d + 0.5 * (1. + alpha) * d.norm_square());
        }
    const MPI_Comm communicator = start.active->communicator();
    result.lumping_loss         = 0.5 * mapping.lumping *
                          dealii::Utilities::MPI::sum(lumping, communicator);
    result.mapping_loss =
      (1. - alpha) * dealii::Utilities::MPI::sum(pic, communicator);
    result.hidden_kinetic_energy =
      dealii::Utilities::MPI::sum(hidden, communicator);
  }

  template <int dim>
  StepAccounts
  accounts(const StepData<dim>     &step,
           const Balance<dim>      &balance,
           const StepEquation<dim> &equation,
           const FieldLayout       &layout,
           const PointMapping      &mapping,
           const GridMotion        &motion)
  {
    StepAccounts result;
    add_works(step.start,
              equation,
              mapping,
              motion.displacement,
              motion.velocity,
              result);
    result.hidden_kinetic_energy += motion.kinetic_energy;
    const bool has_losses = mapping.lumping > 0. || mapping.flip_fraction < 1.;
    if (has_losses)
      {
        // one pass for both; where both are there, PIC pays
        const auto timed =
          effect_scope(step.phases,
                       mapping.flip_fraction < 1. ? pic_effect
                                                  : lumping_effect);
        const ActiveGrid<dim> &active = *step.start.active;
        add_mapping_losses(step,
                           layout,
                           mapping,
                           active.to_local(step.start.mapped_velocity),
                           active.to_local(motion.velocity),
                           result);
      }
    Vector change = motion.velocity;
    change -= step.start.mapped_velocity;
    result.mass_losses =
      balance.mass_losses(*step.start.active, change, step.phases);
    if (!has_losses) // M~ has masses that no particle carries
      for (const EnergyEntry &hidden : balance.mass_losses(
             *step.start.active, step.start.mapped_velocity, step.phases))
        result.hidden_kinetic_energy -= hidden.change;
    return result;
  }

#define INSTANTIATE(dim)                                             \
  template void add_mapping_losses<dim>(const StepData<dim> &,       \
                                        const FieldLayout &,         \
                                        const PointMapping &,        \
                                        const std::vector<double> &, \
                                        const std::vector<double> &, \
                                        StepAccounts &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
  template StepAccounts
  accounts<2>(const StepData<2> &,
              const Balance<2> &,
              const StepEquation<2> &,
              const FieldLayout &,
              const PointMapping &,
              const GridMotion &);
  template StepAccounts
  accounts<3>(const StepData<3> &,
              const Balance<3> &,
              const StepEquation<3> &,
              const FieldLayout &,
              const PointMapping &,
              const GridMotion &);
} // namespace emmy
