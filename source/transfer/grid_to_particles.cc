
#include <emmy/base/exceptions.h>
#include <emmy/transfer/grid_to_particles.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

namespace emmy
{
  template <int dim>
  std::string
  move_points(const Stencils<dim>       &stencils,
              const PointArrays<dim>    &points,
              const GridStart<dim>      &start,
              const BackgroundGrid<dim> &grid,
              const FieldLayout         &layout,
              const double               flip_fraction,
              const Vector              &displacement,
              const Vector              &velocity_new,
              PointArrays<dim>          &trial)
  {
    // v_p <- alpha v_p + sum S (v_new - alpha v_mapped)
    Vector velocity_change = velocity_new;
    velocity_change.add(-flip_fraction, start.mapped_velocity);
    const ActiveGrid<dim>    &active   = *start.active;
    const std::vector<double> u        = active.to_local(displacement);
    const std::vector<double> dv       = active.to_local(velocity_change);
    const unsigned int        velocity = layout["velocity"];

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

  namespace
  {
    /**
     * Insert particles that another rank may own: [x, id, fields] each, one
     * after the other. They go to all ranks whose cells span their position;
     * the one that owns the cell keeps them. Collective. (In deal.II 9.4
     * insert_global_particles() hangs if a rank receives none.)
     */
    template <int dim>
    void
    insert_anywhere(const std::vector<double>               &packed,
                    const BackgroundGrid<dim>               &grid,
                    dealii::Particles::ParticleHandler<dim> &particles)
    {
      using namespace dealii::Utilities::MPI;
      const unsigned int n_fields = particles.n_properties_per_particle(),
                         length   = dim + 1 + n_fields;
      const auto position         = [](const double *values) {
        dealii::Point<dim> x;
        for (unsigned int d = 0; d < dim; ++d)
          x[d] = values[d];
        return x;
      };

      typename BackgroundGrid<dim>::Lattice first{}, last{};
      first.fill(std::numeric_limits<unsigned int>::max());
      for (const auto &cell : grid.triangulation().active_cell_iterators())
        if (cell->is_locally_owned())
          {
            const auto index = grid.lattice(cell->center());
            for (unsigned int d = 0; d < dim; ++d)
              {
                first[d] = std::min(first[d], index[d]);
                last[d]  = std::max(last[d], index[d]);
              }
          }

      const auto boxes =
        all_gather(grid.communicator(), std::make_pair(first, last));
      std::map<unsigned int, std::vector<double>> outgoing;
      for (std::size_t i = 0; i < packed.size(); i += length)
        {
          const auto index = grid.lattice(position(&packed[i]));
          for (unsigned int rank = 0; rank < boxes.size(); ++rank)
            {
              bool is_inside = true;
              for (unsigned int d = 0; d < dim; ++d)
                is_inside = is_inside && index[d] >= boxes[rank].first[d] &&
                            index[d] <= boxes[rank].second[d];
              if (is_inside)
                outgoing[rank].insert(outgoing[rank].end(),
                                      &packed[i],
                                      &packed[i] + length);
            }
        }
      for (const auto &[sender, incoming] :
           some_to_some(grid.communicator(), outgoing))
        {
          (void)sender;
          for (std::size_t i = 0; i < incoming.size(); i += length)
            {
              const auto x    = position(&incoming[i]);
              const auto cell = grid.cell_at(grid.lattice(x));
              if (cell == grid.triangulation().end() ||
                  !cell->is_locally_owned())
                continue;
              dealii::Point<dim> reference;
              for (unsigned int d = 0; d < dim; ++d)
                reference[d] =
                  (x[d] - cell->vertex(0)[d]) / grid.cell_size()[d];
              particles.insert_particle(
                x,
                reference,
                static_cast<dealii::types::particle_index>(incoming[i + dim]),
                cell,
                dealii::ArrayView<const double>(&incoming[i + dim + 1],
                                                n_fields));
            }
        }
      particles.update_cached_numbers();
    }
  } // namespace

  template <int dim>
  void
  sort_into_cells(const BackgroundGrid<dim>               &grid,
                  dealii::Particles::ParticleHandler<dim> &particles)
  {
    // deal.II hands particles on to neighbouring cells, which this rank knows.
    // Those that went farther may be in cells that it does not know.
    const auto n_before = particles.n_global_particles();
    std::vector<typename Stencils<dim>::ParticleIterator> far;
    std::vector<double>                                   packed;
    for (auto particle = particles.begin(); particle != particles.end();
         ++particle)
      {
        const dealii::Point<dim> x = grid.clamped(particle->get_location());
        particle->set_location(x);
        const auto distance = x - particle->get_surrounding_cell()->center();
        bool       is_far   = false;
        for (unsigned int d = 0; d < dim; ++d)
          is_far = is_far || std::abs(distance[d]) > 1.5 * grid.cell_size()[d];
        if (is_far)
          {
            far.push_back(particle);
            for (unsigned int d = 0; d < dim; ++d)
              packed.push_back(x[d]);
            packed.push_back(particle->get_id());
            const auto fields = particle->get_properties();
            packed.insert(packed.end(), fields.begin(), fields.end());
          }
      }
    particles.remove_particles(far);
    particles.sort_particles_into_subdomains_and_cells();
    if (dealii::Utilities::MPI::max(far.size(), grid.communicator()) > 0)
      insert_anywhere(packed, grid, particles);

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
                                        const PointArrays<dim> &,    \
                                        const GridStart<dim> &,      \
                                        const BackgroundGrid<dim> &, \
                                        const FieldLayout &,         \
                                        const double,                \
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
