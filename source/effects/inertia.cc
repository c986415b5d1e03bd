#include <emmy/effects/inertia.h>
#include <emmy/transfer/mass_blocks.h>

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
  Inertia<dim>::Inertia(const unsigned int mass)
    : mass(mass)
  {}

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
        add_in_middle(step, iterate, force, jacobian);
        return "";
      }
    Vector acceleration = step.start.velocity;
    acceleration.sadd(-1., 0.5 * rate, iterate.displacement);
    acceleration *= rate;
    Vector inertia = step.start.active->make_vector();
    step.start.mass.vmult(inertia, acceleration);
    force += inertia;
    if (jacobian)
      step.start.add_mass_to(*jacobian, inertia_factor(step.time_step));
    return "";
  }

  template <int dim>
  void
  Inertia<dim>::add_in_middle(const StepData<dim> &step,
                              const Iterate<dim>  &iterate,
                              Vector              &force,
                              Matrix              *jacobian) const
  {
    const ActiveGrid<dim>     &active = *step.start.active;
    const std::vector<double> &u      = iterate.local_displacement;
    const double               rate   = 2. / step.time_step;
    // 2/dt (M~ u/dt - p): v_t, with M~ v_t = p, is wanted after Newton only
    const double       *masses = step.points.component(mass);
    std::vector<double> mass_times_u(dim * active.n_local_nodes());
    add_mass_times(u, step.stencils, masses, step.start, mass_times_u);
    const auto add_block = [&](MassBlock &block) {
      for (unsigned int a = 0; a < block.mass.m(); ++a)
        block.mass(a, a) += block.damping[a];
      block.mass *= inertia_factor(step.time_step);
      active.graph().add_components(block.nodes, block.mass, *jacobian);
    };
    if (jacobian && step.moving) // it does the points
      step.start.hand_out_added_mass(add_block);
    else if (jacobian)
      for_each_mass_block<dim>(
        step.stencils, masses, step.start, /*phases=*/nullptr, add_block);
    Vector momentum = active.make_vector();
    active.add(mass_times_u, momentum);
    momentum.sadd(0.5 * rate, -1., step.start.momentum);
    force.add(rate, momentum);
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
