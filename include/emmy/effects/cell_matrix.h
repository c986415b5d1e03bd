#ifndef emmy_effects_cell_matrix_h
#define emmy_effects_cell_matrix_h

#include <deal.II/base/aligned_vector.h>

#include <emmy/effects/node_lanes.h>
#include <emmy/effects/point_batch.h>
#include <emmy/material/stress_rules.h>
#include <emmy/system/neighbourhood.h>

namespace emmy
{
  /** Points of a neighbourhood, and what a batch says of them. */
  template <int dim>
  struct NeighbourPoints
  {
    /** One of them. */
    struct Point
    {
      const typename Stencils<dim>::Group *group; ///< its group
      unsigned int                         q;     ///< which of its points
    };

    const Stencils<dim>      &stencils; ///< of the step
    const Neighbourhood<dim> &around;   ///< of all of them
    std::vector<Point>        points;   ///< at most most_points_at_once
    unsigned int              at = 0;   ///< the first of them in the batch
  };

  /**
   * The derivative of the internal force of points of a neighbourhood with
   * respect to its nodes, sum V0 grad S_a . dP/dH . grad S_b. Nodes stand side
   * by side, four in the plane, eight in space. Owned by who adds the force.
   *
   * Cost for a point and n nodes, multiplications and additions: dim^5 n for
   * dP/dH . grad S_b, and dim^3 n^2 for the rest: 1944 + 1728 in space with
   * linear functions. Of a neighbourhood only those fours of nodes count that
   * the point reaches.
   */
  template <int dim>
  class CellMatrix
  {
  public:
    /** Begin for so many nodes. */
    void
    reinit(const unsigned int n_nodes);

    /** Add some points. @param volumes of the batch, m^3 */
    void
    add(const NeighbourPoints<dim> &here,
        const StressBatch<dim>     &batch,
        const double               *volumes);

    /** As it stands after some points, until it begins anew. */
    ComponentBlocks
    blocks() const
    {
      return {
        sum.data(), n_nodes, dim * n_padded, 1, dim * dim * n_padded, dim};
    }

  private:
    using Group = typename Stencils<dim>::Group;

    /** Slopes of points of a group, from its point @p q on, which stand from
     * @p k on. */
    void
    add_slopes(const NeighbourPoints<dim> &here,
               const Group                &group,
               const unsigned int          q,
               const unsigned int          k,
               const unsigned int          n_points);

    unsigned int n_nodes = 0, n_padded = 0; ///< full lanes
    bool         is_empty = true;           ///< no points yet
    Reach        reach;
    /** [((a dim + i) n_padded + b) dim + j] */
    dealii::AlignedVector<double> sum;
    /** Of some points: grad S, [(q dim + L) n_padded + b]. */
    dealii::AlignedVector<double> slopes;
    /** V0 dP/dH . grad S of a register of nodes b, [(q dim^2 + iJ) dim + j]. */
    dealii::AlignedVector<double> products;
  };
} // namespace emmy

#endif
