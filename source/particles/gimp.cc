#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/particles/gimp.h>

#include <algorithm>
#include <bitset>
#include <cmath>

namespace emmy
{
  template <int dim>
  GimpShapeFunctions<dim>::GimpShapeFunctions(FieldLayout &layout)
    : body_component(layout["body"])
    , half_length_component(
        layout.add({"half_length",
                    Field::Kind::vector,
                    "m",
                    "half the size of the particle's domain"}))
  {}

  template <int dim>
  EffectCard
  GimpShapeFunctions<dim>::card()
  {
    EffectCard card;
    card.enters  = "stencils: the nodes of all cells that the box overlaps";
    card.couples = "the nodes of up to " +
                   std::to_string(dealii::Utilities::pow(2, dim)) +
                   " cells, as boxes cross faces; at the start none does";
    card.phases = {"stencils"};
    return card;
  }

  template <int dim>
  void
  GimpShapeFunctions<dim>::set_overlap(const Places<dim>         &places,
                                       const BackgroundGrid<dim> &grid,
                                       Entry                     &entry)
  {
    const dealii::Point<dim> &x     = places.positions[entry.index];
    double                    least = 1.; // of the shares of corners
    for (unsigned int d = 0; d < dim; ++d)
      {
        const double h = grid.cell_size()[d];
        Assert(places.half_lengths[entry.index][d] >= 0.,
               dealii::ExcMessage("A half-length is no number."));
        const double below = std::max(0., x[d] - grid.lower_corner()[d]),
                     above = std::max(0., grid.upper_corner()[d] - x[d]);
        const double l =
          used_half_length(places.half_lengths[entry.index][d], h, below, above)
            .value;
        const Overlap overlap = overlap_along(below, l, h, grid.n_cells()[d]);
        entry.first[d]        = overlap.first;
        entry.last[d]         = overlap.last;
        entry.beyond_lower[d] = overlap.beyond_lower;
        entry.beyond_upper[d] = overlap.beyond_upper;
        least *= overlap.tails;
        entry.half_length[d] = l;
      }
    // the exact share decides, but is seldom wanted
    entry.left_out =
      least < 2. * least_share ? nodes_left_out(places, grid, entry) : 0;
  }

  template <int dim>
  Places<dim>
  GimpShapeFunctions<dim>::places(
    const dealii::Particles::ParticleHandler<dim> &particles,
    const BackgroundGrid<dim>                     &grid) const
  {
    Places<dim> places = places_now(particles, grid, body_component);
    places.half_lengths.resize(places.size());
    for (std::size_t i = 0; i < places.size(); ++i)
      for (unsigned int d = 0; d < dim; ++d)
        places.half_lengths[i][d] =
          places.particles[i]->get_properties()[half_length_component + d];
    return places;
  }

  template <int dim>
  std::vector<typename GimpShapeFunctions<dim>::Entry>
  GimpShapeFunctions<dim>::sorted_entries(const Places<dim>         &places,
                                          const BackgroundGrid<dim> &grid) const
  {
    // the order must not depend on which part of the grid has cells: that of
    // Entry::key(), then of ids; what is compared stands close together
    struct Rank
    {
      std::uint64_t cells;
      unsigned int  body;
      std::uint64_t left_out, id;
      Entry         entry;
    };
    std::vector<Rank>         ranks(places.size());
    std::vector<const Rank *> sorted(places.size());
    for (std::size_t i = 0; i < places.size(); ++i)
      {
        Entry &entry = ranks[i].entry;
        entry.index  = i;
        entry.body   = places.bodies[i];
        set_overlap(places, grid, entry);
        std::uint64_t cells = 0;
        for (unsigned int d = 0; d < dim; ++d)
          cells = cells * grid.n_cells()[d] + entry.first[d];
        for (unsigned int d = 0; d < dim; ++d)
          cells = 4 * cells + entry.last[d] - entry.first[d];
        ranks[i].cells    = cells;
        ranks[i].body     = entry.body;
        ranks[i].left_out = entry.left_out;
        ranks[i].id       = places.particles[i]->get_id();
        sorted[i]         = &ranks[i];
      }
    std::sort(sorted.begin(), sorted.end(), [](const Rank *a, const Rank *b) {
      return std::tie(a->cells, a->body, a->left_out, a->id) <
             std::tie(b->cells, b->body, b->left_out, b->id);
    });
    std::vector<Entry> entries;
    entries.reserve(places.size());
    for (const Rank *rank : sorted)
      entries.push_back(rank->entry);
    return entries;
  }

