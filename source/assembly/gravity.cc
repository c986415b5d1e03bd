#include <emmy/assembly/gravity.h>

namespace emmy
{
  template <int dim>
  GravityParameters<dim>::GravityParameters(const std::string &section)
    : EffectParameters<dim>(section)
  {
    this->add_parameter("Acceleration",
                        acceleration,
                        "Components of the acceleration, separated by commas: "
                        "0, -9.81. Unit: m/s^2. "
                        "Required if gravity is named.",
                        this->prm,
                        dealii::Patterns::List(dealii::Patterns::Double(),
                                               0,
                                               dim));
  }

  template <int dim>
  void
  GravityParameters<dim>::add_to(Effects<dim> &effects,
                                 FieldLayout  &layout) const
  {
    AssertThrow(acceleration.size() == dim,
                ExcParameter(this->path(),
                             "Acceleration",
                             dealii::Patterns::Tools::to_string(acceleration),
                             "it is required: " + std::to_string(dim) +
                               " components in m/s^2, separated by commas, "
                               "e.g. " +
                               (dim == 2 ? "0, -9.81." : "0, 0, -9.81.")));
    dealii::Tensor<1, dim> g;
    for (unsigned int d = 0; d < dim; ++d)
      g[d] = acceleration[d];
    effects.loads.push_back(std::make_unique<Gravity<dim>>(g, layout["mass"]));
  }

  template <int dim>
  Gravity<dim>::Gravity(const dealii::Tensor<1, dim> &acceleration,
                        const unsigned int            mass_component)
    : acceleration(acceleration)
    , mass_component(mass_component)
  {}

  template <int dim>
  void
  Gravity<dim>::add(const StepData<dim> &step,
                    std::vector<double> &local_force) const
  {
    const double *mass = step.points.component(mass_component);
    for (const auto &group : step.stencils.groups)
      for (unsigned int a = 0; a < group.n_nodes; ++a)
        {
          const double *S          = step.stencils.value(group, a);
          double        nodal_mass = 0.;
          for (unsigned int p = 0; p < group.n_points; ++p)
            nodal_mass += S[p] * mass[group.first_point + p];
          const unsigned int node = step.start.active->nodes(group)[a];
          for (unsigned int c = 0; c < dim; ++c)
            local_force[dim * node + c] += nodal_mass * acceleration[c];
        }
  }

  template class GravityParameters<2>;
  template class GravityParameters<3>;
  template class Gravity<2>;
  template class Gravity<3>;
} // namespace emmy
