#include <emmy/transfer/particle_parcel.h>

#include <algorithm>
#include <map>

namespace emmy
{
  template <int dim>
  void
  Parcel<dim>::add(const CellKey<dim>                             &place,
                   const dealii::Particles::ParticleAccessor<dim> &particle)
  {
    const dealii::Point<dim> x      = particle.get_location();
    const auto               fields = particle.get_properties();
    values.resize(values.size() + length);
    double *number = values.data() + values.size() - length;
    number         = std::copy(place.begin(), place.end(), number);
    for (unsigned int d = 0; d < dim; ++d)
      *number++ = x[d];
    *number++ = particle.get_id();
    std::copy(fields.begin(), fields.end(), number);
  }

  template <int dim>
  CellKey<dim>
  Parcel<dim>::place(const std::size_t i) const
  {
    CellKey<dim> result;
    for (unsigned int d = 0; d < dim; ++d)
      result[d] = values[i * length + d];
    return result;
  }

  template <int dim>
  bool
  Parcel<dim>::unpack(const std::size_t                        i,
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
      dealii::ArrayView<const double>(from + dim + 1, length - 2 * dim - 1));
    return true;
  }

  template <int dim>
  void
  Parcel<dim>::hand_on(const std::size_t i, std::vector<double> &other) const
  {
    other.insert(other.end(),
                 values.begin() + i * length,
                 values.begin() + (i + 1) * length);
  }

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

  template <int dim>
  void
  open_window(const std::vector<typename BackgroundGrid<dim>::Occupied> &cells,
              BackgroundGrid<dim>                                       &grid,
              dealii::Particles::ParticleHandler<dim> &particles)
  {
    const unsigned int n_fields = particles.n_properties_per_particle();
    particles.clear();
    grid.cover(cells);
    particles.initialize(grid.triangulation(), grid.mapping(), n_fields);
  }

#define INSTANTIATE(dim)                                                 \
  template class Parcel<dim>;                                            \
  template void deliver<dim>(const Parcel<dim> &,                        \
                             const BackgroundGrid<dim> &,                \
                             dealii::Particles::ParticleHandler<dim> &); \
  template void open_window<dim>(                                        \
    const std::vector<typename BackgroundGrid<dim>::Occupied> &,         \
    BackgroundGrid<dim> &,                                               \
    dealii::Particles::ParticleHandler<dim> &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
