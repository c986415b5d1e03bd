#include <emmy/base/exceptions.h>
#include <emmy/transfer/particle_sort.h>

#include <map>

namespace emmy
{
  namespace
  {
    /** Particles on their way: place, position, id and fields of each. */
    template <int dim>
    class Parcel
    {
    public:
      explicit Parcel(const unsigned int n_fields)
        : length(2 * dim + 1 + n_fields)
      {}

      void
      add(const CellKey<dim>                             &place,
          const dealii::Particles::ParticleAccessor<dim> &particle)
      {
        const dealii::Point<dim> x      = particle.get_location();
        const auto               fields = particle.get_properties();
        for (const unsigned int coordinate : place)
          values.push_back(coordinate);
        for (unsigned int d = 0; d < dim; ++d)
          values.push_back(x[d]);
        values.push_back(particle.get_id());
        values.insert(values.end(), fields.begin(), fields.end());
      }

      std::size_t
      n_particles() const
      {
        return values.size() / length;
      }

      CellKey<dim>
      place(const std::size_t i) const
      {
        CellKey<dim> result;
        for (unsigned int d = 0; d < dim; ++d)
          result[d] = values[i * length + d];
        return result;
      }

      /** Insert a particle if this rank owns its cell. */
      bool
      unpack(const std::size_t                        i,
             const BackgroundGrid<dim>               &grid,
             dealii::Particles::ParticleHandler<dim> &particles) const
      {
        const auto cell = grid.cell_at(place(i));
        if (cell == grid.triangulation().end() || !cell->is_locally_owned())
          return false;
        const double      *from = &values[i * length + dim];
        dealii::Point<dim> x;
        for (unsigned int d = 0; d < dim; ++d)
          x[d] = from[d];
        particles.insert_particle(
          x,
          grid.reference_position(place(i), x),
          static_cast<dealii::types::particle_index>(from[dim]),
          cell,
          dealii::ArrayView<const double>(from + dim + 1,
                                          length - 2 * dim - 1));
        return true;
      }

      /** Move a particle to another parcel. */
      void
      hand_on(const std::size_t i, std::vector<double> &other) const
      {
        other.insert(other.end(),
                     values.begin() + i * length,
                     values.begin() + (i + 1) * length);
      }

      std::vector<double> values;

    private:
      const std::size_t length;
    };

    /** Put particles into their cells, whoever owns these. Collective. */
    template <int dim>
    void
    deliver(const Parcel<dim>                       &parcel,
            const BackgroundGrid<dim>               &grid,
            dealii::Particles::ParticleHandler<dim> &particles)
    {
      using namespace dealii::Utilities::MPI;
      std::map<unsigned int, std::vector<double>> outgoing;
      for (std::size_t i = 0; i < parcel.n_particles(); ++i)
        if (!parcel.unpack(i, grid, particles))
          for (const unsigned int rank : grid.possible_owners(parcel.place(i)))
            if (rank != this_mpi_process(grid.communicator()))
              parcel.hand_on(i, outgoing[rank]);
      // (in deal.II 9.4 insert_global_particles() hangs if a rank gets none)
      if (max(outgoing.size(), grid.communicator()) > 0)
        for (const auto &[sender, values] :
             some_to_some(grid.communicator(), outgoing))
          {
            (void)sender;
            Parcel<dim> incoming(particles.n_properties_per_particle());
            incoming.values = values;
            for (std::size_t i = 0; i < incoming.n_particles(); ++i)
              incoming.unpack(i, grid, particles);
          }
      particles.update_cached_numbers();
    }

    /** The window for these particles. Nothing else may be in the handler. */
    template <int dim>
    void
    move_window(const Parcel<dim>                       &parcel,
                BackgroundGrid<dim>                     &grid,
                dealii::Particles::ParticleHandler<dim> &particles)
    {
      const unsigned int n_fields = particles.n_properties_per_particle();
      particles.clear();
      std::map<CellKey<dim>, unsigned int> n_points;
      for (std::size_t i = 0; i < parcel.n_particles(); ++i)
        ++n_points[parcel.place(i)];
      grid.cover({n_points.begin(), n_points.end()});
      particles.initialize(grid.triangulation(), grid.mapping(), n_fields);
      particles.reserve(parcel.n_particles());
    }
  } // namespace

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
        for (const auto &particle : particles)
          moving.add(grid.key_of(particle.get_surrounding_cell()), particle);
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
