#ifndef emmy_step_step_equation_h
#define emmy_step_step_equation_h

#include <emmy/solve/nonlinear_equation.h>
#include <emmy/step/balance.h>

namespace emmy
{
  /** r(u) of one step. Keeps the trial states that belong to the last u. */
  template <int dim>
  class StepEquation : public NonlinearEquation
  {
  public:
    /** @param trial_states of the points; the fields of t + dt are not read */
    StepEquation(const Balance<dim>  &balance,
                 const StepData<dim> &step,
                 PointArrays<dim>     trial_states);

    bool
    evaluate(const Vector &solution, const bool with_jacobian) override;
    /** The reduced residual has the share of places that follow. */
    NewtonSystem
    system() override;
    void
    expand(Vector &increment) const override;
    /**
     * The largest norm of a displacement gradient at a particle; where it is
     * surely below 0.1, an upper bound.
     */
    double
    size(const Vector &increment) const override;
    bool
    has_kinks() const override;

    /** Give its memory back; an evaluation that wants it makes it anew. */
    void
    drop_jacobian();
    const std::string &
    problem() const override;

    /**
     * In the middle of the step the residual is found from the momentum, and
     * the velocity v_t is found once Newton has ended: make the residual, with
     * what it leaves on fixed unknowns, that of v_t.
     */
    void
    set_velocity_at_start();

    /** What this equation was made over. */
    const StepData<dim> &
    data() const;

    /** r on free unknowns, see NewtonSystem. */
    const Vector &
    residual() const;

    /** The residual before constraints: the reactions on fixed unknowns. */
    const Vector &
    unconstrained_residual() const;

    /** The loads of the step, N. */
    const Vector &
    load() const;

    /** Particle states that belong to the last evaluation. */
    PointArrays<dim> &
    trial();
    /** Stress and strain of the particles at the last iterate. */
    const PointArrays<dim> &
    trial() const;

    /** The entries of the accepted step, summed over the ranks. Collective. */
    std::vector<EnergyEntry>
    energies(const Vector &solution) const;

  private:
    const Balance<dim> &balance;
    const StepData<dim> step;
    Vector external_force, full_residual, free_residual, with_places;
    Matrix tangent;
    bool   has_tangent = false;     ///< made when it is first asked for
    std::vector<RankOne> rank_ones; ///< beside it
    PointArrays<dim>     trial_states;
    double               force_scale = 0., total_work = 0.;
    std::string          found;
  };
} // namespace emmy

#endif
