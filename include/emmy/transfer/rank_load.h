#ifndef emmy_transfer_rank_load_h
#define emmy_transfer_rank_load_h

#include <deal.II/particles/particle_handler.h>

#include <emmy/grid/background_grid.h>

namespace emmy
{
  /**
   * How unevenly the ranks are loaded: what the busiest has, over the mean of
   * all. 1: all have the same.
   */
  struct RankLoad
  {
    double work      = 1.; ///< by grid/cell_work.h
    double particles = 1.; ///< times that of a cell
  };

  /**
   * The load with particles in the cells where they are. Collective. Cost: a
   * pass over the particles and one reduction.
   */
  template <int dim>
  RankLoad
  load_of_ranks(const BackgroundGrid<dim>                     &grid,
                const dealii::Particles::ParticleHandler<dim> &particles);

  /**
   * The load when the grid was distributed, with the points that cover() was
   * given: what is uneven then cannot be helped, as cells are not cut. It is
   * the same each time that the same cells are covered. Collective.
   */
  template <int dim>
  RankLoad
  load_when_covered(const BackgroundGrid<dim> &grid);
} // namespace emmy

#endif
