#include <emmy/assembly/inertia.h>

namespace emmy
{
  double
  inertia_factor(const double time_step)
  {
    const double rate = 2. / time_step;
    return 0.5 * rate * rate;
  }

  Vector
  velocity_new(const Vector &displacement,
               const Vector &velocity_old,
               const double  time_step)
  {
    Vector velocity = velocity_old;
    velocity.sadd(-1., 2. / time_step, displacement);
    return velocity;
  }

  template <int dim>
  EffectCard
  Inertia<dim>::card()
  {
    EffectCard card;
    card.name       = "inertia";
    card.enters     = "Newton: mass times acceleration";
    card.is_present = true;
    return card;
  }

  template <int dim>
  std::string
  Inertia<dim>::add(const StepData<dim> &step,
                    const Iterate<dim>  &iterate,
                    Vector              &force,
                    Matrix              *jacobian) const
  {
    // 2/dt (u/dt - v_t), with the rounded number 2/dt of velocity_new() in
    // both places: with another one for 2/dt^2 the energy would drift, by a
    // part of 1e-16 in each step, always to the same side
    const double rate = 2. / step.time_step;
    if (step.stencils.at_middle)
      {
        // the same with M~ v_t = p: v_t is wanted only after Newton
        Vector momentum = step.start.momentum;
        step.start.mass.vmult(momentum, iterate.displacement);
        momentum.sadd(0.5 * rate, -1., step.start.momentum);
        force.add(rate, momentum);
        if (jacobian)
          jacobian->add(inertia_factor(step.time_step), step.start.damped_mass);
        return "";
      }
    Vector acceleration = step.start.velocity;
    acceleration.sadd(-1., 0.5 * rate, iterate.displacement);
    acceleration *= rate;
    Vector inertia = step.start.active->make_vector();
    step.start.mass.vmult(inertia, acceleration);
    force += inertia;
    if (jacobian)
      jacobian->add(inertia_factor(step.time_step), step.start.damped_mass);
    return "";
  }

  template <int dim>
  std::vector<EnergyEntry>
  Inertia<dim>::energies(const StepData<dim> &,
                         const Vector &,
                         const PointArrays<dim> &) const
  {
    return energy_entries();
  }

  template <int dim>
  std::vector<EnergyEntry>
  Inertia<dim>::energy_entries() const
  {
    return {};
  }

  template class Inertia<2>;
  template class Inertia<3>;
} // namespace emmy
