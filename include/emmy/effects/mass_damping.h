#ifndef emmy_effects_mass_damping_h
#define emmy_effects_mass_damping_h

#include <emmy/effects/effect.h>

namespace emmy
{
  /** Section `Effects/Mass damping`. */
  template <int dim>
  class MassDampingParameters : public EffectParameters<dim>
  {
  public:
    /** Declares the entries of a section. */
    explicit MassDampingParameters(const std::string &section);

    void
    add_to(Effects<dim> &effects, FieldLayout &layout) const override;

    /** What `emmy --check` says of it. */
    static EffectCard
    card();

  private:
    double rate = 0.; // 1/s
  };

  /**
   * A force against the mean velocity of the step, alpha M~ u/dt with the mass
   * of the point-to-grid map. What it takes, alpha u.M~ u/dt, is never
   * negative. It damps rigid motion too: a body that falls meets it. Cost: a
   * product of the points' shape functions, as inertia.
   */
  template <int dim>
  class MassDamping : public ForceTerm<dim>
  {
  public:
    /**
     * @param rate alpha, 1/s
     * @param mass component of the points' mass
     */
    MassDamping(const double rate, const unsigned int mass);

    std::string
    add(const StepData<dim> &step,
        const Iterate<dim>  &iterate,
        Vector              &force,
        Matrix              *jacobian) const override;
    std::vector<EnergyEntry>
    energies(const StepData<dim>    &step,
             const Vector           &displacement,
             const PointArrays<dim> &accepted) const override;
    std::vector<EnergyEntry>
    energy_entries() const override;

  private:
    /** This rank's share at the local nodes, N. */
    std::vector<double>
    force_on_nodes(const StepData<dim>       &step,
                   const std::vector<double> &displacement) const;

    const double       rate;
    const unsigned int mass;
  };
} // namespace emmy

#endif
