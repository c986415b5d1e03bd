#ifndef emmy_effects_internal_force_h
#define emmy_effects_internal_force_h

#include <emmy/effects/stress_states.h>
#include <emmy/effects/stress_tangent.h>

#include <optional>

namespace emmy
{
  /**
   * Internal force f_A = sum V0_p P_p grad S_Ap with the nominal stress P of a
   * stress rule, relative to the configuration at t (Pretti et al. 2023, eq.
   * 44; the gradients are those at the start of the step). Newton's cost is
   * here: one material call per batch of points, one small matrix per
   * neighbourhood of nodes.
   */
  template <int dim>
  class InternalForce : public ForceTerm<dim>
  {
  public:
    /**
     * @param material_of_body borrowed; one per body
     * @param layout           asked for the fields of the particles' state
     * @param rule             what stress acts during a step
     * @param names            of the materials, one per body, for the price of
     *   each; none: not wanted
     */
    InternalForce(std::vector<const Material<dim> *> material_of_body,
                  FieldLayout                       &layout,
                  const StressRule<dim> &rule = stress_rule<dim>("conserving"),
                  std::vector<std::string> names = {});

    /** What `emmy --check` says of it. */
    static EffectCard
    card();

    std::string
    add(const StepData<dim> &step,
        const Iterate<dim>  &iterate,
        Vector              &force,
        Matrix              *jacobian) const override;

    /**
     * Those of the states, and stress_rule_loss of a rule that does not
     * conserve: the work of the force that none of these shows.
     */
    std::vector<EnergyEntry>
    energies(const StepData<dim>    &step,
             const Vector           &displacement,
             const PointArrays<dim> &accepted) const override;
    std::vector<EnergyEntry>
    energy_entries() const override;

  private:
    /** What add() works on and with. */
    struct Assembly
    {
      StressBatch<dim>    batch;
      MiddleStep<dim>     middle;
      std::vector<double> nodal_force;
      /** Only where there is a matrix. */
      std::optional<StressTangent<dim>> tangent;
    };

    /**
     * Add points to the nodal forces and to the tangent.
     * @return what is wrong, if anything
     */
    std::string
    add_batch(const StepData<dim>   &step,
              const Iterate<dim>    &iterate,
              const PointBatch<dim> &points,
              Assembly              &work) const;

    /**
     * The stress of a batch for a displacement at the local nodes: that of the
     * configuration in which the grid is undeformed.
     * @return index of the first point that is turned inside out; n_points if
     *   there is none
     */
    unsigned int
    evaluate(const StepData<dim>       &step,
             const PointBatch<dim>     &points,
             const std::vector<double> &local_displacement,
             StressBatch<dim>          &batch,
             MiddleStep<dim>           &middle) const;

    /** Work of the stress at this rank's points, sum V0 P : H, J. Collective.
     */
    double
    work(const StepData<dim> &step, const Vector &displacement) const;

    const StressRule<dim>   rule;
    const StressStates<dim> states;
  };
} // namespace emmy

#endif
