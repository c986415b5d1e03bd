#ifndef emmy_effects_cell_pools_h
#define emmy_effects_cell_pools_h

#include <emmy/material/material.h>
#include <emmy/particles/stencils.h>
#include <emmy/system/couplings.h>

namespace emmy
{
  /**
   * The points of this rank by the cell that holds their particle and by
   * material, whatever their body: bodies of one material that touch are as
   * one. Points of a body that is not averaged stand alone. The cell is that of
   * the start of the step, wherever shape functions see the point; it is on the
   * rank of the particle, so no pool has points of two ranks. For
   * MeanDilatation. Cost: a search per point.
   */
  template <int dim>
  struct CellPools
  {
    /** The points of a material in a cell, and what MeanDilatation sums there.
     */
    struct Pool
    {
      double volume      = 0.; ///< V_c at t, m^3
      double change      = 0.; ///< sum V (j - 1), then theta - 1
      double stress      = 0.; ///< sum V0 Pi, then P_c, Pa
      double stress_end  = 0.; ///< sum V0 tr tau/3, then over theta V_c
      double own_by_mean = 0.; ///< sum V0 dPi/d theta, then over V_c

      /** Particles of the pool, as the stencils number them. */
      std::vector<std::size_t> points;
      /** Nodes in the grid that the points reach, each once. */
      std::vector<dealii::types::global_dof_index> node_ids;
      /** Where they stand in Couplings::node_ids. */
      std::size_t first_coupled = 0;
      /** Whether this is one point of a body that is not averaged. */
      bool is_alone = false;
    };

    /** In the order of the points, which does not depend on the window. */
    std::vector<Pool>         pools;
    std::vector<unsigned int> pool_of_point; ///< by particle
    /** By particle: its group of the stencils. */
    std::vector<std::size_t> group_of_point;

    /** The pool of particle p. */
    Pool &
    pool_of(const std::size_t p)
    {
      return pools[pool_of_point[p]];
    }

    /**
     * Find them anew: once a step.
     * @param is_averaged one per body; empty: all are
     */
    void
    find(const Stencils<dim>                      &stencils,
         const std::vector<const Material<dim> *> &material_of_body,
         const std::vector<bool>                  &is_averaged = {});

    /** All nodes of a pool meet. Those of points that are alone do anyway. */
    void
    add_to(Couplings<dim> &couplings);
  };
} // namespace emmy

#endif
