#ifndef emmy_transfer_aggregation_h
#define emmy_transfer_aggregation_h

#include <emmy/particles/point_arrays.h>
#include <emmy/particles/stencils.h>

#include <array>
#include <string>
#include <vector>

namespace emmy
{
  /**
   * A starved node and its root, the cell whose bi- or trilinear polynomial it
   * follows: u_A = sum N_B(x_A) u_B over the root's nodes B, also outside the
   * cell.
   */
  template <int dim>
  struct Follower
  {
    static constexpr unsigned int n_roots = BackgroundGrid<dim>::nodes_per_cell;
    using Ids = std::array<dealii::types::global_dof_index, n_roots>;

    dealii::types::global_dof_index       node_id;
    typename BackgroundGrid<dim>::Lattice root;
    Ids root_ids; ///< its nodes, in deal.II's vertex order
    /**
     * N_B(x_A). All are whole numbers, so that their sum is exactly one, and
     * that of N_B x_B is x_A as exactly as positions are known.
     */
    std::array<double, n_roots> weights;
    unsigned int distance = 0; ///< of node and root, cells, largest component

    bool
    operator==(const Follower &other) const
    {
      return node_id == other.node_id && root == other.root;
    }

    /** The position of a node of the root, which this rank may not know, m. */
    dealii::Point<dim>
    root_position(const unsigned int         vertex,
                  const BackgroundGrid<dim> &grid) const;
  };

  /** All followers, and numbers about them that are the same on all ranks. */
  template <int dim>
  struct Aggregates
  {
    /** Those among the nodes that this rank knows. */
    std::vector<Follower<dim>> followers;
    std::uint64_t              n_followers = 0;
    /** Starved nodes of roots that the bar was lowered for. */
    std::uint64_t n_kept         = 0;
    unsigned int  farthest_root  = 0;  ///< the largest Follower::distance
    double        largest_weight = 0.; ///< in size

    /** One line for the log. */
    std::string
    text() const;
  };

  /** The name of the effect, in parameter files and the table of times. */
  constexpr const char *aggregation_effect = "aggregation";

  /**
   * Finds the starved nodes of a step and their roots (the idea of aggregated
   * finite elements, Badia, Verdugo and Martin 2018).
   *
   * A node is starved if its mass is below a fraction of what a full body
   * would give it: m_A < theta rho int N_A, with rho = m_p/V0_p the largest
   * density that reaches it; at a side of the grid the integral is half of
   * prod h_i. A root is an active cell all of whose nodes are fed.
   *
   * A cell that is no root takes, layer by layer, the nearest of the roots that
   * its neighbours have (across faces, edges and corners; cells that the same
   * body overlaps). Where no root is within two layers, as in a lone particle
   * or a thin strip, theta is halved until a cell reaches it; that cell is a
   * root then, and its nodes are free. So each starved node follows a root
   * nearby, or is of the best cell around; a strip does not become the rigid
   * continuation of a cell far away.
   *
   * A node takes the nearest root of its cells, of those of the body that gives
   * it most mass. Ties go to the root that comes first in the lattice. So the
   * choice does not depend on the partition or on round-off.
   *
   * Owned by the effect. Cost in a step: a pass over the values of the
   * stencils, however many bodies there are, a sort of what groups of particles
   * give their nodes, and one exchange between neighbours for each layer.
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

    /** Collective. */
    Aggregates<dim>
    operator()(const Stencils<dim>       &stencils,
               const PointArrays<dim>    &points,
               const BackgroundGrid<dim> &grid) const;

  private:
    const double       threshold;
    const unsigned int mass_component, volume_component;
  };
} // namespace emmy

#endif
