#include <emmy/base/exceptions.h>
#include <emmy/transfer/particle_parcel.h>
#include <emmy/transfer/particle_sort.h>

#include <map>

namespace emmy
{
  namespace
  {
    /** Add all particles, each with its cell. */
    template <int dim>
    void
    pack(const dealii::Particles::ParticleHandler<dim> &particles,
         const BackgroundGrid<dim>                     &grid,
         Parcel<dim>                                   &parcel)
    {
      parcel.values.reserve(parcel.values.size() +
                            particles.n_locally_owned_particles() *
                              parcel.n_numbers());
      for (const auto &particle : particles)
        parcel.add(grid.key_of(particle.get_surrounding_cell()), particle);
    }

    /** The window for these particles. Nothing else may be in the handler. */
    template <int dim>
    void
    move_window(const Parcel<dim>                       &parcel,
                BackgroundGrid<dim>                     &grid,
                dealii::Particles::ParticleHandler<dim> &particles)
    {
      std::map<CellKey<dim>, unsigned int> n_points;
      for (std::size_t i = 0; i < parcel.n_particles(); ++i)
        ++n_points[parcel.place(i)];
      open_window<dim>({n_points.begin(), n_points.end()}, grid, particles);
      particles.reserve(parcel.n_particles());
    }
  } // namespace

  template <int dim>
  void
  distribute_anew(BackgroundGrid<dim>                     &grid,
                  dealii::Particles::ParticleHandler<dim> &particles)
  {
    Parcel<dim> parcel(particles.n_properties_per_particle());
    pack(particles, grid, parcel);
    move_window(parcel, grid, particles);
    deliver(parcel, grid, particles);
  }

  template <int dim>
  void
  sort_into_cells(BackgroundGrid<dim>                     &grid,
                  dealii::Particles::ParticleHandler<dim> &particles)
  {
    for (auto &particle : particles)
      particle.set_location(grid.clamped(particle.get_location()));
    sort_into_cells<dim>(grid, particles, [](const auto &particle) {
      return particle.get_location();
    });
  }

  template <int dim>
  void
  sort_into_cells(BackgroundGrid<dim>                     &grid,
                  dealii::Particles::ParticleHandler<dim> &particles,
                  const PlaceOf<dim>                      &place_of)
  {
    const auto n_before = particles.n_global_particles();
    std::vector<dealii::Particles::ParticleIterator<dim>> leaving;
    Parcel<dim> moving(particles.n_properties_per_particle());
    bool        fits = true;
    for (auto particle = particles.begin(); particle != particles.end();)
      {
        const auto         cell  = particle->get_surrounding_cell();
        const CellKey<dim> place = grid.key_of(cell);
        for (; particle != particles.end() &&
               particle->get_surrounding_cell() == cell;
             ++particle)
          {
            const dealii::Point<dim> x = grid.clamped(place_of(*particle));
            if (grid.is_in_cell(place, x))
              continue;
            leaving.push_back(particle);
            moving.add(grid.key_of(x), *particle);
            fits = fits && grid.window().has_surroundings_of(grid.key_of(x));
          }
      }
    particles.remove_particles(leaving);
    if (dealii::Utilities::MPI::min(fits ? 1 : 0, grid.communicator()) == 0)
      {
        pack(particles, grid, moving);
        move_window(moving, grid, particles);
      }
    deliver(moving, grid, particles);

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

  template void
  distribute_anew<2>(BackgroundGrid<2> &,
                     dealii::Particles::ParticleHandler<2> &);
  template void
  distribute_anew<3>(BackgroundGrid<3> &,
                     dealii::Particles::ParticleHandler<3> &);
  template void
  sort_into_cells<2>(BackgroundGrid<2> &,
                     dealii::Particles::ParticleHandler<2> &);
  template void
  sort_into_cells<3>(BackgroundGrid<3> &,
                     dealii::Particles::ParticleHandler<3> &);
  template void
  sort_into_cells<2>(BackgroundGrid<2> &,
                     dealii::Particles::ParticleHandler<2> &,
                     const PlaceOf<2> &);
  template void
  sort_into_cells<3>(BackgroundGrid<3> &,
                     dealii::Particles::ParticleHandler<3> &,
                     const PlaceOf<3> &);
} // namespace emmy
