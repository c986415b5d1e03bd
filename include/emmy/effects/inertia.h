#ifndef emmy_effects_inertia_h
#define emmy_effects_inertia_h

#include <emmy/effects/effect.h>

namespace emmy
{
  /**
   * Inertia of the mid-point rule, M~ 2/dt (u/dt - v_t), with the mass of the
   * point-to-grid map (Pretti et al. 2023, eqs 20-24; v_mid = u/dt is the mean
   * of the velocities at t and t + dt).
   */
  template <int dim>
  class Inertia : public ForceTerm<dim>
  {
  public:
    /** @param mass component of the points' mass */
    explicit Inertia(const unsigned int mass);

    /** What `emmy --check` says of it. */
    static EffectCard
    card();

    std::string
    add(const StepData<dim> &step,
        const Iterate<dim>  &iterate,
        Vector              &force,
        Matrix              *jacobian) const override;

    /** None: the particles' kinetic energy is booked by the step. */
    std::vector<EnergyEntry>
    energies(const StepData<dim>    &step,
             const Vector           &displacement,
             const PointArrays<dim> &accepted) const override;
    std::vector<EnergyEntry>
    energy_entries() const override;

  private:
    /**
     * The same at the places of the middle, which move with the iterates: M~
     * is not summed for each. The derivative of the points' part is left to
     * StepData::moving.
     */
    void
    add_in_middle(const StepData<dim> &step,
                  const Iterate<dim>  &iterate,
                  Vector              &force,
                  Matrix              *jacobian) const;

    const unsigned int mass;
  };

  /** The factor of M~ in the derivative, 2/dt^2 as the rounded 2/dt gives it.
   */
  double
  inertia_factor(const double time_step);

  /** v at t + dt: 2/dt u - v_t. */
  Vector
  velocity_new(const Vector &displacement,
               const Vector &velocity_old,
               const double  time_step);
} // namespace emmy

#endif
