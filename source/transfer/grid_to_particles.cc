
#include <emmy/base/exceptions.h>
#include <emmy/transfer/grid_to_particles.h>
#include <emmy/transfer/particle_sort.h>

#include <algorithm>

namespace emmy
{
  template <int dim>
  std::string
  move_points(const Stencils<dim>       &stencils,
              const PointArrays<dim>    &points,
              const ActiveGrid<dim>     &active,
              const BackgroundGrid<dim> &grid,
              const FieldLayout         &layout,
              const double               flip_fraction,
              const std::vector<double> &displacement,
              const std::vector<double> &velocity_change,
              PointArrays<dim>          &trial)
  {
    const unsigned int velocity = layout["velocity"];

    for (const auto &group : stencils.groups)
      for (unsigned int c = 0; c < dim; ++c)
        {
          // start from t: the trial states may have been moved before
          const unsigned int *nodes = active.nodes(group);
          double             *x     = trial.position(c) + group.first_point;
          double       *v = trial.component(velocity + c) + group.first_point;
          const double *v_old =
            points.component(velocity + c) + group.first_point;
          std::copy_n(points.position(c) + group.first_point,
                      group.n_points,
                      x);
          for (unsigned int p = 0; p < group.n_points; ++p)
            v[p] = flip_fraction * v_old[p];
          for (unsigned int a = 0; a < group.n_nodes; ++a)
            {
              const double *S      = stencils.value(group, a);
              const double  node_u = displacement[unknown<dim>(nodes[a], c)];
              const double node_dv = velocity_change[unknown<dim>(nodes[a], c)];
              for (unsigned int p = 0; p < group.n_points; ++p)
                {
                  x[p] += S[p] * node_u;
                  v[p] += S[p] * node_dv;
                }
            }
        }
    for (std::size_t p = 0; p < trial.n_points(); ++p)
      if (!grid.contains(trial.point(p)))
        return "particle " + std::to_string(stencils.particles[p]->get_id()) +
               " at (" +
               dealii::Patterns::Tools::to_string(
                 stencils.particles[p]->get_location()) +
               ") m would leave the grid, to (" +
               dealii::Patterns::Tools::to_string(trial.point(p)) + ") m";
    return "";
  }

  template <int dim>
  void
  grid_to_particles(const Stencils<dim>                     &stencils,
                    const PointArrays<dim>                  &accepted,
                    const FieldLayout                       &layout,
                    BackgroundGrid<dim>                     &grid,
                    dealii::Particles::ParticleHandler<dim> &particles)
  {
    for (std::size_t p = 0; p < accepted.n_points(); ++p)
      {
        auto       particle   = stencils.particles[p];
        const auto properties = particle->get_properties();
        for (unsigned int c = 0; c < layout.n_components(); ++c)
          properties[c] = accepted.component(c)[p];
        particle->set_location(accepted.point(p));
      }
    sort_into_cells(grid, particles);
  }

#define INSTANTIATE(dim)                                             \
  template std::string move_points<dim>(const Stencils<dim> &,       \
                                        const PointArrays<dim> &,    \
                                        const ActiveGrid<dim> &,     \
                                        const BackgroundGrid<dim> &, \
                                        const FieldLayout &,         \
                                        const double,                \
                                        const std::vector<double> &, \
                                        const std::vector<double> &, \
                                        PointArrays<dim> &);         \
  template void        grid_to_particles<dim>(                       \
    const Stencils<dim> &,                                    \
    const PointArrays<dim> &,                                 \
    const FieldLayout &,                                      \
    BackgroundGrid<dim> &,                                    \
    dealii::Particles::ParticleHandler<dim> &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
