#ifndef emmy_effects_cell_matrix_h
#define emmy_effects_cell_matrix_h

#include <deal.II/base/aligned_vector.h>

#include <emmy/material/stress_rules.h>
#include <emmy/particles/stencils.h>
#include <emmy/system/node_graph.h>

namespace emmy
{
  /**
   * The derivative of the internal force of a group of points with respect to
   * its nodes, sum V0 grad S_a . dP/dH . grad S_b. Nodes stand side by side,
   * four in the plane, eight in space. Owned by who adds the force.
   *
   * Cost for a point and n nodes, multiplications and additions: dim^5 n for
   * dP/dH . grad S_b, and dim^3 n^2 for the rest: 1944 + 1728 in space with
   * linear functions.
   */
  template <int dim>
  class CellMatrix
  {
  public:
    /** Points of a group, and what a batch says of them. */
    struct Points
    {
      const Stencils<dim> &stencils; ///< of the step
      /** The particles of one body in the cell. */
      const typename Stencils<dim>::Group &group;
      unsigned int                         first;   ///< point of the group
      const StressBatch<dim>              &batch;   ///< of the points from that
      const double                        *volumes; ///< likewise, m^3
    };

    /** Begin for a group with so many nodes. */
    void
    reinit(const unsigned int n_nodes);

    /** Add particles of the group. */
    void
    add(const Points &points);

    /** As it stands after some points, until it begins anew. */
    ComponentBlocks
    blocks() const
    {
      return {sum.data(),
              n_nodes,
              dim * n_padded * n_padded,
              n_padded * n_padded,
              n_padded};
    }

  private:
    unsigned int n_nodes = 0, n_padded = 0; ///< full lanes
    bool         is_empty = true;           ///< no points yet
    /** [((i dim + j) n_padded + a) n_padded + b] */
    dealii::AlignedVector<double> sum;
    /** Of some points: grad S, [(q dim + L) n_padded + b]. */
    dealii::AlignedVector<double> slopes;
    /** V0 dP/dH . grad S, [((q dim^2 + iJ) dim + j) n_padded + b]. */
    dealii::AlignedVector<double> products;
  };
} // namespace emmy

#endif
