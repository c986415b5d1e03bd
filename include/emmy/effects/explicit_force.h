#ifndef emmy_effects_explicit_force_h
#define emmy_effects_explicit_force_h

#include <emmy/effects/stress_states.h>

namespace emmy
{
  /**
   * The internal force of an explicit step, f_A = sum V0_p tau_p grad S_Ap
   * with the stress at t, and the update of the stress at its end, from the
   * displacement that the step came to. The work of the force is not the
   * change of the stored energy: what it differs by is booked.
   *
   * Owned by the scene, in place of the internal force of Newton. Cost per
   * step: two passes over the particles, one material call per batch.
   */
  template <int dim>
  class ExplicitForce
  {
  public:
    /** As those of InternalForce. */
    ExplicitForce(std::vector<const Material<dim> *> material_of_body,
                  FieldLayout                       &layout,
                  std::vector<std::string>           names = {});

    /** What `emmy --check` says of it. */
    static EffectCard
    card();

    /** Add the force to an array over local nodes: [dim * node + c], N. */
    void
    add(const StepData<dim> &step, std::vector<double> &local_force) const;

    /**
     * Write the states at t + dt to @p trial.
     *
     * @param displacement whose gradient strains the particles, at the local
     *   nodes, [dim * node + c], m
     * @return what is wrong on this rank, if anything; then the rest of
     *   @p trial is unfinished
     */
    std::string
    update(const StepData<dim>       &step,
           const std::vector<double> &displacement,
           PointArrays<dim>          &trial) const;

    /**
     * Those of the states, and stress_update_loss: the work of the force minus
     * what they show. This rank's share.
     */
    std::vector<EnergyEntry>
    energies(const PointArrays<dim> &points,
             const PointArrays<dim> &accepted,
             const double            work) const;
    /** Names of the stored energies. */
    std::vector<EnergyEntry>
    energy_entries() const;

  private:
    using Batch = StressBatch<dim>;

    const StressStates<dim> states;
  };
} // namespace emmy

#endif
