#include <emmy/effects/starved_nodes.h>

#include <algorithm>

namespace emmy
{
  template <int dim>
  StarvedNodes<dim>::StarvedNodes(Aggregation<dim> aggregation)
    : aggregation(std::move(aggregation))
  {}

  template <int dim>
  EffectCard
  StarvedNodes<dim>::card(const bool is_present)
  {
    EffectCard card;
    card.name       = starved_nodes_effect;
    card.setting    = "Method/Starved nodes = follow";
    card.is_present = is_present;
    card.enters     = "particles to grid: roots; constraints of all solves";
    card.couples    = "the roots' nodes with those that their followers reach";
    card.ledger_columns = {"followers",
                           "free_starved",
                           "farthest_root",
                           "largest_weight",
                           "class_changes"};
    return card;
  }

  template <int dim>
  NodeCoupling<dim> *
  StarvedNodes<dim>::coupling()
  {
    return this;
  }

  template <int dim>
  void
  StarvedNodes<dim>::classify(const Stencils<dim>       &stencils,
                              const PointArrays<dim>    &points,
                              const BackgroundGrid<dim> &grid)
  {
    NodeClasses<dim> now =
      aggregation.classify(stencils, points, grid, classes);
    is_found = is_found && now.same_nodes_as(classes);
    classes  = std::move(now);
  }

  template <int dim>
  void
  StarvedNodes<dim>::couple(const Stencils<dim>       &stencils,
                            const BackgroundGrid<dim> &grid,
                            const BoundaryConditions<dim> &,
                            Couplings<dim> &couplings)
  {
    // with classes as they are, whom nodes follow depends on no weights
    const bool is_known = is_found && stencils.node_ids == node_ids &&
                          stencils.active_cells == active_cells;
    if (!dealii::Utilities::MPI::min(is_known ? 1 : 0, grid.communicator()))
      {
        found        = aggregation.find(classes, stencils, grid);
        node_ids     = stencils.node_ids;
        active_cells = stencils.active_cells;
        is_found     = true;
      }
    for (const Follower<dim> &follower : found.followers)
      {
        couplings.tied_nodes.push_back({follower.node_id, {}});
        for (const auto &master : follower.masters)
          couplings.tied_nodes.back().masters.push_back(
            {master.id, master.weight, grid.corner(master.place)});
      }
    couplings.has_tied_nodes |= found.n_followers > 0;
  }

  template <int dim>
  StepMeasures<dim> *
  StarvedNodes<dim>::measures()
  {
    return this;
  }

  template <int dim>
  std::vector<StepMeasure>
  StarvedNodes<dim>::measure(const PointArrays<dim> &,
                             const double,
                             const BackgroundGrid<dim> &grid)
  {
    const std::uint64_t changes = class_changes(classes_before, classes, grid);
    classes_before              = classes;
    return {{"followers", double(found.n_followers)},
            {"free_starved", double(found.n_kept)},
            {"farthest_root", double(found.farthest_root)},
            {"largest_weight", found.largest_weight},
            {"class_changes", double(changes)}};
  }

  template <int dim>
  std::string
  StarvedNodes<dim>::finding()
  {
    if (found.largest_weight <= largest_weight && found.n_kept <= most_kept)
      return "";
    largest_weight = std::max(largest_weight, found.largest_weight);
    most_kept      = std::max(most_kept, found.n_kept);
    return found.text();
  }

  template <int dim>
  std::vector<double>
  StarvedNodes<dim>::contents() const
  {
    std::vector<double> result{double(most_kept), largest_weight};
    for (const auto &[node, is_fed] : classes_before.active)
      {
        const auto &[place, field] = node;
        result.insert(result.end(), place.begin(), place.end());
        result.push_back(2. * field + is_fed);
      }
    return result;
  }

  template <int dim>
  void
  StarvedNodes<dim>::recall(const std::vector<std::vector<double>> &parts)
  {
    // without a partition: class_changes() looks at the places of all ranks
    classes_before = {};
    most_kept      = parts.at(0).at(0);
    largest_weight = parts.at(0).at(1);
    for (std::size_t part = 1; part < parts.size(); ++part)
      for (std::size_t i = 2; i < parts[part].size(); i += dim + 1)
        {
          const auto   from           = parts[part].begin() + i;
          const auto   class_in_field = static_cast<unsigned int>(from[dim]);
          CellKey<dim> place;
          std::copy_n(from, dim, place.begin());
          classes_before.active.emplace_back(NodePlace<dim>{place,
                                                            class_in_field / 2},
                                             class_in_field % 2 != 0);
        }
    std::sort(classes_before.active.begin(), classes_before.active.end());
  }

  template class StarvedNodes<2>;
  template class StarvedNodes<3>;
} // namespace emmy
