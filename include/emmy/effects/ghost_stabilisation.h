#ifndef emmy_effects_ghost_stabilisation_h
#define emmy_effects_ghost_stabilisation_h

#include <emmy/effects/force_term.h>

namespace emmy
{
  /** Section `Effects/Ghost stabilisation`. */
  template <int dim>
  class GhostParameters : public EffectParameters<dim>
  {
  public:
    explicit GhostParameters(const std::string &section);

    void
    add_to(Effects<dim> &effects, FieldLayout &layout) const override;

    static EffectCard
    card();

  private:
    double mass_penalty = 0.25, stiffness_penalty = 0.01; // gamma_M, gamma_K
  };

  /**
   * The stiffness of ghost stabilisation, f = K_G u/2 on the displacement of
   * the step at its mid-point (formulation of Coombs 2023; Sticko et al. 2020):
   * it resists differences of slopes across the faces that GridStart lists,
   * and keeps no memory, so that u.K_G u/2 is lost in each step. The mass of
   * ghost stabilisation is part of M~.
   */
  template <int dim>
  class GhostStiffness : public ForceTerm<dim>
  {
  public:
    std::string
    add(const StepData<dim> &step,
        const Iterate<dim>  &iterate,
        Vector              &force,
        Matrix              *jacobian) const override;

    /** ghost_stiffness_loss. */
    std::vector<EnergyEntry>
    energies(const StepData<dim>    &step,
             const Vector           &displacement,
             const PointArrays<dim> &accepted) const override;
    std::vector<EnergyEntry>
    energy_entries() const override;
  };
} // namespace emmy

#endif
