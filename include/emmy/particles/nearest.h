#ifndef emmy_particles_nearest_h
#define emmy_particles_nearest_h

#include <deal.II/particles/particle_handler.h>

#include <emmy/grid/background_grid.h>

#include <functional>
#include <string>
#include <vector>

namespace emmy
{
  /**
   * The particles that are nearest to some positions: how far they are. Used
   * while a scene is built, for positions that the parameter file names. Cost:
   * particles times positions.
   */
  template <int dim>
  class NearestParticles
  {
  public:
    using Positions = std::vector<dealii::Point<dim>>; ///< m
    /** Whether a particle counts. */
    using Filter =
      std::function<bool(const dealii::Particles::ParticleAccessor<dim> &)>;

    /**
     * Collective. Throws ExcParameter for a position outside the grid.
     *
     * @param positions of @p entry in @p section, m
     * @param counts    which particles may be the nearest; empty: all
     */
    NearestParticles(const Positions                               &positions,
                     const std::string                             &section,
                     const std::string                             &entry,
                     const BackgroundGrid<dim>                     &grid,
                     const dealii::Particles::ParticleHandler<dim> &particles,
                     const Filter &counts = {});

    /**
     * Whether a particle at @p place, if it counts, is as near to position
     * @p i as any, up to round-off: several can be.
     */
    bool
    is_nearest(const unsigned int i, const dealii::Point<dim> &place) const;

    /**
     * Of each position: how many particles of all ranks are nearest to it, all
     * of which count. Collective.
     */
    std::vector<unsigned int>
    numbers(const dealii::Particles::ParticleHandler<dim> &particles) const;

    /** Of each position to the nearest particle, m; infinite without one. */
    const std::vector<double> &
    distances() const;

  private:
    const Positions     positions;
    const double        tolerance; ///< lengths that differ less are equal, m
    const MPI_Comm      communicator;
    std::vector<double> lengths;
  };
} // namespace emmy

#endif
