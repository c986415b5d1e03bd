#ifndef emmy_transfer_mass_blocks_h
#define emmy_transfer_mass_blocks_h

#include <emmy/transfer/particles_to_grid.h>

namespace emmy
{
  /**
   * What linear solvers add on the diagonal of a node, kg, from its lumped
   * mass in some points or of one point, and the mass of these points.
   * The second part is for nodes with S = 0 at all points; it must be far below
   * any S^2 that is not zero.
   */
  inline double
  damping_of(const double lumped, const double total)
  {
    return mass_damping * lumped + 1e-30 * total;
  }

  /**
   * Add M~ u to an array over the local nodes, [dim * node + c], without
   * summing M~. @p start and @p masses as below.
   */
  template <int dim>
  void
  add_mass_times(const std::vector<double> &u,
                 const Stencils<dim>       &stencils,
                 const double              *masses,
                 const GridStart<dim>      &start,
                 std::vector<double>       &result);

  /**
   * Hand out the effective mass M~ neighbourhood by neighbourhood, with what
   * effects add to it: their sum over the nodes is M~ (Pretti et al. 2023, eqs
   * 15, 18). Cost: a product of two shape functions for each particle and pair
   * of its nodes.
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
