#include <emmy/transfer/lumped_grid.h>

#include <algorithm>

namespace emmy
{
  namespace
  {
    /** Mean velocity of the particles that reach massless nodes. */
    template <int dim>
    void
    set_massless_velocities(const Stencils<dim>    &stencils,
                            const PointArrays<dim> &points,
                            const FieldLayout      &layout,
                            const ActiveGrid<dim>  &active,
                            LumpedGrid<dim>        &grid)
    {
      const double       *mass     = points.component(layout["mass"]);
      const unsigned int  velocity = layout["velocity"];
      std::vector<double> weight(grid.mass.size()),
        momentum(grid.momentum.size());
      for (const auto &group : stencils.groups)
        for (unsigned int a = 0; a < group.n_nodes; ++a)
          if (const unsigned int node = active.nodes(group)[a];
              grid.is_massless[node])
            for (std::size_t p = group.first_point;
                 p < group.first_point + group.n_points;
                 ++p)
              {
                weight[node] += mass[p];
                for (unsigned int c = 0; c < dim; ++c)
                  momentum[unknown<dim>(node, c)] +=
                    mass[p] * points.component(velocity + c)[p];
              }
      active.share(weight);
      active.share(momentum);
      for (unsigned int node = 0; node < weight.size(); ++node)
        if (grid.is_massless[node])
          for (unsigned int c = 0; c < dim; ++c)
            grid.velocity[unknown<dim>(node, c)] =
              momentum[unknown<dim>(node, c)] / weight[node];
    }
  } // namespace

  template <int dim>
  LumpedGrid<dim>
  particles_to_lumped_grid(const Stencils<dim>    &stencils,
                           const PointArrays<dim> &points,
                           const FieldLayout      &layout,
                           const ActiveGrid<dim>  &active)
  {
    const unsigned int  n_nodes  = active.n_local_nodes();
    const unsigned int  velocity = layout["velocity"];
    const double       *mass     = points.component(layout["mass"]);
    LumpedGrid<dim>     grid;
    std::vector<double> momentum; // of the points of a group
    grid.mass.resize(n_nodes);
    grid.momentum.resize(dim * n_nodes);
    for (const auto &group : stencils.groups)
      {
        const unsigned int  n     = group.n_points;
        const unsigned int *nodes = active.nodes(group);
        const double       *m     = mass + group.first_point;
        momentum.resize(dim * n);
        for (unsigned int c = 0; c < dim; ++c)
          {
            const double *v =
              points.component(velocity + c) + group.first_point;
            for (unsigned int p = 0; p < n; ++p)
              momentum[c * n + p] = m[p] * v[p];
          }
        for (unsigned int a = 0; a < group.n_nodes; ++a)
          {
            const double           *S        = stencils.value(group, a);
            double                  sum_mass = 0.;
            std::array<double, dim> sum{};
            for (unsigned int p = 0; p < n; ++p)
              {
                sum_mass += S[p] * m[p];
                for (unsigned int c = 0; c < dim; ++c)
                  sum[c] += S[p] * momentum[c * n + p];
              }
            grid.mass[nodes[a]] += sum_mass;
            for (unsigned int c = 0; c < dim; ++c)
              grid.momentum[unknown<dim>(nodes[a], c)] += sum[c];
          }
      }
    active.share(grid.mass);
    active.share(grid.momentum);

    const double largest = dealii::Utilities::MPI::max(
      n_nodes > 0 ? *std::max_element(grid.mass.begin(), grid.mass.end()) : 0.,
      active.communicator());
    bool has_massless = false;
    grid.velocity     = grid.momentum;
    grid.is_massless.resize(n_nodes);
    for (unsigned int node = 0; node < n_nodes; ++node)
      if (grid.mass[node] > least_nodal_mass * largest)
        for (unsigned int c = 0; c < dim; ++c)
          grid.velocity[unknown<dim>(node, c)] /= grid.mass[node];
      else
        has_massless = grid.is_massless[node] = true;
    if (dealii::Utilities::MPI::max(has_massless ? 1 : 0,
                                    active.communicator()) == 1)
      set_massless_velocities(stencils, points, layout, active, grid);
    return grid;
  }

  template struct LumpedGrid<2>;
  template struct LumpedGrid<3>;
  template LumpedGrid<2>
  particles_to_lumped_grid<2>(const Stencils<2> &,
                              const PointArrays<2> &,
                              const FieldLayout &,
                              const ActiveGrid<2> &);
  template LumpedGrid<3>
  particles_to_lumped_grid<3>(const Stencils<3> &,
                              const PointArrays<3> &,
                              const FieldLayout &,
                              const ActiveGrid<3> &);
} // namespace emmy
