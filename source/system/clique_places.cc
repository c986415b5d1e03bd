#include <emmy/system/clique_places.h>
#include <emmy/system/node_graph.h>

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
    if (next == kept.size())
      kept.emplace_back();
    Kept &here = kept[next++];
    if (here.nodes != nodes)
      {
        const std::size_t n = nodes.size();
        here.nodes          = nodes;
        here.places.resize(n * n);
        for (std::size_t a = 0; a < n; ++a)
          find_row(nodes[a], nodes, here.places.data() + a * n);
      }
    return here.places.data();
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
