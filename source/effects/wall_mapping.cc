#include <emmy/effects/wall_mapping.h>

namespace emmy
{
  template <int dim>
  WallMapping<dim>::WallMapping(const std::string &kind)
    : is_inelastic(kind == "inelastic")
  {}

  template <int dim>
  std::string
  WallMapping<dim>::name(const std::string &kind)
  {
    return kind + " walls";
  }

  template <int dim>
  EffectCard
  WallMapping<dim>::card(const std::string &kind, const bool is_present)
  {
    EffectCard card;
    card.name       = name(kind);
    card.setting    = "Method/Wall mapping = " + kind;
    card.enters     = "velocity from momentum";
    card.is_present = is_present;
    if (kind == "inelastic")
      {
        card.enters         = "velocity from momentum: a second solve";
        card.ledger_columns = {"wall_loss"};
      }
    return card;
  }

  template <int dim>
  VelocityMap<dim> *
  WallMapping<dim>::velocity_map()
  {
    return this;
  }

  template <int dim>
  bool
  WallMapping<dim>::find(const StepData<dim>                    &step,
                         const Vector                           &given,
                         const typename VelocityMap<dim>::Solve &solve,
                         GridStart<dim>                         &start)
  {
    if (is_inelastic && !VelocityMap<dim>::find(step, given, solve, start))
      return false;
    // the only solve of unconstrained walls is none too many
    const auto timed =
      effect_scope(is_inelastic ? step.phases : nullptr, name("inelastic"));
    Vector     velocity = start.mean_velocity;
    const bool is_solved =
      solve(NodalMatrix<dim>::Conditions::left_out, velocity);
    if (!is_inelastic)
      start.velocity = Vector(velocity);
    mapped_velocity = std::move(velocity);
    return is_solved;
  }

  template <int dim>
  const Vector &
  WallMapping<dim>::mapped(const GridStart<dim> &) const
  {
    return mapped_velocity;
  }

  template <int dim>
  void
  WallMapping<dim>::book(const GridStart<dim> &start,
                         const Vector         &misfit,
                         const Vector         &change,
                         StepAccounts         &books) const
  {
    books.residual_work += misfit * change;
    if (!is_inelastic)
      return;
    // M~ w is the impulse with which the walls stop the grid
    Vector impulse = momentum_misfit(start, start.velocity);
    impulse -= misfit;
    Vector stopped = mapped_velocity;
    stopped -= start.velocity;
    const auto [free, fixed] =
      free_and_fixed(start.active->constraints(), impulse);
    books.map_losses           = loss_entries();
    books.map_losses[0].change = 0.5 * (stopped * impulse);
    books.residual_work -= start.velocity * free;
    books.reaction_work -= start.velocity * fixed;
  }

  template <int dim>
  std::vector<EnergyEntry>
  WallMapping<dim>::loss_entries() const
  {
    if (!is_inelastic)
      return {};
    return {{"wall_loss", EnergyEntry::Kind::dissipated, 0.}};
  }

  template class WallMapping<2>;
  template class WallMapping<3>;
} // namespace emmy
