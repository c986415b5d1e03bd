#ifndef emmy_step_accounts_h
#define emmy_step_accounts_h

#include <emmy/step/step_equation.h>
#include <emmy/step/step_method.h>

namespace emmy
{
  /** What lumping and PIC cost. */
  std::vector<EffectCard>
  account_cards(const PointMapping &mapping);

  /** Accounts of a step in which nothing happens, with all their entries. */
  template <int dim>
  StepAccounts
  empty_accounts(const Balance<dim> &balance);

  /**
   * The entries of the ledger that come from the accounts: those that the
   * method can make differ from zero.
   */
  template <int dim>
  std::vector<EnergyEntry>
  account_entries(const StepAccounts &accounts, const StepMethod<dim> &method);

  /**
   * Add lumping_loss, mapping_loss and hidden_kinetic_energy of a step, summed
   * over the ranks. Collective.
   *
   * @param velocity_mapped,velocity_new at the local nodes, [dim * node + c],
   *   m/s
   */
  template <int dim>
  void
  add_mapping_losses(const StepData<dim>       &step,
                     const FieldLayout         &layout,
                     const PointMapping        &mapping,
                     const std::vector<double> &velocity_mapped,
                     const std::vector<double> &velocity_new,
                     StepAccounts              &result);

  /** How the grid moves in a solved step. */
  struct GridMotion
  {
    const Vector &displacement;   ///< u, m
    const Vector &velocity;       ///< at t + dt, m/s
    const double  kinetic_energy; ///< of the particles at t, J
  };

  /** The accounts of a solved step, summed over the ranks. Collective. */
  template <int dim>
  StepAccounts
  accounts(const StepData<dim>     &step,
           const Balance<dim>      &balance,
           const StepEquation<dim> &equation,
           const FieldLayout       &layout,
           const PointMapping      &mapping,
           const GridMotion        &motion);
} // namespace emmy

#endif
