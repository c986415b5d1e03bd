#ifndef emmy_transfer_particle_parcel_h
#define emmy_transfer_particle_parcel_h

#include <deal.II/particles/particle_handler.h>

#include <emmy/grid/background_grid.h>

#include <vector>

namespace emmy
{
  /**
   * Particles on their way to another rank, or to a file: place of the cell,
   * position, id and fields of each, as plain numbers.
   */
  template <int dim>
  class Parcel
  {
  public:
    /** For particles of that many numbers. */
    explicit Parcel(const unsigned int n_fields)
      : length(2 * dim + 1 + n_fields)
    {}

    /** Put a particle in. */
    void
    add(const CellKey<dim>                             &place,
        const dealii::Particles::ParticleAccessor<dim> &particle);

    /** In the parcel. */
    std::size_t
    n_particles() const
    {
      return values.size() / length;
    }

    /** Numbers of a particle. */
    std::size_t
    n_numbers() const
    {
      return length;
    }

    /** On the lattice. */
    CellKey<dim>
    place(const std::size_t i) const;

    /** Insert a particle if this rank owns its cell. */
    bool
    unpack(const std::size_t                        i,
           const BackgroundGrid<dim>               &grid,
           dealii::Particles::ParticleHandler<dim> &particles) const;

    /** Hand a copy of a particle to another parcel. */
    void
    hand_on(const std::size_t i, std::vector<double> &other) const;

    std::vector<double> values; ///< of all particles, one after the other

  private:
    const std::size_t length;
  };

  /**
   * Put particles into their cells, whoever owns these, behind those that are
   * there, in the order of the parcel. Collective.
   */
  template <int dim>
  void
  deliver(const Parcel<dim>                       &parcel,
          const BackgroundGrid<dim>               &grid,
          dealii::Particles::ParticleHandler<dim> &particles);

  /**
   * Take all particles out, and choose the window of these cells: see
   * BackgroundGrid::cover(). Collective.
   */
  template <int dim>
  void
  open_window(const std::vector<typename BackgroundGrid<dim>::Occupied> &cells,
              BackgroundGrid<dim>                                       &grid,
              dealii::Particles::ParticleHandler<dim> &particles);
} // namespace emmy

#endif
