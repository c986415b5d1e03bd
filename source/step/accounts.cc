#include <emmy/step/accounts.h>

namespace emmy
{
  namespace
  {
    /** Works of residuals, of what holds unknowns, and losses of the map. */
    template <int dim>
    void
    add_works(const StepData<dim>     &step,
              const StepEquation<dim> &equation,
              const Balance<dim>      &balance,
              const GridMotion        &motion,
              StepAccounts            &result)
    {
      const GridStart<dim>   &start        = step.start;
      const VelocityMap<dim> &map          = balance.velocity_map();
      const Vector           &displacement = motion.displacement;
      const Vector reaction = free_and_fixed(start.active->constraints(),
                                             equation.unconstrained_residual())
                                .second;
      result.residual_work = equation.residual() * displacement;
      result.reaction_work = reaction * displacement;
      balance.see_reactions(*start.active, reaction);

      const Vector &mapped = map.mapped(start);
      Vector        change = motion.velocity;
      change -= mapped;
      const Vector misfit = momentum_misfit(start, mapped);
      // v.M~ v / 2 - v.p, with M~ v = p - misfit
      result.hidden_kinetic_energy =
        -0.5 * (mapped * start.momentum + mapped * misfit);
      map.book(start, misfit, change, result);
    }
  } // namespace

  std::vector<EffectCard>
  account_cards(const PointMapping &mapping)
  {
    std::vector<EffectCard> cards(2);
    EffectCard             &lumping = cards[0], &pic = cards[1];

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
    return cards;
  }

  template <int dim>
  StepAccounts
  empty_accounts(const Balance<dim> &balance)
  {
    StepAccounts none;
    none.mass_losses = balance.mass_loss_entries();
    none.map_losses  = balance.velocity_map().loss_entries();
    return none;
  }

  template <int dim>
  std::vector<EnergyEntry>
  account_entries(const StepAccounts &accounts, const StepMethod<dim> &method)
  {
    const PointMapping &mapping       = method.mapping;
    const std::string   reaction_work = method.balance.reaction_work();
    using Kind                        = EnergyEntry::Kind;
    std::vector<EnergyEntry> entries;
    if (!reaction_work.empty())
      entries.push_back({reaction_work, Kind::work, accounts.reaction_work});
    if (mapping.lumping > 0.)
      entries.push_back(
        {"lumping_loss", Kind::dissipated, accounts.lumping_loss});
    if (mapping.flip_fraction < 1.)
      entries.push_back(
        {"mapping_loss", Kind::dissipated, accounts.mapping_loss});
    for (const auto &losses : {accounts.mass_losses, accounts.map_losses})
      entries.insert(entries.end(), losses.begin(), losses.end());
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
                  const double v0 = v_mapped[unknown<dim>(node, c)],
                               v1 = v_new[unknown<dim>(node, c)];
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
    std::vector<double> sums{lumping, pic, hidden};
    dealii::Utilities::MPI::sum(sums, start.active->communicator(), sums);
    result.lumping_loss          = 0.5 * mapping.lumping * sums[0];
    result.mapping_loss          = (1. - alpha) * sums[1];
    result.hidden_kinetic_energy = sums[2];
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
    StepAccounts  result;
    const Vector &mapped = balance.velocity_map().mapped(step.start);
    add_works(step, equation, balance, motion, result);
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
                           active.to_local(mapped),
                           active.to_local(motion.velocity),
                           result);
      }
    Vector change = motion.velocity;
    change -= mapped;
    result.mass_losses =
      balance.mass_losses(*step.start.active, change, step.phases);
    if (!has_losses) // M~ has masses that no particle carries
      for (const EnergyEntry &hidden :
           balance.mass_losses(*step.start.active, mapped, step.phases))
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
  empty_accounts<2>(const Balance<2> &);
  template StepAccounts
  empty_accounts<3>(const Balance<3> &);
  template std::vector<EnergyEntry>
  account_entries<2>(const StepAccounts &, const StepMethod<2> &);
  template std::vector<EnergyEntry>
  account_entries<3>(const StepAccounts &, const StepMethod<3> &);
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
