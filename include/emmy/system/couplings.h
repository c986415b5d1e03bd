#ifndef emmy_system_couplings_h
#define emmy_system_couplings_h

#include <deal.II/base/point.h>
#include <deal.II/base/types.h>

#include <deal.II/lac/full_matrix.h>

#include <functional>
#include <utility>
#include <vector>

namespace emmy
{
  template <int dim>
  class ActiveGrid;

  /**
   * A node whose unknowns others give: u_A = sum w_B u_B over its masters, in
   * each component.
   */
  template <int dim>
  struct TiedNode
  {
    /** Whom a tied node follows. */
    struct Master
    {
      dealii::types::global_dof_index id;     ///< over all ranks
      double                          weight; ///< of its motion
      dealii::Point<dim> position; ///< this rank may not know the node

      /** Same node and weight. */
      bool
      operator==(const Master &other) const
      {
        return id == other.id && weight == other.weight;
      }
    };

    dealii::types::global_dof_index id;      ///< in the background grid
    std::vector<Master>             masters; ///< with weights

    /** Same node and masters. */
    bool
    operator==(const TiedNode &other) const
    {
      return id == other.id && masters == other.masters;
    }
  };

  /** A part of the effective mass M~, the same for each component. */
  struct MassBlock
  {
    const unsigned int         *nodes; ///< local indices
    dealii::FullMatrix<double> &mass;  ///< kg; the receiver may change it
    /** What linear solvers add on the diagonal, kg: see GridStart::damping.
     */
    const std::vector<double> &damping;
  };

  /** Takes the blocks of a mass matrix, one after the other. */
  using MassReceiver = std::function<void(MassBlock &)>;

  /** What effects add to the grid of a step. */
  template <int dim>
  struct Couplings
  {
    /** Nodes that meet in matrices without sharing a particle: ids of the
     * background grid, group by group. */
    std::vector<dealii::types::global_dof_index> node_ids;
    /** Of cells whose nodes are coupled with one another. */
    std::vector<unsigned int> group_sizes;
    /**
     * Nodes among them that are beyond this rank's part of the grid, and where
     * they are; and whether any rank has one.
     */
    std::vector<std::pair<dealii::types::global_dof_index, dealii::Point<dim>>>
         far_nodes;
    bool has_far_nodes = false; ///< whether some are not in this rank's cells

    /** Among the nodes that this rank knows, and whether any rank has one. */
    std::vector<TiedNode<dim>> tied_nodes;
    bool                       has_tied_nodes = false; ///< on any rank

    /** Hands out mass that no particle carries; null: there is none. */
    std::function<void(const ActiveGrid<dim> &, const MassReceiver &)>
      hand_out_mass = nullptr;
  };
} // namespace emmy

#endif
