#include <emmy/effects/field_load.h>

namespace emmy
{
  template <int dim>
  FieldLoad<dim>::FieldLoad(const dealii::Tensor<1, dim> &vector,
                            const unsigned int            component,
                            Amplitude                     amplitude)
    : vector(vector)
    , component(component)
    , amplitude(std::move(amplitude))
  {}

  template <int dim>
  void
  FieldLoad<dim>::add_load(const StepData<dim> &step,
                           std::vector<double> &local_force) const
  {
    const double                *weight = step.points.component(component);
    const dealii::Tensor<1, dim> q =
      amplitude.over(step.time, step.time_step) * vector;
    for (const auto &group : step.stencils.groups)
      for (unsigned int a = 0; a < group.n_nodes; ++a)
        {
          const double *S     = step.stencils.value(group, a);
          double        nodal = 0.;
          for (unsigned int p = 0; p < group.n_points; ++p)
            nodal += S[p] * weight[group.first_point + p];
          const unsigned int node = step.start.active->nodes(group)[a];
          for (unsigned int c = 0; c < dim; ++c)
            local_force[unknown<dim>(node, c)] += nodal * q[c];
        }
  }

  template <int dim>
  void
  FieldLoad<dim>::add_load_at_points(const StepData<dim> &step,
                                     std::vector<double> &point_force) const
  {
    const double                *weight = step.points.component(component);
    const dealii::Tensor<1, dim> q =
      amplitude.over(step.time, step.time_step) * vector;
    for (std::size_t p = 0; p < step.points.n_points(); ++p)
      for (unsigned int c = 0; c < dim; ++c)
        point_force[dim * p + c] += weight[p] * q[c];
  }

  template class FieldLoad<2>;
  template class FieldLoad<3>;
} // namespace emmy
