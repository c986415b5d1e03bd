#include <emmy/system/neighbourhood.h>

namespace emmy
{
  template <int dim>
  Neighbourhood<dim>::Neighbourhood(const Stencils<dim>   &stencils,
                                    const ActiveGrid<dim> &active)
    : stencils(stencils)
    , active(active)
    , index_of(active.n_local_nodes(), dealii::numbers::invalid_unsigned_int)
  {}

  template <int dim>
  void
  Neighbourhood<dim>::begin(const Group &group)
  {
    for (const unsigned int node : members)
      index_of[node] = dealii::numbers::invalid_unsigned_int;
    members.clear();
    indices.clear();
    first = last           = &group;
    const Group *const all = stencils.groups.data() + stencils.groups.size();
    for (; last < all && last->origin == first->origin &&
           members.size() <= enough_nodes;
         ++last)
      for (unsigned int a = 0; a < last->n_nodes; ++a)
        {
          const unsigned int node  = active.nodes(*last)[a];
          unsigned int      &index = index_of[node];
          if (index == dealii::numbers::invalid_unsigned_int)
            {
              index = members.size();
              members.push_back(node);
            }
          indices.push_back(index);
        }
  }

  template class Neighbourhood<2>;
  template class Neighbourhood<3>;
} // namespace emmy
