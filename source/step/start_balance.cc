#include <emmy/math/mandel.h>
#include <emmy/step/start_balance.h>

#include <algorithm>

namespace emmy
{
  template <int dim>
  double
  start_imbalance(const Stencils<dim>    &stencils,
                  const PointArrays<dim> &points,
                  const ActiveGrid<dim>  &active,
                  const StepSetting<dim> &setting,
                  const double            time)
  {
    const double *volume = points.component(setting.layout["reference_volume"]);
    const unsigned int  stress = setting.layout["kirchhoff_stress"];
    std::vector<double> local(dim * active.n_local_nodes());
    for (const auto &group : stencils.groups)
      for (unsigned int q = 0; q < group.n_points; ++q)
        {
          const std::size_t p = group.first_point + q;
          const auto        tau =
            volume[p] *
            mandel::block<dim>(points.template get<n_mandel<dim>>(stress, p));
          for (unsigned int a = 0; a < group.n_nodes; ++a)
            for (unsigned int i = 0; i < dim; ++i)
              for (unsigned int j = 0; j < dim; ++j)
                local[unknown<dim>(active.nodes(group)[a], i)] +=
                  tau[i][j] * stencils.gradient(group, a, j)[q];
        }
    Vector internal = active.make_vector(), load = internal;
    active.add(local, internal);

    GridStart<dim> start; // borrows the grid
    start.active = std::shared_ptr<const ActiveGrid<dim>>(
      std::shared_ptr<const ActiveGrid<dim>>(), &active);
    const StepData<dim> step{stencils, points, start, time, 0.};
    if (setting.method.balance.has_loads())
      active.add(setting.method.balance.loads(step), load);
    const double scale = std::max(internal.l2_norm(), load.l2_norm());
    internal -= load;
    active.constraints().condense(internal);
    return scale > 0. ? internal.l2_norm() / scale : 0.;
  }

  template double
  start_imbalance<2>(const Stencils<2> &,
                     const PointArrays<2> &,
                     const ActiveGrid<2> &,
                     const StepSetting<2> &,
                     const double);
  template double
  start_imbalance<3>(const Stencils<3> &,
                     const PointArrays<3> &,
                     const ActiveGrid<3> &,
                     const StepSetting<3> &,
                     const double);
} // namespace emmy
