#include <emmy/system/clique_places.h>
#include <emmy/system/node_graph.h>

#include <algorithm>

namespace emmy
{
  template <int dim>
  CliquePlaces<dim>::CliquePlaces(const NodeGraph<dim> &graph)
    : graph(graph)
    , marks(graph.n_nodes(), {dealii::numbers::invalid_unsigned_int, 0})
  {}

  template <int dim>
  const typename CliquePlaces<dim>::Place *
  CliquePlaces<dim>::find(const std::vector<unsigned int> &nodes)
  {
    const auto nodes_end = [&](const std::size_t i) {
      return i + 1 < kept.size() ? kept[i + 1].nodes : nodes_of_kept.size();
    };
    const bool is_kept = next < kept.size() &&
                         nodes_end(next) - kept[next].nodes == nodes.size() &&
                         std::equal(nodes.begin(),
                                    nodes.end(),
                                    nodes_of_kept.begin() + kept[next].nodes);
    if (!is_kept)
      {
        if (next < kept.size())
          {
            nodes_of_kept.resize(kept[next].nodes);
            places.resize(kept[next].places);
            kept.resize(next);
          }
        kept.push_back({nodes_of_kept.size(), places.size()});
        nodes_of_kept.insert(nodes_of_kept.end(), nodes.begin(), nodes.end());
        for (const unsigned int row : nodes)
          add_row(row, nodes);
      }
    return places.data() + kept[next++].places;
  }

  template <int dim>
  void
  CliquePlaces<dim>::add_row(const unsigned int               row,
                             const std::vector<unsigned int> &nodes)
  {
    const auto neighbours = graph.row(row);
    for (unsigned int k = 0; k < neighbours.n; ++k)
      marks[neighbours.nodes[k]] = {row, graph.place(neighbours.first + k)};
    for (const unsigned int node : nodes)
      if (marks[node].row != row)
        places.push_back(none);
      else
        {
          Assert(marks[node].place < none, dealii::ExcInternalError());
          places.push_back(marks[node].place);
        }
  }

  template class CliquePlaces<2>;
  template class CliquePlaces<3>;
} // namespace emmy
