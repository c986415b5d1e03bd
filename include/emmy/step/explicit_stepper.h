#ifndef emmy_step_explicit_stepper_h
#define emmy_step_explicit_stepper_h

#include <emmy/effects/explicit_force.h>
#include <emmy/step/accounts.h>
#include <emmy/step/time_integrator.h>
#include <emmy/transfer/lumped_grid.h>

namespace emmy
{
  /** The name of the explicit integrator, in the table of times. */
  constexpr const char *explicit_effect = "explicit steps";

  /** What explicit steps are and cost. */
  EffectCard
  explicit_card(const bool is_present);

  /**
   * The explicit step, to compare the implicit one with: lumped mass,
   * symplectic Euler, update-stress-last. With f = f_ext(t) - f_int(tau_t),
   * @f[ v_0 = p / m,\quad v_1 = v_0 + \Delta t\, f/m,\quad
   *     u = \Delta t\, v_1,\quad v_p += \sum S (v_1 - v_0),\quad
   *     x_p += \sum S u,\quad
   *     \Delta F = I + \Delta t \sum w \otimes \nabla S . @f]
   * With the modified stress update (Sulsky, Zhou and Schreyer 1995) w is the
   * grid's velocity that the new v_p make, p_new / m; with the plain one w =
   * v_1, which is f dt / m and so without bound where m is small. Fixed
   * components of v_0, v_1 and w are the velocities of the walls at t and
   * t + dt. Nothing is solved, and no matrix exists. Stable for steps below
   * about that of a wave through a cell; a step in which a particle turns
   * inside out or leaves the grid ends the run.
   *
   * The energy balance closes to round-off, as that of the implicit step:
   * velocity_update_loss is dv.m dv / 2 >= 0, stress_update_loss the work of
   * the internal force that is not stored or dissipated (it has either sign,
   * and nearly balances the former in a vibration). What is left on massless
   * nodes, where the force does not act, is residual_work.
   *
   * Owned by the scene; borrows all it is given.
   */
  template <int dim>
  class ExplicitStepper : public TimeIntegrator<dim>
  {
  public:
    /** Of a scene and its state. */
    ExplicitStepper(const StepSetting<dim>   &setting,
                    const ExplicitForce<dim> &force,
                    RunState<dim>            &state);

    StepReport
    advance() override;
    std::string
    solver_name() const override;
    const GridStart<dim> &
    grid_start() const override;
    const Vector &
    grid_velocity() const override;
    std::vector<double>
    nodal_mass() const override;
    /** Null. */
    const StepDiagnosis<dim> *
    diagnosis() const override;

  private:
    using Base = TimeIntegrator<dim>;
    using Base::accept;
    using Base::setting;
    using Base::state;
    using Base::timed;
    using Base::where;

    /** The motion of the grid, at the local nodes: [dim * node + c]. */
    struct Motion
    {
      std::vector<double> velocity_old, velocity_new; ///< m/s
      std::vector<double> displacement;               ///< m
      std::vector<bool>   is_fixed;                   ///< by walls
      std::vector<double> reaction;                   ///< what fixes them, N
      /** This rank's share, J. */
      double kinetic_energy_old = 0., kinetic_energy_new = 0.,
             velocity_update_loss = 0., stress_work = 0., load_work = 0.,
             reaction_work = 0., residual_work = 0.;
    };

    /** Mass and momentum too. */
    const ActiveGrid<dim> &
    renew_grid(const Ground<dim> &ground) override;
    std::vector<EnergyEntry>
    energy_entries() const override;
    /** v_0 and v_1, and what this does to the energy. Collective. */
    Motion
    accelerate(const StepData<dim> &step) const;
    void
    set_walls(const StepData<dim> &step, Motion &motion) const;
    /** dt w. @param trial with the new positions and velocities. Collective. */
    std::vector<double>
    straining_displacement(const StepData<dim>    &step,
                           const Motion           &motion,
                           const PointArrays<dim> &trial) const;
    /** States, positions, velocities and domains at t + dt. Collective. */
    PointArrays<dim>
    move(const Ground<dim>        &ground,
         const StepData<dim>      &step,
         const Motion             &motion,
         std::vector<std::string> &notes);
    StepReport
    report(const Ground<dim>      &ground,
           const StepData<dim>    &step,
           const Motion           &motion,
           const PointArrays<dim> &trial);
    std::vector<EnergyEntry>
    account_entries(const StepAccounts &accounts, const double loss) const;

    const ExplicitForce<dim> &force;
    // what can be made again
    GridStart<dim>  start; ///< without matrices
    LumpedGrid<dim> lumped;
    Vector          velocity;
  };
} // namespace emmy

#endif