  namespace
  {
    /** Nodes per direction of a box of cells. */
    template <int dim>
    std::array<unsigned int, dim>
    nodes_of(const CellKey<dim> &first, const CellKey<dim> &last)
    {
      std::array<unsigned int, dim> n_nodes;
      for (unsigned int d = 0; d < dim; ++d)
        n_nodes[d] = last[d] - first[d] + 2;
      return n_nodes;
    }
  } // namespace

  template <int dim>
  std::array<std::array<Weight, 4>, dim>
  GimpShapeFunctions<dim>::weights_along(const Entry               &entry,
                                         const Places<dim>         &places,
                                         const BackgroundGrid<dim> &grid,
                                         const dealii::Point<dim>  &origin)
  {
    std::array<std::array<Weight, 4>, dim> weights{};
    for (unsigned int d = 0; d < dim; ++d)
      gimp_weights(places.positions[entry.index][d] - origin[d],
                   entry.half_length[d],
                   grid.cell_size()[d],
                   entry.last[d] - entry.first[d] + 1,
                   weights[d].data(),
                   entry.beyond_lower[d],
                   entry.beyond_upper[d]);
    return weights;
  }

  namespace
  {
    /** Weights as factors whose change with the place is not asked for. */
    template <int dim>
    Factors<dim>
    as_factors(const std::array<std::array<Weight, 4>, dim> &weights)
    {
      Factors<dim> factors;
      for (unsigned int d = 0; d < dim; ++d)
        for (unsigned int j = 0; j < 4; ++j)
          factors[d][j] = {
            weights[d][j].value, weights[d][j].slope, 0., 0., 0., 0.};
      return factors;
    }

    template <int dim>
    Tails<dim>
    tails_of(const Factors<dim>                  &factors,
             const std::array<unsigned int, dim> &n_along,
             const BackgroundGrid<dim>           &grid)
    {
      std::array<double, dim> h;
      for (unsigned int d = 0; d < dim; ++d)
        h[d] = grid.cell_size()[d];
      return Tails<dim>(factors, n_along, h);
    }
  } // namespace

  template <int dim>
  std::uint64_t
  GimpShapeFunctions<dim>::nodes_left_out(const Places<dim>         &places,
                                          const BackgroundGrid<dim> &grid,
                                          const Entry               &entry)
  {
    return tails_of<dim>(as_factors<dim>(weights_along(
                           entry, places, grid, grid.corner(entry.first))),
                         nodes_of<dim>(entry.first, entry.last),
                         grid)
      .left_out();
  }

  template <int dim>
  bool
  GimpShapeFunctions<dim>::add_nodes(
    const Entry                  &entry,
    const BackgroundGrid<dim>    &grid,
    Group                        &group,
    Stencils<dim>                &stencils,
    std::vector<ActiveCell<dim>> &overlapped) const
  {
    const auto n_nodes       = nodes_of<dim>(entry.first, entry.last);
    group.n_along            = n_nodes;
    group.origin             = grid.corner(entry.first);
    group.left_out           = entry.left_out;
    group.first_node         = stencils.node_ids.size();
    const unsigned int field = grid.fields().of_body(entry.body);
    // each cell of the box once, and only if it is asked for
    struct Known
    {
      bool is_looked_up = false, exists = false;
      Cell cell;
      std::array<dealii::types::global_dof_index,
                 BackgroundGrid<dim>::nodes_per_cell>
        ids;
    };
    std::array<Known, dealii::Utilities::pow(3, dim)> cells;
    const auto known = [&](const auto &index) -> const Known & {
      unsigned int i = 0;
      for (unsigned int d = 0; d < dim; ++d)
        i = 3 * i + index[d];
      Known &result = cells[i];
      if (!result.is_looked_up)
        {
          result.is_looked_up = true;
          result.cell         = grid.cell_at(further<dim>(entry.first, index));
          result.exists       = result.cell != grid.triangulation().end();
          if (result.exists)
            result.ids = grid.node_ids(result.cell, field);
        }
      return result;
    };
    bool is_known = true;
    for_each_node<dim>(group, [&](const unsigned int, const auto &index) {
      // a cell that has the node, and which of its vertices that is
      std::array<unsigned int, dim> of_cell;
      unsigned int                  vertex = 0;
      for (unsigned int d = 0; d < dim; ++d)
        {
          of_cell[d] = std::min(index[d], n_nodes[d] - 2);
          vertex |= (index[d] - of_cell[d]) << d;
        }
      const Known &cell = known(of_cell);
      if (cell.exists)
        stencils.node_ids.push_back(cell.ids[vertex]);
      else
        is_known = false;
    });
    group.n_nodes = stencils.node_ids.size() - group.first_node;
    for_each_cell_of<dim>(group, [&](const auto &index) {
      overlapped.push_back({known(index).cell, field});
    });
    return is_known;
  }

