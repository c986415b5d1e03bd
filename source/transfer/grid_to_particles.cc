#include <deal.II/grid/filtered_iterator.h>
#include <deal.II/grid/grid_tools.h>

#include <emmy/base/exceptions.h>
#include <emmy/transfer/grid_to_particles.h>

namespace emmy
{
  template <int dim>
  std::string
  move_points(const Stencils<dim>       &stencils,
              const ActiveGrid<dim>     &active,
              const BackgroundGrid<dim> &grid,
              const FieldLayout         &layout,
              const Vector              &displacement,
              const Vector              &velocity_change,
              PointArrays<dim>          &trial)
  {
    const std::vector<double> u        = active.to_local(displacement);
    const std::vector<double> dv       = active.to_local(velocity_change);
    const unsigned int        velocity = layout["velocity"];

    for (const auto &group : stencils.groups)
      for (unsigned int c = 0; c < dim; ++c)
        {
          // start from t: the trial states may have been moved before
          const unsigned int *nodes = active.nodes(group);
          double             *x     = trial.position(c) + group.first_point;
          double *v = trial.component(velocity + c) + group.first_point;
          for (unsigned int p = 0; p < group.n_points; ++p)
            {
              const auto &particle = *stencils.particles[group.first_point + p];
              x[p]                 = particle.get_location()[c];
              v[p]                 = particle.get_properties()[velocity + c];
            }
          for (unsigned int a = 0; a < group.n_nodes; ++a)
            {
              const double *S       = stencils.value(group, a);
              const double  node_u  = u[dim * nodes[a] + c];
              const double  node_dv = dv[dim * nodes[a] + c];
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
  sort_into_cells(const BackgroundGrid<dim>               &grid,
                  dealii::Particles::ParticleHandler<dim> &particles)
  {
    // deal.II hands particles on to neighbouring cells, which this rank knows.
    // Those that went farther may be in cells that it does not know.
    const auto n_before = particles.n_global_particles();
    std::vector<typename Stencils<dim>::ParticleIterator> far;
    std::vector<dealii::Point<dim>>                       positions;
    std::vector<std::vector<double>>                      properties;
    std::vector<dealii::types::particle_index>            ids;
    for (auto particle = particles.begin(); particle != particles.end();
         ++particle)
      {
        const dealii::Point<dim> x = grid.clamped(particle->get_location());
        particle->set_location(x);
        const auto from = particle->get_surrounding_cell()->center();
        for (unsigned int d = 0; d < dim; ++d)
          if (std::abs(x[d] - from[d]) > 1.5 * grid.cell_size()[d])
            {
              far.push_back(particle);
              positions.push_back(x);
              const auto values = particle->get_properties();
              properties.emplace_back(values.begin(), values.end());
              ids.push_back(particle->get_id());
              break;
            }
      }
    particles.remove_particles(far);
    particles.sort_particles_into_subdomains_and_cells();
    if (dealii::Utilities::MPI::max(far.size(), grid.communicator()) > 0)
      {
        const auto owned =
          dealii::GridTools::compute_mesh_predicate_bounding_box(
            grid.triangulation(), dealii::IteratorFilters::LocallyOwnedCell());
        particles.insert_global_particles(
          positions,
          dealii::Utilities::MPI::all_gather(grid.communicator(), owned),
          properties,
          ids);
      }
    throw_together(grid.communicator(),
                   "Moving particles to their cells",
                   particles.n_global_particles() == n_before
                     ? ""
                     : std::to_string(n_before -
                                      particles.n_global_particles()) +
                         " particles of " + std::to_string(n_before) +
                         " found no cell",
                   "this should not happen; please report it with the "
                   "parameter file.");
  }

  template <int dim>
  void
  grid_to_particles(const Stencils<dim>                     &stencils,
                    const PointArrays<dim>                  &accepted,
                    const FieldLayout                       &layout,
                    const BackgroundGrid<dim>               &grid,
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
                                        const ActiveGrid<dim> &,     \
                                        const BackgroundGrid<dim> &, \
                                        const FieldLayout &,         \
                                        const Vector &,              \
                                        const Vector &,              \
                                        PointArrays<dim> &);         \
  template void        grid_to_particles<dim>(                       \
    const Stencils<dim> &,                                    \
    const PointArrays<dim> &,                                 \
    const FieldLayout &,                                      \
    const BackgroundGrid<dim> &,                              \
    dealii::Particles::ParticleHandler<dim> &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
