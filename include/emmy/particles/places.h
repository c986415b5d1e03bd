#ifndef emmy_particles_places_h
#define emmy_particles_places_h

#include <deal.II/particles/particle_handler.h>

#include <emmy/grid/background_grid.h>

#include <vector>

namespace emmy
{
  /**
   * Where the particles of this rank meet the grid: their positions, cells and
   * boxes, in the order of the particle handler. The positions of the start
   * of a step, or others, e.g. those of its middle; so a particle's cell need
   * not be the one that holds it.
   */
  template <int dim>
  struct Places
  {
    /** deal.II's. */
    std::vector<dealii::Particles::ParticleIterator<dim>> particles;
    /** By particle. */
    std::vector<unsigned int> bodies;
    /** By particle, on the lattice. */
    std::vector<CellKey<dim>>       cells;
    std::vector<dealii::Point<dim>> positions; ///< m
    /** Of the boxes of GIMP, m; empty where particles are points. */
    std::vector<dealii::Tensor<1, dim>> half_lengths;

    /** Particles. */
    std::size_t
    size() const
    {
      return particles.size();
    }
  };
} // namespace emmy

#endif
