#ifndef emmy_transfer_mass_blocks_h
#define emmy_transfer_mass_blocks_h

#include <deal.II/lac/full_matrix.h>

#include <emmy/transfer/particles_to_grid.h>

#include <functional>

namespace emmy
{
  /** A part of the effective mass M~, the same for each component. */
  struct MassBlock
  {
    const unsigned int         *nodes; ///< local indices
    dealii::FullMatrix<double> &mass;  ///< kg; the receiver may change it
    /**
     * What linear solvers add on the diagonal, kg, see GridStart::damped_mass.
     */
    const std::vector<double> &damping;
    /** Whether it is a ghost face's. */
    bool is_of_ghosts = false;
  };

  /**
   * Hand out the effective mass M~ group by group and, with ghost
   * stabilisation, face by face: their sum over the nodes is M~ (Pretti et al.
   * 2023, eqs 15, 18). Cost: a product of two shape functions for each
   * particle and pair of its nodes.
   *
   * @param masses of the points, kg
   * @param start  with active nodes, ghost faces and lumping
   * @param phases where the time of lumping is booked; null: nowhere
   */
  template <int dim>
  void
  for_each_mass_block(const Stencils<dim>                    &stencils,
                      const double                           *masses,
                      const GridStart<dim>                   &start,
                      Phases                                 *phases,
                      const std::function<void(MassBlock &)> &receive);
} // namespace emmy

#endif
