#ifndef emmy_effects_families_h
#define emmy_effects_families_h

#include <emmy/effects/roots.h>

/** What Aggregation (effects/aggregation.h) does where particles are as large
 * as cells.
 */
namespace emmy
{
  /**
   * With one particle per cell there are motions of the nodes that no particle
   * sees: neither its velocity nor its strain. Forces know nothing of them, so
   * Newton wanders. There nodes move as those of cells twice as large: the
   * corners of families are free, all others follow the bi- or trilinear
   * polynomial of the nearest family. Rigid motions and constant strains are
   * among these motions, so that nothing is lost, as with starved nodes.
   *
   * @return 1 for nodes that only particles reach whose volume at the start,
   *   V0, is at least half a cell's, and for those that none reaches, else 0;
   *   without elements if there is no such particle on any rank. Collective.
   * @param volume V0 of each point, m^dim. Cost: a pass over them.
   */
  template <int dim>
  NodeValues
  coarse_nodes(const Stencils<dim>       &stencils,
               const double              *volume,
               const BackgroundGrid<dim> &grid);

  /**
   * Who follows families. Collective.
   *
   * @param active  not zero for nodes that particles reach
   * @param coarse  coarse_nodes()
   * @param is_free 1 for fed nodes, else 0; zero afterwards for those that
   *   follow families too. Ghosts are up to date.
   * @return by id of an owned node the families nearest to it
   */
  template <int dim>
  std::map<dealii::types::global_dof_index, std::vector<Root<dim>>>
  follow_families(const Stencils<dim>       &stencils,
                  const BackgroundGrid<dim> &grid,
                  const NodeValues          &active,
                  const NodeValues          &coarse,
                  NodeValues                &is_free);
} // namespace emmy

#endif
