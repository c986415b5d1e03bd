#include <emmy/system/clique_places.h>
#include <emmy/system/node_graph.h>

#include <algorithm>

namespace emmy
{
  template <int dim>
  CliquePlaces<dim>::CliquePlaces(const NodeGraph<dim>     &graph,
                                  const CliquePlaces *const before)
    : graph(graph)
    , marks(graph.n_nodes(), {dealii::numbers::invalid_unsigned_int, 0})
  {
    if (!before)
      return;
    // a few more, as arrays that grow become twice as large
    const auto some_more = [](const std::size_t n) { return n + n / 8; };
    kept.reserve(some_more(before->kept.size()));
    nodes_of_kept.reserve(some_more(before->nodes_of_kept.size()));
    places_of_kept.reserve(some_more(before->places_of_kept.size()));
  }

  template <int dim>
  std::size_t
  CliquePlaces<dim>::n_nodes(const std::size_t i) const
  {
    return (i + 1 < kept.size() ? kept[i + 1].nodes : nodes_of_kept.size()) -
           kept[i].nodes;
  }

  template <int dim>
  const typename CliquePlaces<dim>::Place *
  CliquePlaces<dim>::find(const std::vector<unsigned int> &nodes)
  {
    const std::size_t n = nodes.size();
    if (next < kept.size() &&
        !(n_nodes(next) == n &&
          std::equal(nodes.begin(),
                     nodes.end(),
                     nodes_of_kept.begin() + kept[next].nodes)))
      {
        // what comes behind these is found anew too
        nodes_of_kept.resize(kept[next].nodes);
        places_of_kept.resize(kept[next].places);
        kept.resize(next);
      }
    if (next == kept.size())
      {
        kept.push_back({nodes_of_kept.size(), places_of_kept.size()});
        nodes_of_kept.insert(nodes_of_kept.end(), nodes.begin(), nodes.end());
        places_of_kept.resize(places_of_kept.size() + n * n);
        for (std::size_t a = 0; a < n; ++a)
          find_row(nodes[a],
                   nodes,
                   places_of_kept.data() + kept.back().places + a * n);
      }
    return places_of_kept.data() + kept[next++].places;
  }

  template <int dim>
  void
  CliquePlaces<dim>::find_row(const unsigned int               row,
                              const std::vector<unsigned int> &nodes,
                              Place                           *places)
  {
    const auto neighbours = graph.row(row);
    for (unsigned int k = 0; k < neighbours.n; ++k)
      marks[neighbours.nodes[k]] = {row, graph.place(neighbours.first + k)};
    // places are sorted too
    AssertThrow(neighbours.n == 0 ||
                  graph.place(neighbours.first + neighbours.n - 1) < none,
                dealii::ExcMessage("A node meets 65535 others or more."));
    for (const unsigned int node : nodes)
      *places++ = marks[node].row == row ? marks[node].place : none;
  }

  template class CliquePlaces<2>;
  template class CliquePlaces<3>;
} // namespace emmy
