#ifndef emmy_transfer_lumped_grid_h
#define emmy_transfer_lumped_grid_h

#include <emmy/particles/field_layout.h>
#include <emmy/particles/point_arrays.h>
#include <emmy/system/active_grid.h>

#include <vector>

namespace emmy
{
  /**
   * Below this part of the largest mass of a node, a node counts as massless:
   * it moves with the particles near it, and no force acts on it. So small
   * that only particles exactly on faces make such nodes; a corner of a box of
   * GIMP that just enters a cell in space gives the new node 1e-18.
   */
  constexpr double least_nodal_mass = 1e-24;

  /**
   * What the grid of an explicit step knows at its start, at the local nodes
   * and complete there. Made anew in each step.
   */
  template <int dim>
  struct LumpedGrid
  {
    std::vector<double> mass;     ///< m_A = sum m_p S_Ap, kg: [node]
    std::vector<double> momentum; ///< sum m_p S_Ap v_p: [dim * node + c]
    /** p/m; of a massless node the mean of the particles that reach it. */
    std::vector<double> velocity;
    std::vector<bool>   is_massless; ///< [node]
  };

  /**
   * Lumped mass and momentum of the particles. Cost: a pass over them; a
   * second one over those that reach massless nodes. Collective.
   */
  template <int dim>
  LumpedGrid<dim>
  particles_to_lumped_grid(const Stencils<dim>    &stencils,
                           const PointArrays<dim> &points,
                           const FieldLayout      &layout,
                           const ActiveGrid<dim>  &active);
} // namespace emmy

#endif
