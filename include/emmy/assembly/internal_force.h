#ifndef emmy_assembly_internal_force_h
#define emmy_assembly_internal_force_h

#include <emmy/assembly/force_term.h>
#include <emmy/material/conserving_stress.h>

namespace emmy
{
  /**
   * Internal force f_A = sum V0_p P_p grad S_Ap with the conserving stress P
   * relative to the configuration at t (Pretti et al. 2023, eq. 44; the
   * gradients are those at the start of the step). Newton's cost is here: one
   * material call per batch of points, one small matrix per group of points.
   */
  template <int dim>
  class InternalForce : public ForceTerm<dim>
  {
  public:
    /**
     * @param material_of_body borrowed; one per body
     * @param layout           asked for b, tau and psi of each particle
     */
    InternalForce(std::vector<const Material<dim> *> material_of_body,
                  FieldLayout                       &layout);

    std::string
    add(const StepData<dim> &step,
        const Iterate<dim>  &iterate,
        Vector              &force,
        Matrix              *jacobian) const override;

    /** strain_energy. */
    std::vector<EnergyEntry>
    energies(const StepData<dim>    &step,
             const Vector           &displacement,
             const PointArrays<dim> &accepted) const override;
    std::vector<EnergyEntry>
    energy_entries() const override;

  private:
    /** States at t of the batch that starts at point @p first. */
    void
    read_states(const StepData<dim> &step,
                const std::size_t    first,
                StressBatch<dim>    &batch) const;

    /** States at t + dt of that batch. */
    void
    write_states(const StressBatch<dim> &batch,
                 const std::size_t       first,
                 PointArrays<dim>       &trial) const;

    const std::vector<const Material<dim> *> material_of_body;
    const unsigned int reference_volume, left_cauchy_green, kirchhoff_stress,
      strain_energy_density;
  };
} // namespace emmy

#endif
