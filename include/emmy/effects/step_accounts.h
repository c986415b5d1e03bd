#ifndef emmy_effects_step_accounts_h
#define emmy_effects_step_accounts_h

#include <emmy/effects/step_report.h>

namespace emmy
{
  /**
   * What the way between particles and grid, given motions and the solvers did
   * to the energy in one step, J. With these, and with the energies of the
   * balance,
   *   gain of the particles' kinetic energy + stored + dissipated
   *     = work of loads + reaction_work + residual_work
   *       - lumping_loss - mapping_loss - mass_losses - map_losses
   * holds exactly, converged or not. v_mapped is VelocityMap::mapped().
   */
  struct StepAccounts
  {
    /**
     * Of what the solvers left: r.u of Newton on free unknowns, and
     * (v_new - v_mapped).(p - M~ v_mapped) of the map.
     */
    double residual_work = 0.;
    /** Of given motions: on u in the step, and through the map. */
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
    /** Of the effect that maps velocities in its own way. */
    std::vector<EnergyEntry> map_losses = {};
    /**
     * Enters no balance: what the particles carry and the grid does not see at
     * the start of the step, sum m_p |v_p - sum S v_mapped|^2 / 2.
     */
    double hidden_kinetic_energy = 0.;
  };
} // namespace emmy

#endif
