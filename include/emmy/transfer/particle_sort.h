#ifndef emmy_transfer_particle_sort_h
#define emmy_transfer_particle_sort_h

#include <deal.II/particles/particle_handler.h>

#include <emmy/grid/background_grid.h>

#include <functional>

namespace emmy
{
  /**
   * Hand particles to the cells and ranks of their positions, however far
   * they went. A particle that is still in its cell, or on one of its faces,
   * stays there; another one goes to the cell above its position. One that is
   * outside the grid by round-off is put on its edge. If a cell that is
   * entered, or one beside it, is not in the grid's window, the window is
   * chosen anew. Collective. Throws ExcRun on all ranks if a particle got
   * lost.
   *
   * Used at the end of each step, when nothing refers to cells any more. Cost:
   * proportional to the particles; a new window costs about as much as a
   * step, and is due when a body has moved by a block of cells.
   */
  template <int dim>
  void
  sort_into_cells(BackgroundGrid<dim>                     &grid,
                  dealii::Particles::ParticleHandler<dim> &particles);

  /**
   * Choose the window of the particles as they are, and distribute its cells
   * with them over the ranks: see BackgroundGrid::cover(). Particles of a cell
   * keep their order. Cost: about as much as a step. Collective.
   */
  template <int dim>
  void
  distribute_anew(BackgroundGrid<dim>                     &grid,
                  dealii::Particles::ParticleHandler<dim> &particles);

  /** Where a particle shall be sorted to, m. */
  template <int dim>
  using PlaceOf = std::function<dealii::Point<dim>(
    const dealii::Particles::ParticleAccessor<dim> &)>;

  /**
   * The same for other places than the particles' positions, which stay. One
   * outside the grid counts as the nearest inside.
   */
  template <int dim>
  void
  sort_into_cells(BackgroundGrid<dim>                     &grid,
                  dealii::Particles::ParticleHandler<dim> &particles,
                  const PlaceOf<dim>                      &place_of);
} // namespace emmy

#endif