  namespace
  {
    /** Value and gradient of a node's weight, from those by direction. */
    template <int dim, class Direction>
    std::pair<double, std::array<double, dim>>
    node_weight(const std::array<Direction, dim>    &along,
                const std::array<unsigned int, dim> &index)
    {
      std::pair<double, std::array<double, dim>> result;
      result.first = 1.;
      for (unsigned int d = 0; d < dim; ++d)
        {
          result.first *= along[d][index[d]].value;
          result.second[d] = along[d][index[d]].slope;
          for (unsigned int e = 0; e < dim; ++e)
            if (e != d)
              result.second[d] *= along[e][index[e]].value;
        }
      return result;
    }
  } // namespace

  template <int dim>
  void
  GimpShapeFunctions<dim>::add_weights(const Entry               *first,
                                       const Places<dim>         &places,
                                       const BackgroundGrid<dim> &grid,
                                       const Group               &group,
                                       Stencils<dim> &stencils) const
  {
    for (unsigned int q = 0; q < group.n_points; ++q)
      {
        const auto weights =
          weights_along(first[q], places, grid, group.origin);
        std::vector<Factors<dim>> too_little;
        if (group.left_out != 0)
          {
            const auto factors = as_factors<dim>(weights);
            too_little =
              tails_of<dim>(factors, group.n_along, grid).products(factors);
          }
        for_each_node<dim>(group, [&](const unsigned int a, const auto &index) {
          auto S = node_weight<dim>(weights, index);
          for (const Factors<dim> &product : too_little)
            {
              const auto part = node_weight<dim>(product, index);
              S.first -= part.first;
              for (unsigned int d = 0; d < dim; ++d)
                S.second[d] -= part.second[d];
            }
          stencils.values[group.first_value + a * group.n_points + q] = S.first;
          for (unsigned int d = 0; d < dim; ++d)
            stencils.gradients[dim * group.first_value +
                               (a * dim + d) * group.n_points + q] =
              S.second[d];
        });
      }
  }

  template <int dim>
  void
  GimpShapeFunctions<dim>::differentiate(
    const Places<dim>                   &places,
    const std::size_t                    i,
    const typename Stencils<dim>::Group &group,
    const BackgroundGrid<dim>           &grid,
    PlaceDerivatives<dim>               &result) const
  {
    Factors<dim>              factors{};
    std::array<Weight, 4>     weights;
    const dealii::Point<dim> &x = places.positions[i];
    for (unsigned int d = 0; d < dim; ++d)
      {
        const double       h     = grid.cell_size()[d];
        const unsigned int n     = group.n_along[d] - 1; // cells
        const double       below = std::max(0., x[d] - grid.lower_corner()[d]),
                     above       = std::max(0., grid.upper_corner()[d] - x[d]);
        const UsedLength l =
          used_half_length(places.half_lengths[i][d], h, below, above);
        const double from_first = x[d] - group.origin[d];
        if (n == 1) // a box in one cell is a point
          {
            const double xi = from_first / h, slope = 1. / h;
            factors[d][0] = {1. - xi, -slope, -slope, 0., 0., 0.};
            factors[d][1] = {xi, slope, slope, 0., 0., 0.};
            continue;
          }
        // where the group has its nodes, boxes end in the outermost cells, or
        // a hair beyond
        gimp_weights(from_first,
                     l.value,
                     h,
                     n,
                     weights.data(),
                     /*beyond_lower=*/true,
                     /*beyond_upper=*/true);
        // both ends of the box: hats and their slopes, by node
        const double a = (from_first - l.value) / h,
                     b = (from_first + l.value) / h - (n - 1);
        for (unsigned int j = 0; j <= n; ++j)
          {
            const double at_a    = j == 0   ? 1. - a
                                   : j == 1 ? a
                                            : 0.,
                         at_b    = j + 1 == n ? 1. - b
                                   : j == n   ? b
                                              : 0.;
            const double slope_a = j == 0   ? -1. / h
                                   : j == 1 ? 1. / h
                                            : 0.,
                         slope_b = j + 1 == n ? -1. / h
                                   : j == n   ? 1. / h
                                              : 0.;
            const double twice   = 2. * l.value;
            const double by_l = (at_a + at_b - 2. * weights[j].value) / twice;
            const double slope_by_x = (slope_b - slope_a) / twice;
            const double slope_by_l =
              (slope_b + slope_a - 2. * weights[j].slope) / twice;
            factors[d][j] = {weights[j].value,
                             weights[j].slope,
                             weights[j].slope + by_l * l.by_x,
                             by_l * l.by_l,
                             slope_by_x + slope_by_l * l.by_x,
                             slope_by_l * l.by_l};
          }
      }
    result.combine(factors, group.n_along);
    if (group.left_out != 0)
      tails_of<dim>(factors, group.n_along, grid).take_away(factors, result);
  }

