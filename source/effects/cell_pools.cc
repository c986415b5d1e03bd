#include <emmy/effects/cell_pools.h>

#include <algorithm>
#include <map>

namespace emmy
{
  template <int dim>
  void
  CellPools<dim>::find(
    const Stencils<dim>                      &stencils,
    const std::vector<const Material<dim> *> &material_of_body)
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
        for (std::size_t p = group.first_point;
             p < group.first_point + group.n_points;
             ++p)
          {
            const unsigned int cell = stencils.particles[p]
                                        ->get_surrounding_cell()
                                        ->active_cell_index();
            const auto [entry, is_new] =
              pool_of.try_emplace({cell, material}, pools.size());
            if (is_new)
              pools.emplace_back();
            Pool &pool = pools[entry->second];
            pool.points.push_back(p);
            pool_of_point[p] = entry->second;
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
    for (Pool &pool : pools)
      {
        pool.first_coupled = couplings.node_ids.size();
        couplings.node_ids.insert(couplings.node_ids.end(),
                                  pool.node_ids.begin(),
                                  pool.node_ids.end());
        couplings.group_sizes.push_back(pool.node_ids.size());
      }
  }

  template struct CellPools<2>;
  template struct CellPools<3>;
} // namespace emmy
