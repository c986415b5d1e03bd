#include <emmy/effects/velocity_map.h>

namespace emmy
{
  template <int dim>
  bool
  VelocityMap<dim>::find(const StepData<dim> &,
                         const Vector   &given,
                         const Solve    &solve,
                         GridStart<dim> &start)
  {
    // The vectors of the step before may be distributed in another way, which
    // Trilinos vectors do not notice when they are copied into: so move.
    const Constraints &constraints = start.active->constraints();
    Vector             velocity    = start.mean_velocity;
    constraints.set_zero(velocity);
    velocity += given;
    constraints.expand(velocity);
    const bool is_solved =
      solve(NodalMatrix<dim>::Conditions::worked_in, velocity);
    start.velocity = std::move(velocity);
    return is_solved;
  }

  template <int dim>
  const Vector &
  VelocityMap<dim>::mapped(const GridStart<dim> &start) const
  {
    return start.velocity;
  }

  template <int dim>
  void
  VelocityMap<dim>::book(const GridStart<dim> &start,
                         const Vector         &misfit,
                         const Vector         &change,
                         StepAccounts         &books) const
  {
    // what the map leaves on fixed unknowns is the impulse of what holds them
    const auto [free, fixed] =
      free_and_fixed(start.active->constraints(), misfit);
    books.residual_work += free * change;
    books.reaction_work += fixed * change;
  }

  template <int dim>
  std::vector<EnergyEntry>
  VelocityMap<dim>::loss_entries() const
  {
    return {};
  }

  template <int dim>
  Vector
  momentum_misfit(const GridStart<dim> &start, const Vector &velocity)
  {
    Vector misfit = start.momentum;
    start.mass.residual(misfit, velocity, start.momentum);
    return misfit;
  }

  std::pair<Vector, Vector>
  free_and_fixed(const Constraints &constraints, Vector vector)
  {
    constraints.fold(vector);
    std::pair<Vector, Vector> parts(vector, vector);
    constraints.set_zero(parts.first);
    parts.second -= parts.first;
    return parts;
  }

  template class VelocityMap<2>;
  template class VelocityMap<3>;
  template Vector
  momentum_misfit<2>(const GridStart<2> &, const Vector &);
  template Vector
  momentum_misfit<3>(const GridStart<3> &, const Vector &);
} // namespace emmy