  template <int dim>
  std::size_t
  GimpShapeFunctions<dim>::end_of_group(const std::vector<Entry> &entries,
                                        const std::size_t         first)
  {
    std::size_t last = first;
    while (last < entries.size() && entries[last].key() == entries[first].key())
      ++last;
    return last;
  }

  template <int dim>
  void
  GimpShapeFunctions<dim>::make_room(const std::vector<Entry> &entries,
                                     Stencils<dim>            &stencils)
  {
    std::size_t n_groups = 0, n_node_ids = 0, n_values = 0;
    for (std::size_t first = 0, last = 0; first < entries.size(); first = last)
      {
        last                = end_of_group(entries, first);
        std::size_t n_nodes = 1;
        for (const unsigned int n :
             nodes_of<dim>(entries[first].first, entries[first].last))
          n_nodes *= n;
        n_nodes -= std::bitset<64>(entries[first].left_out).count();
        ++n_groups;
        n_node_ids += n_nodes;
        n_values += n_nodes * (last - first);
      }
    stencils.groups.reserve(n_groups);
    stencils.node_ids.reserve(n_node_ids);
    stencils.values.resize(n_values);
    stencils.gradients.resize(dim * n_values);
  }

  template <int dim>
  Stencils<dim>
  GimpShapeFunctions<dim>::evaluate(const Places<dim>         &places,
                                    const BackgroundGrid<dim> &grid) const
  {
    const std::vector<Entry>     entries = sorted_entries(places, grid);
    Stencils<dim>                stencils;
    std::vector<ActiveCell<dim>> overlapped;
    stencils.particles.reserve(entries.size());
    stencils.order.reserve(entries.size());
    for (const Entry &entry : entries)
      {
        stencils.particles.push_back(places.particles[entry.index]);
        stencils.order.push_back(entry.index);
      }

    make_room(entries, stencils);

    std::optional<std::size_t> unknown;
    std::size_t                n_done = 0; // values
    for (std::size_t first = 0, last = 0; first < entries.size(); first = last)
      {
        last = end_of_group(entries, first);
        Group group;
        group.first_point = first;
        group.n_points    = last - first;
        group.body        = entries[first].body;
        group.first_value = n_done;
        if (!add_nodes(entries[first], grid, group, stencils, overlapped))
          {
            unknown = entries[first].index;
            break;
          }
        add_weights(&entries[first], places, grid, group, stencils);
        n_done += std::size_t(group.n_nodes) * group.n_points;
        stencils.groups.push_back(group);
      }

    stop_at_unknown_cell(places, unknown, grid);
    std::sort(overlapped.begin(), overlapped.end());
    overlapped.erase(std::unique(overlapped.begin(), overlapped.end()),
                     overlapped.end());
    stencils.active_cells = owned_among_active<dim>(overlapped, grid);
    return stencils;
  }

  template class GimpShapeFunctions<2>;
  template class GimpShapeFunctions<3>;
} // namespace emmy
