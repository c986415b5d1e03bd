#ifndef emmy_transfer_mass_blocks_h
#define emmy_transfer_mass_blocks_h

#include <emmy/transfer/particles_to_grid.h>

namespace emmy
{
  /**
   * Hand out the effective mass M~ group by group, with what effects add to
   * it: their sum over the nodes is M~ (Pretti et al. 2023, eqs 15, 18). Cost:
   * a product of two shape functions for each particle and pair of its nodes.
   *
   * @param masses of the points, kg
   * @param start  with active nodes, the effects' mass and lumping
   * @param phases where the time of lumping is booked; null: nowhere
   */
  template <int dim>
  void
  for_each_mass_block(const Stencils<dim>  &stencils,
                      const double         *masses,
                      const GridStart<dim> &start,
                      Phases               *phases,
                      const MassReceiver   &receive);
} // namespace emmy

#endif
