#include <emmy/effects/families.h>

#include <algorithm>

namespace emmy
{
  namespace
  {
    /** A node follows a family at most so many layers of cells away. */
    constexpr unsigned int farthest_layer = 4;

    /** Of a particle to that of a cell, from which it is coarse. */
    constexpr double coarse_volume = 0.5;
  } // namespace

  template <int dim>
  NodeValues
  coarse_nodes(const Stencils<dim>       &stencils,
               const double              *volume,
               const BackgroundGrid<dim> &grid)
  {
    std::vector<bool> is_fine; // of each group
    for (const auto &group : stencils.groups)
      {
        double least = coarse_volume;
        for (unsigned int d = 0; d < dim; ++d)
          least *= grid.size_at(group.origin)[d];
        const double *V = volume + group.first_point;
        is_fine.push_back(std::any_of(V, V + group.n_points, [&](double v) {
          return !reaches(v, least);
        }));
      }
    const auto n_coarse = std::count(is_fine.begin(), is_fine.end(), false);
    if (dealii::Utilities::MPI::max(int(n_coarse > 0), grid.communicator()) ==
        0)
      return {};
    NodeValues fine(grid.nodes()), coarse(grid.nodes());
    for (std::size_t g = 0; g < is_fine.size(); ++g)
      if (is_fine[g])
        for (unsigned int a = 0; a < stencils.groups[g].n_nodes; ++a)
          fine(stencils.node_ids[stencils.groups[g].first_node + a]) = 1.;
    fine.compress(dealii::VectorOperation::max);
    for (unsigned int i = 0; i < coarse.locally_owned_size(); ++i)
      coarse.local_element(i) = fine.local_element(i) == 0.;
    return coarse;
  }

  template <int dim>
  std::map<dealii::types::global_dof_index, std::vector<Root<dim>>>
  follow_families(const Stencils<dim>       &stencils,
                  const BackgroundGrid<dim> &grid,
                  const NodeValues          &active,
                  const NodeValues          &coarse,
                  NodeValues                &is_free)
  {
    NodeValues may_be_corner = is_free;
    may_be_corner.scale(coarse);
    may_be_corner.update_ghost_values();

    std::map<dealii::types::global_dof_index, std::vector<Root<dim>>> chosen;
    for (unsigned int field = 0; field < grid.fields().size(); ++field)
      {
        const Roots<dim> families =
          find_families(stencils, may_be_corner, grid, field, farthest_layer);
        for (unsigned int i = 0; i < active.locally_owned_size(); ++i)
          {
            const auto id = grid.nodes()->local_to_global(i);
            if (grid.fields().field(id) != field ||
                active.local_element(i) * coarse.local_element(i) == 0.)
              continue;
            auto nearest =
              nearest_roots<dim>(families, grid.node_key(id), grid);
            const bool is_corner =
              std::any_of(nearest.begin(), nearest.end(), [&](const auto &r) {
                return std::count(r.ids.begin(), r.ids.end(), id) > 0;
              });
            if (nearest.empty() || is_corner)
              continue;
            chosen[id]               = std::move(nearest);
            is_free.local_element(i) = 0.;
          }
      }
    is_free.update_ghost_values();
    return chosen;
  }

#define INSTANTIATE(dim)                                                     \
  template NodeValues coarse_nodes<dim>(const Stencils<dim> &,               \
                                        const double *,                      \
                                        const BackgroundGrid<dim> &);        \
  template std::map<dealii::types::global_dof_index, std::vector<Root<dim>>> \
  follow_families<dim>(const Stencils<dim> &,                                \
                       const BackgroundGrid<dim> &,                          \
                       const NodeValues &,                                   \
                       const NodeValues &,                                   \
                       NodeValues &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
