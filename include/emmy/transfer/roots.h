#ifndef emmy_transfer_roots_h
#define emmy_transfer_roots_h

#include <deal.II/lac/la_parallel_vector.h>

#include <emmy/transfer/active_cells.h>

#include <array>
#include <map>
#include <vector>

/** What Aggregation (transfer/aggregation.h) is made of: the search for roots.
 */
namespace emmy
{
  /** A cell takes no root that is more layers of cells away. */
  constexpr unsigned int farthest_layer = 2;

  /** Numbers this close count as equal, whatever round-off says. */
  constexpr double tie = 1e-8;

  /** Whether a number is at least a bar, up to round-off. */
  inline bool
  reaches(const double number, const double bar)
  {
    return number >= bar * (1. - tie);
  }

  /** How the nodes of the grid are fed. */
  struct Feeding
  {
    using Values = dealii::LinearAlgebra::distributed::Vector<double>;

    /** Mass, as a part of a full body's, of all nodes known to this rank. */
    Values part;
    /** At owned nodes: 1 if a node does not follow, else 0. */
    Values is_free;
    /** Active nodes that this rank owns, as local indices. */
    std::vector<unsigned int> active;
    /** The body that gives an owned node most. */
    std::vector<unsigned int> body;
  };

  /** The root that a cell has found. */
  template <int dim>
  struct Root
  {
    unsigned int                          layer; ///< 0: the cell itself
    typename BackgroundGrid<dim>::Lattice cell;
    std::array<dealii::types::global_dof_index,
               BackgroundGrid<dim>::nodes_per_cell>
      ids; ///< of its nodes
  };

  template <int dim>
  using Roots = std::map<CellOfBody<dim>, Root<dim>>;

  /**
   * The roots of all active cells of this rank and beside it, as Aggregation
   * tells. Nodes of roots below the threshold become free. Collective.
   */
  template <int dim>
  Roots<dim>
  find_roots(const Stencils<dim>       &stencils,
             const double               threshold,
             const BackgroundGrid<dim> &grid,
             Feeding                   &nodes);

  /**
   * The preferred root of the cells in a box, seen by a body; null if they have
   * none: that of the lowest layer, then the nearest, then the first in the
   * lattice.
   *
   * @param first lower corner of the box, n cells wide
   * @param place from which distances count, in half cells
   */
  template <int dim>
  const Root<dim> *
  preferred(const Roots<dim>           &roots,
            const std::array<int, dim> &first,
            const int                   n,
            const unsigned int          body,
            const std::array<int, dim> &place,
            const BackgroundGrid<dim>  &grid);
} // namespace emmy

#endif
