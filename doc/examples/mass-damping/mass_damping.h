#ifndef mass_damping_h
#define mass_damping_h

#include <emmy/effects/effect.h>

/** Section `Effects/Mass damping`. */
template <int dim>
class MassDampingParameters : public emmy::EffectParameters<dim>
{
public:
  explicit MassDampingParameters(const std::string &section);

  /** What emmy --check says of the effect. */
  static emmy::EffectCard
  card();

  void
  add_to(emmy::Effects<dim> &effects, emmy::FieldLayout &) const override;

private:
  double rate = 0.; // alpha, 1/s; 0: not given
};

/**
 * Damping proportional to the mass, the first half of Rayleigh's:
 * f = alpha M~ v_mid on the grid, with v_mid = u/dt the mean of the velocities
 * at t and t + dt. In a rigid translation each step multiplies the velocity by
 * (1 - alpha dt/2)/(1 + alpha dt/2); this changes its sign where alpha dt > 2.
 *
 * Owned by the balance. Cost: a product of the mass with a vector in each
 * evaluation of the residual; with a tangent the sum of two matrices.
 */
template <int dim>
class MassDamping : public emmy::ForceTerm<dim>
{
public:
  /** @param rate alpha, 1/s */
  explicit MassDamping(const double rate);

  std::string
  add(const emmy::StepData<dim> &step,
      const emmy::Iterate<dim>  &iterate,
      emmy::Vector              &force,
      emmy::Matrix              *jacobian) const override;

  /** damping_loss, f.u: what the damping takes in a step; never negative. */
  std::vector<emmy::EnergyEntry>
  energies(const emmy::StepData<dim>    &step,
           const emmy::Vector           &displacement,
           const emmy::PointArrays<dim> &accepted) const override;
  std::vector<emmy::EnergyEntry>
  energy_entries() const override;

private:
  const double rate;
};

/** Let parameter files name it: once, before one is read. */
void
add_mass_damping();

#endif
