#include <emmy/assembly/inertia.h>

namespace emmy
{
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
  std::string
  Inertia<dim>::add(const StepData<dim> &step,
                    const Iterate<dim>  &iterate,
                    Vector              &force,
                    Matrix              *jacobian) const
  {
    const double dt           = step.time_step;
    Vector       acceleration = step.start.velocity;
    acceleration.sadd(-2. / dt, 2. / (dt * dt), iterate.displacement);
    Vector inertia = step.start.active->make_vector();
    step.start.mass.vmult(inertia, acceleration);
    force += inertia;
    if (jacobian)
      jacobian->add(2. / (dt * dt), step.start.damped_mass);
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
