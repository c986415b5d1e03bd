#ifndef emmy_effects_roots_h
#define emmy_effects_roots_h

#include <deal.II/lac/la_parallel_vector.h>

#include <emmy/particles/stencils.h>

#include <array>
#include <map>
#include <vector>

/** What Aggregation (effects/aggregation.h) is made of: the search for roots.
 */
namespace emmy
{
  /** Numbers this close count as equal, whatever round-off says; relative. */
  constexpr double tie = 1e-9;

  /** Whether a number is at least a bar, up to round-off. */
  inline bool
  reaches(const double number, const double bar)
  {
    return number >= bar * (1. - tie);
  }

  /** A number for each node that a rank knows. */
  using NodeValues = dealii::LinearAlgebra::distributed::Vector<double>;

  /**
   * An active cell all of whose nodes are fed, or a family of such cells: the
   * 2^dim that make up a cell twice as large.
   */
  template <int dim>
  struct Root
  {
    CellKey<dim> cell; ///< on the lattice of the grid; of a family the lowest
    std::array<dealii::types::global_dof_index,
               BackgroundGrid<dim>::nodes_per_cell>
                 ids;      ///< of its corners, in deal.II's vertex order
    unsigned int span = 1; ///< cells along it: 2 for a family

    /** By place. */
    bool
    operator<(const Root &other) const
    {
      return cell != other.cell ? cell < other.cell : span < other.span;
    }
    /** Same place. */
    bool
    operator==(const Root &other) const
    {
      return cell == other.cell && span == other.span;
    }
  };

  /** By place of an active cell: the roots that it has found, sorted. */
  template <int dim>
  using Roots = std::map<CellKey<dim>, std::vector<Root<dim>>>;

  /**
   * The roots of the active cells of this rank and beside it. A root has found
   * itself. Layer by layer, a cell that has none takes all those of the active
   * cells around it, across faces, edges and corners: walks through active
   * cells, so that what a gap parts does not meet. Bodies do not matter, but
   * for their velocity field: cells and nodes are those of one. Collective.
   *
   * @param is_fed   1 for fed nodes, else 0; ghosts are up to date
   * @param n_layers a cell takes no root that is more layers away
   */
  template <int dim>
  Roots<dim>
  find_roots(const Stencils<dim>       &stencils,
             const NodeValues          &is_fed,
             const BackgroundGrid<dim> &grid,
             const unsigned int         field,
             const unsigned int         n_layers);

  /**
   * The families of active cells all of whose nodes are fed, spread over the
   * layers of cells as find_roots() does. Collective.
   *
   * A family is what deal.II makes of one cell by refining it, so that one rank
   * owns all of it.
   */
  template <int dim>
  Roots<dim>
  find_families(const Stencils<dim>       &stencils,
                const NodeValues          &is_fed,
                const BackgroundGrid<dim> &grid,
                const unsigned int         field,
                const unsigned int         n_layers);

  /**
   * Of the roots of the cells around a node those whose centres are nearest to
   * it, all that are equally near, sorted; empty if there is none.
   */
  template <int dim>
  std::vector<Root<dim>>
  nearest_roots(const Roots<dim>          &roots,
                const CellKey<dim>        &node,
                const BackgroundGrid<dim> &grid);

  /**
   * Tell each rank that knows a node the roots that the node's owner has
   * chosen. Collective.
   *
   * @param chosen by id of an owned node
   * @return the same, with those of nodes that others own
   */
  template <int dim>
  std::map<dealii::types::global_dof_index, std::vector<Root<dim>>>
  share_roots(
    std::map<dealii::types::global_dof_index, std::vector<Root<dim>>> chosen,
    const BackgroundGrid<dim>                                        &grid);
} // namespace emmy

#endif
