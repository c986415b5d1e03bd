#ifndef emmy_step_accounts_h
#define emmy_step_accounts_h

#include <emmy/step/balance.h>

namespace emmy
{
  /**
   * What the way between particles and grid, the walls and the solvers did to
   * the energy in one step, J. With these, and with the energies of the
   * balance,
   *   gain of the particles' kinetic energy + stored + dissipated
   *     = work of loads + reaction_work + residual_work
   *       - lumping_loss - mapping_loss - mass_losses - wall_loss
   * holds exactly, converged or not.
   */
  struct StepAccounts
  {
    /**
     * Of what the solvers left: r.u of Newton on free unknowns, and
     * (v_new - v_mapped).(p - M~ v_mapped) of the map.
     */
    double residual_work = 0.;
    /** Of moving walls: on u in the step, and through the map. */
    double reaction_work = 0.;
    /**
     * Of the lumped part X = M~ - M of the mass, Delta v . X Delta v / 2 with
     * Delta v = v_new - v_mapped: never negative (Love and Sulsky 2006; Pretti
     * et al. 2023, eqs 36, 38).
     */
    double lumping_loss = 0.;
    /**
     * What PIC, or its share, has less than FLIP. With alpha the FLIP
     * fraction, d = v_p - sum S v_mapped and w = sum S v_new,
     * (1 - alpha) sum m_p (w.d + (1 + alpha) d.d / 2).
     */
    double mapping_loss = 0.;
    /** Of effects' own masses G, Delta v . G Delta v / 2: never negative. */
    std::vector<EnergyEntry> mass_losses = {};
    /**
     * Of Walls::inelastic: w.M~ w / 2, with w what the walls take from the
     * grid's velocity.
     */
    double wall_loss = 0.;
    /**
     * Enters no balance: what the particles carry and the grid does not see at
     * the start of the step, sum m_p |v_p - sum S v_mapped|^2 / 2.
     */
    double hidden_kinetic_energy = 0.;
  };

  /** The names of causes in the table of times. */
  constexpr const char *moving_walls_effect = "moving walls";

  /** What these cost. */
  std::vector<EffectCard>
  account_cards(const PointMapping &mapping, const bool has_moving_walls);

  /**
   * The entries of the ledger that come from the accounts: those that the
   * method can make differ from zero.
   */
  std::vector<EnergyEntry>
  account_entries(const StepAccounts &accounts,
                  const PointMapping &mapping,
                  const bool          has_moving_walls);

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
