#include <deal.II/dofs/dof_tools.h>

#include <emmy/base/exceptions.h>
#include <emmy/base/index_limits.h>
#include <emmy/base/text.h>
#include <emmy/grid/background_grid.h>
#include <emmy/grid/cell_work.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace emmy
{
  template <int dim>
  BackgroundGrid<dim>::BackgroundGrid(const GridParameters<dim> &parameters,
                                      const MPI_Comm             communicator,
                                      const Cells                at_start)
    : lower(parameters.lower_corner)
    , upper(parameters.upper_corner)
    , counts(parameters.cells)
    , cells(communicator)
    , element(1)
  {
    parameters.validate();
    for (unsigned int d = 0; d < dim; ++d)
      h[d] = (upper[d] - lower[d]) / counts[d];
    if (at_start == Cells::none)
      return;
    double n_all = 1.;
    for (const unsigned int n : counts)
      n_all *= n;
    refuse_cells(n_all, n_all); // before their blocks are listed
    part = Window<dim>::whole(counts);
    make_cells();
    find_cells();
    number_nodes();
  }

  template <int dim>
  void
  BackgroundGrid<dim>::cover(const std::vector<Occupied> &occupied)
  {
    std::vector<CellKey<dim>> places;
    for (const Occupied &cell : occupied)
      places.push_back(cell.first);
    last_covered = occupied;
    part         = Window<dim>::around(places, counts, communicator());
    make_cells();
    find_cells();
    if (dealii::Utilities::MPI::n_mpi_processes(communicator()) > 1)
      repartition();
    number_nodes();
  }

  template <int dim>
  void
  BackgroundGrid<dim>::make_cells()
  {
    const double n_blocks = part.blocks().size(),
                 across   = std::ldexp(1., part.level());
    // as if blocks shared no nodes
    refuse_cells(n_blocks * std::pow(across, dim),
                 n_blocks * std::pow(across + 1., dim) * fields().size());
    std::vector<dealii::Point<dim>>      vertices;
    std::map<CellKey<dim>, unsigned int> vertex_at;
    std::vector<dealii::CellData<dim>>   blocks(part.blocks().size());
    for (unsigned int i = 0; i < blocks.size(); ++i)
      for (unsigned int v = 0; v < nodes_per_cell; ++v)
        {
          CellKey<dim> place = part.blocks()[i];
          for (unsigned int d = 0; d < dim; ++d)
            place[d] = (place[d] + ((v >> d) & 1)) << part.level();
          const auto [vertex, is_new] =
            vertex_at.insert({place, vertices.size()});
          if (is_new)
            vertices.push_back(corner(place));
          blocks[i].vertices[v] = vertex->second;
        }
    numbering.clear();
    cells.clear();
    cells.create_triangulation(vertices, blocks, dealii::SubCellData());
    cells.refine_global(part.level());
  }

  template <int dim>
  void
  BackgroundGrid<dim>::find_cells()
  {
    cells_by_number.clear();
    n_owned = 0;
    CellKey<dim> first{}, last{};
    first.fill(std::numeric_limits<unsigned int>::max());
    for (const auto &cell : cells.active_cell_iterators())
      if (!cell->is_artificial())
        {
          const CellKey<dim> place   = key_of(cell);
          bool               is_cell = true;
          for (unsigned int d = 0; d < dim; ++d)
            is_cell = is_cell && place[d] < counts[d];
          if (!is_cell)
            continue;
          cells_by_number.emplace_back(number_of(place), cell);
          if (!cell->is_locally_owned())
            continue;
          ++n_owned;
          for (unsigned int d = 0; d < dim; ++d)
            {
              first[d] = std::min(first[d], place[d]);
              last[d]  = std::max(last[d], place[d]);
            }
        }
    std::sort(cells_by_number.begin(),
              cells_by_number.end(),
              [](const auto &a, const auto &b) { return a.first < b.first; });
    boxes_of_ranks =
      dealii::Utilities::MPI::all_gather(communicator(),
                                         std::make_pair(first, last));
  }

  template <int dim>
  std::vector<typename BackgroundGrid<dim>::Occupied>
  BackgroundGrid<dim>::covered_here() const
  {
    std::map<unsigned int, std::vector<Occupied>> outgoing;
    for (const Occupied &cell : last_covered)
      for (const unsigned int rank : possible_owners(cell.first))
        outgoing[rank].push_back(cell);
    std::map<CellKey<dim>, unsigned int> n_points;
    for (const auto &[sender, incoming] :
         dealii::Utilities::MPI::some_to_some(communicator(), outgoing))
      {
        (void)sender;
        for (const auto &[place, n] : incoming)
          if (const Cell cell = cell_at(place);
              cell != cells.end() && cell->is_locally_owned())
            n_points[place] += n;
      }
    return {n_points.begin(), n_points.end()};
  }

  template <int dim>
  void
  BackgroundGrid<dim>::repartition()
  {
    const std::vector<Occupied>                occupied = covered_here();
    const std::map<CellKey<dim>, unsigned int> n_points(occupied.begin(),
                                                        occupied.end());
    const auto connection = cells.signals.weight.connect(
      [&](const auto &cell, const auto) -> unsigned int {
        const auto found = n_points.find(key_of(cell));
        return work_of_cell(found == n_points.end() ? 0 : found->second);
      });
    cells.repartition();
    connection.disconnect();
    find_cells();
  }

  template <int dim>
  void
  BackgroundGrid<dim>::number_nodes()
  {
    numbering.reinit(cells);
    numbering.distribute_dofs(element);
    const dealii::IndexSet known =
      dealii::DoFTools::extract_locally_relevant_dofs(numbering);
    node_partition = std::make_shared<dealii::Utilities::MPI::Partitioner>(
      fields().ids(numbering.locally_owned_dofs()),
      fields().ids(known),
      communicator());

    node_keys.resize(known.n_elements());
    for (const auto &cell : numbering.active_cell_iterators())
      if (!cell->is_artificial())
        for (const unsigned int v : cell->vertex_indices())
          {
            CellKey<dim> place = key_of(cell);
            for (unsigned int d = 0; d < dim; ++d)
              place[d] += (v >> d) & 1;
            // local indices count fields as ids do
            node_keys[fields().node(node_partition->global_to_local(
              fields().id(cell->vertex_dof_index(v, 0), 0)))] = place;
          }
  }

  template <int dim>
  std::uint64_t
  BackgroundGrid<dim>::number_of(const CellKey<dim> &lattice) const
  {
    std::uint64_t number = 0;
    for (unsigned int d = 0; d < dim; ++d)
      number = number * counts[d] + lattice[d];
    return number;
  }

  template <int dim>
  CellKey<dim>
  BackgroundGrid<dim>::key_of(const Cell &cell) const
  {
    const dealii::Point<dim> center = cell->center();
    CellKey<dim>             result;
    for (unsigned int d = 0; d < dim; ++d)
      result[d] = std::floor((center[d] - lower[d]) / h[d]);
    return result;
  }

  template <int dim>
  dealii::Point<dim>
  BackgroundGrid<dim>::corner(const CellKey<dim> &lattice) const
  {
    dealii::Point<dim> result;
    for (unsigned int d = 0; d < dim; ++d)
      result[d] =
        lattice[d] == counts[d] ? upper[d] : lower[d] + lattice[d] * h[d];
    return result;
  }

  template <int dim>
  std::vector<typename BackgroundGrid<dim>::Cell>
  BackgroundGrid<dim>::owned_cells() const
  {
    std::vector<Cell> result;
    for (const auto &[number, cell] : cells_by_number)
      if (cell->is_locally_owned())
        result.push_back(cell);
    return result;
  }

  template <int dim>
  std::vector<unsigned int>
  BackgroundGrid<dim>::possible_owners(const CellKey<dim> &lattice) const
  {
    std::vector<unsigned int> ranks;
    for (unsigned int rank = 0; rank < boxes_of_ranks.size(); ++rank)
      {
        const auto &[first, last] = boxes_of_ranks[rank];
        bool is_inside            = true;
        for (unsigned int d = 0; d < dim; ++d)
          is_inside =
            is_inside && lattice[d] >= first[d] && lattice[d] <= last[d];
        if (is_inside)
          ranks.push_back(rank);
      }
    return ranks;
  }

  template <int dim>
  CellKey<dim>
  BackgroundGrid<dim>::key_of(const dealii::Point<dim> &position) const
  {
    CellKey<dim> result;
    for (unsigned int d = 0; d < dim; ++d)
      result[d] =
        std::min<double>(counts[d] - 1,
                         std::max(0.,
                                  std::floor((position[d] - lower[d]) / h[d])));
    return result;
  }

  template <int dim>
  typename BackgroundGrid<dim>::Cell
  BackgroundGrid<dim>::cell_at(const CellKey<dim> &lattice) const
  {
    const auto number = number_of(lattice);
    const auto found =
      std::lower_bound(cells_by_number.begin(),
                       cells_by_number.end(),
                       number,
                       [](const auto &entry, const std::uint64_t n) {
                         return entry.first < n;
                       });
    return found != cells_by_number.end() && found->first == number
             ? found->second
             : Cell(cells.end());
  }

  template <int dim>
  MPI_Comm
  BackgroundGrid<dim>::communicator() const
  {
    return cells.get_communicator();
  }

  template <int dim>
  const dealii::Point<dim> &
  BackgroundGrid<dim>::lower_corner() const
  {
    return lower;
  }

  template <int dim>
  const dealii::Point<dim> &
  BackgroundGrid<dim>::upper_corner() const
  {
    return upper;
  }

  template <int dim>
  const std::vector<unsigned int> &
  BackgroundGrid<dim>::n_cells() const
  {
    return counts;
  }

  template <int dim>
  double
  BackgroundGrid<dim>::shortest_side() const
  {
    return *std::min_element(h.begin_raw(), h.end_raw());
  }

  template <int dim>
  unsigned int
  BackgroundGrid<dim>::n_trees() const
  {
    return part.blocks().size();
  }

  template <int dim>
  std::array<dealii::types::global_dof_index,
             BackgroundGrid<dim>::nodes_per_cell>
  BackgroundGrid<dim>::node_ids(const Cell        &cell,
                                const unsigned int field) const
  {
    const typename dealii::DoFHandler<dim>::active_cell_iterator dof_cell(
      &cells, cell->level(), cell->index(), &numbering);
    std::array<dealii::types::global_dof_index, nodes_per_cell> ids;
    for (unsigned int v = 0; v < nodes_per_cell; ++v)
      ids[v] = fields().id(dof_cell->vertex_dof_index(v, 0), field);
    return ids;
  }

  template <int dim>
  const std::shared_ptr<const dealii::Utilities::MPI::Partitioner> &
  BackgroundGrid<dim>::nodes() const
  {
    return node_partition;
  }

  template <int dim>
  const CellKey<dim> &
  BackgroundGrid<dim>::node_key(const dealii::types::global_dof_index id) const
  {
    return node_keys[fields().node(node_partition->global_to_local(id))];
  }

  template <int dim>
  dealii::Point<dim>
  BackgroundGrid<dim>::node_position(
    const dealii::types::global_dof_index id) const
  {
    return corner(node_key(id));
  }

  template <int dim>
  bool
  BackgroundGrid<dim>::is_in_cell(const CellKey<dim>       &lattice,
                                  const dealii::Point<dim> &position) const
  {
    CellKey<dim> above = lattice;
    for (unsigned int &place : above)
      ++place;
    const dealii::Point<dim> low = corner(lattice), high = corner(above);
    for (unsigned int d = 0; d < dim; ++d)
      if (position[d] < low[d] || position[d] > high[d])
        return false;
    return true;
  }

  template <int dim>
  bool
  BackgroundGrid<dim>::contains(const dealii::Point<dim> &position) const
  {
    for (unsigned int d = 0; d < dim; ++d)
      {
        const double tolerance =
          1e-13 * std::max(std::abs(lower[d]), std::abs(upper[d]));
        // written so that NaN is outside
        if (!(position[d] >= lower[d] - tolerance &&
              position[d] <= upper[d] + tolerance))
          return false;
      }
    return true;
  }

  template <int dim>
  dealii::Point<dim>
  BackgroundGrid<dim>::clamped(const dealii::Point<dim> &position) const
  {
    dealii::Point<dim> result;
    for (unsigned int d = 0; d < dim; ++d)
      result[d] = std::min(std::max(position[d], lower[d]), upper[d]);
    return result;
  }

  template <int dim>
  CellKey<dim>
  BackgroundGrid<dim>::key_above(const dealii::Point<dim> &node_position) const
  {
    return key_of(node_position + 0.5 * h);
  }

  template <int dim>
  std::optional<CellKey<dim>>
  BackgroundGrid<dim>::neighbour(const CellKey<dim> &key,
                                 const unsigned int  face) const
  {
    const unsigned int d = face / 2;
    if (key[d] == (face % 2 == 0 ? 0 : counts[d] - 1))
      return {};
    CellKey<dim> result = key;
    result[d] += face % 2 == 0 ? -1 : 1;
    return result;
  }

  namespace
  {
    /** The cells of a box that is n cells wide, inside the grid. */
    template <int dim>
    std::vector<CellKey<dim>>
    box_from_one_below(const CellKey<dim>              &key,
                       const int                        n,
                       const std::vector<unsigned int> &counts)
    {
      std::vector<CellKey<dim>> result;
      for (int i = 0; i < dealii::Utilities::pow(n, dim); ++i)
        {
          CellKey<dim> cell;
          bool         is_inside = true;
          for (int d = 0, rest = i; d < dim; ++d, rest /= n)
            {
              cell[d]   = key[d] + rest % n - 1; // below zero: very large
              is_inside = is_inside && cell[d] < counts[d];
            }
          if (is_inside)
            result.push_back(cell);
        }
      return result;
    }
  } // namespace

  template <int dim>
  std::vector<CellKey<dim>>
  BackgroundGrid<dim>::cells_around(const CellKey<dim> &key) const
  {
    return box_from_one_below<dim>(key, 3, counts);
  }

  template <int dim>
  std::vector<CellKey<dim>>
  BackgroundGrid<dim>::cells_at_node(const CellKey<dim> &node) const
  {
    return box_from_one_below<dim>(node, 2, counts);
  }

  template <int dim>
  dealii::Tensor<1, dim>
  BackgroundGrid<dim>::from_node_to_center(const CellKey<dim> &node,
                                           const CellKey<dim> &cell,
                                           const unsigned int  span) const
  {
    dealii::Tensor<1, dim> result;
    for (unsigned int d = 0; d < dim; ++d)
      result[d] = (int(cell[d]) - int(node[d]) + 0.5 * span) * h[d];
    return result;
  }

  template <int dim>
  double
  BackgroundGrid<dim>::volume_of_node(
    const dealii::Point<dim> &node_position) const
  {
    double volume = 1.;
    for (unsigned int d = 0; d < dim; ++d)
      {
        const bool half = node_position[d] < lower[d] + 0.5 * h[d] ||
                          node_position[d] > upper[d] - 0.5 * h[d];
        volume *= half ? 0.5 * h[d] : h[d];
      }
    return volume;
  }

  template <int dim>
  dealii::Point<dim>
  BackgroundGrid<dim>::reference_position(
    const CellKey<dim>       &key,
    const dealii::Point<dim> &position) const
  {
    const dealii::Point<dim> from = corner(key);
    dealii::Point<dim>       result;
    for (unsigned int d = 0; d < dim; ++d)
      result[d] = (position[d] - from[d]) / h[d];
    return result;
  }

  template class BackgroundGrid<2>;
  template class BackgroundGrid<3>;
} // namespace emmy
