#include <emmy/effects/cell_pools.h>

#include <algorithm>
#include <map>

namespace emmy
{
  template <int dim>
  void
  CellPools<dim>::find(
    const Stencils<dim>                      &stencils,
    const std::vector<const Material<dim> *> &material_of_body,
    const std::vector<bool>                  &is_averaged)
  {
    const std::size_t n = stencils.particles.size();
    pools.clear();
    pool_of_point.resize(n);
    group_of_point.resize(n);
    std::map<std::pair<unsigned int, const Material<dim> *>, unsigned int>
      pool_of;
    for (std::size_t g = 0; g < stencils.groups.size(); ++g)
      {
        const auto &group    = stencils.groups[g];
        const auto *material = material_of_body[group.body];
        const bool  is_alone = !is_averaged.empty() && !is_averaged[group.body];
        for (std::size_t p = group.first_point;
             p < group.first_point + group.n_points;
             ++p)
          {
            const unsigned int cell = stencils.particles[p]
                                        ->get_surrounding_cell()
                                        ->active_cell_index();
            unsigned int index = pools.size();
            if (!is_alone)
              index =
                pool_of.try_emplace({cell, material}, index).first->second;
            if (index == pools.size())
              pools.emplace_back();
            Pool &pool    = pools[index];
            pool.is_alone = is_alone;
            pool.points.push_back(p);
            pool_of_point[p] = index;
            const bool is_next_of_group =
              pool.points.size() > 1 &&
              group_of_point[pool.points[pool.points.size() - 2]] == g;
            group_of_point[p] = g;
            if (!is_next_of_group)
              pool.node_ids.insert(pool.node_ids.end(),
                                   stencils.node_ids.begin() + group.first_node,
                                   stencils.node_ids.begin() +
                                     group.first_node + group.n_nodes);
          }
      }
    for (Pool &pool : pools)
      {
        std::sort(pool.node_ids.begin(), pool.node_ids.end());
        pool.node_ids.erase(std::unique(pool.node_ids.begin(),
                                        pool.node_ids.end()),
                            pool.node_ids.end());
      }
  }

  template <int dim>
  void
  CellPools<dim>::add_to(Couplings<dim> &couplings)
  {
    const Pool *before = nullptr;
    for (Pool &pool : pools)
      {
        // points of a group that are alone have the same nodes
        const bool is_as_before =
          before && before->is_alone && pool.is_alone &&
          group_of_point[before->points[0]] == group_of_point[pool.points[0]];
        pool.first_coupled =
          is_as_before ? before->first_coupled : couplings.node_ids.size();
        before = &pool;
        if (is_as_before)
          continue;
        couplings.node_ids.insert(couplings.node_ids.end(),
                                  pool.node_ids.begin(),
                                  pool.node_ids.end());
        couplings.group_sizes.push_back(pool.node_ids.size());
      }
  }

  template struct CellPools<2>;
  template struct CellPools<3>;
} // namespace emmy
