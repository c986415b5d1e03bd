#ifndef emmy_effects_aggregation_h
#define emmy_effects_aggregation_h

#include <emmy/effects/roots.h>
#include <emmy/particles/point_arrays.h>

#include <string>
#include <utility>
#include <vector>

namespace emmy
{
  /** A node, whatever its number: its key and its velocity field. */
  template <int dim>
  using NodePlace = std::pair<CellKey<dim>, unsigned int>;

  /**
   * Which nodes are fed, and which are starved and follow others. Made once in
   * a step, from the particles as the step finds them, and held for as long as
   * the step lasts, however often stencils and roots are renewed: a node that
   * has become active since is starved; one that no particle reaches any more
   * stays fed, but only active cells can be roots.
   */
  template <int dim>
  struct NodeClasses
  {
    /** 1 for fed nodes, else 0, of all nodes that this rank knows. */
    NodeValues fed;
    /** 1 for nodes that only particles as large as half a cell reach, else 0;
     * without elements if there is no such particle on any rank.
     */
    NodeValues coarse;
    /** Of all ranks: fed in name, as no cell around has more. */
    std::uint64_t n_kept = 0;
    /** The nodes that were active and this rank owns, and whether they are
     * fed; sorted.
     */
    std::vector<std::pair<NodePlace<dim>, bool>> active;
    /** The active cells of this rank. */
    std::vector<ActiveCell<dim>> cells;

    /** Whether this rank knows the same of the same grid's nodes. */
    bool
    same_nodes_as(const NodeClasses &other) const;
  };

  /**
   * How many nodes that were active both times have changed from fed to
   * starved or back. Collective.
   * @param before of another step, perhaps on another partition; may be empty
   */
  template <int dim>
  std::uint64_t
  class_changes(const NodeClasses<dim>    &before,
                const NodeClasses<dim>    &now,
                const BackgroundGrid<dim> &grid);

  /**
   * A starved node and the nodes that it follows, its masters:
   * u_A = sum w_B u_B, also outside the cells. The weights are those of the
   * bi- or trilinear polynomial of its root, the mean of the polynomials if
   * there are several.
   */
  template <int dim>
  struct Follower
  {
    /** A node of a root. */
    struct Master
    {
      /** Of the node, as numbered over all ranks. */
      dealii::types::global_dof_index id;
      CellKey<dim> place;       ///< this rank may not know the node
      double       weight = 0.; ///< in a Follower not zero
    };

    dealii::types::global_dof_index node_id; ///< the node that follows
    std::vector<Root<dim>>          roots;   ///< sorted
    std::vector<Master>             masters; ///< sorted by place
    unsigned int distance = 0; ///< of node and roots, cells, largest component

    /**
     * @param roots not empty. The weights of one are whole numbers, so that
     *   their sum is exactly one, and that of w_B x_B is x_A as exactly as
     *   positions are known; of several, to round-off.
     */
    Follower(const dealii::types::global_dof_index node_id,
             const std::vector<Root<dim>>         &roots,
             const BackgroundGrid<dim>            &grid);

    /** Same node, root and weights. */
    bool
    operator==(const Follower &other) const
    {
      return node_id == other.node_id && roots == other.roots;
    }
  };

  /** All followers, and numbers about them that are the same on all ranks. */
  template <int dim>
  struct Aggregates
  {
    /** Those among the nodes that this rank knows. */
    std::vector<Follower<dim>> followers;
    /** Nodes that follow, over all ranks. */
    std::uint64_t n_followers = 0;
    /** Those of them that follow families, see effects/families.h. */
    std::uint64_t n_of_families = 0;
    /** Starved nodes that are free: NodeClasses::n_kept, and those of now that
     * no root is near.
     */
    std::uint64_t n_kept         = 0;
    unsigned int  farthest_root  = 0;  ///< the largest Follower::distance
    double        largest_weight = 0.; ///< in size

    /** One line for the log. */
    std::string
    text() const;
  };

  /**
   * Finds the starved nodes of a step and their roots (the idea of aggregated
   * finite elements, Badia, Verdugo and Martin 2018).
   *
   * A node is starved if its mass is below a fraction of what a full body
   * would give it: m_A < theta rho int N_A, with rho = m_p/V0_p the largest
   * density that reaches it; at a side of the grid the integral is half of
   * prod h_i. A root is an active cell all of whose nodes are fed. A starved
   * node follows the root whose centre is nearest to it; where several are
   * equally near, the mean of them.
   *
   * Where no root is within two layers of active cells, as in a lone particle
   * or a thin strip, theta is halved until a cell reaches it; the nodes of that
   * cell count as fed. So each starved node follows a root nearby, or is of the
   * best cell around; a strip does not become the rigid continuation of a cell
   * far away. All this is done in each velocity field for itself.
   *
   * Where particles are as large as cells, families of cells are roots and all
   * nodes but their corners follow, see effects/families.h.
   *
   * Only masses, places and densities decide: neither the direction of the
   * lattice nor the bodies that the mass is of, their order or their names,
   * nor the partition, nor round-off.
   *
   * Owned by the effects. Cost in a step: a pass over the values of the
   * stencils; where nodes starve, and others do than before, a pass over the
   * active cells and one exchange between neighbours for each layer.
   */
  template <int dim>
  class Aggregation
  {
  public:
    /**
     * @param mass_threshold theta, between 0 and 1
     * @param mass_component,volume_component of the particles
     */
    Aggregation(const double       mass_threshold,
                const unsigned int mass_component,
                const unsigned int volume_component);

    /**
     * Which nodes are fed. Once in a step. Collective.
     * @param before of another time, or empty: what has not changed since is
     *   not looked for again
     */
    NodeClasses<dim>
    classify(const Stencils<dim>       &stencils,
             const PointArrays<dim>    &points,
             const BackgroundGrid<dim> &grid,
             const NodeClasses<dim>    &before = {}) const;

    /**
     * The followers among the nodes that stencils reach, which may be newer
     * than the classes, on the same partition. Collective.
     */
    Aggregates<dim>
    find(const NodeClasses<dim>    &classes,
         const Stencils<dim>       &stencils,
         const BackgroundGrid<dim> &grid) const;

  private:
    const double       threshold;
    const unsigned int mass_component, volume_component;
  };
} // namespace emmy

#endif
