#include <deal.II/dofs/dof_tools.h>

#include <deal.II/grid/grid_generator.h>

#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/grid/background_grid.h>

#include <algorithm>
#include <cmath>

namespace emmy
{
  template <int dim>
  GridParameters<dim>::GridParameters(const std::string &section)
    : Section(section)
  {
    this->add_parameter("Lower corner",
                        lower_corner,
                        "Coordinates of the grid's lower corner. Unit: m.");
    this->add_parameter("Upper corner",
                        upper_corner,
                        "Coordinates of the grid's upper corner. Unit: m. "
                        "Required: above the lower corner in each direction.");
    this->add_parameter("Cells",
                        cells,
                        "Number of equal cells per direction. Required. "
                        "Numbers with many factors of two scale best.",
                        this->prm,
                        dealii::Patterns::List(dealii::Patterns::Integer(0),
                                               dim,
                                               dim));
  }

  template <int dim>
  void
  GridParameters<dim>::validate() const
  {
    const std::string section = this->path();
    for (unsigned int d = 0; d < dim; ++d)
      {
        AssertThrow(cells[d] > 0,
                    ExcParameter(section,
                                 "Cells",
                                 dealii::Patterns::Tools::to_string(cells),
                                 "the number of cells in each direction is "
                                 "required and must be at least 1."));
        AssertThrow(
          upper_corner[d] > lower_corner[d],
          ExcParameter(section,
                       "Upper corner",
                       dealii::Patterns::Tools::to_string(upper_corner),
                       "must lie above the lower corner (" +
                         dealii::Patterns::Tools::to_string(lower_corner) +
                         ") in each direction. Coordinates are in m."));
      }
  }

  template <int dim>
  BackgroundGrid<dim>::BackgroundGrid(const GridParameters<dim> &parameters,
                                      const MPI_Comm             communicator)
    : lower(parameters.lower_corner)
    , upper(parameters.upper_corner)
    , counts(parameters.cells)
    , cells(communicator)
    , element(1)
    , numbering(cells)
  {
    parameters.validate();

    // as few trees as the numbers of cells allow
    std::vector<unsigned int> coarse   = counts;
    unsigned int              n_levels = 0;
    while (std::all_of(coarse.begin(), coarse.end(), [](unsigned int n) {
      return n % 2 == 0;
    }))
      {
        for (auto &n : coarse)
          n /= 2;
        ++n_levels;
      }
    trees = 1;
    for (unsigned int d = 0; d < dim; ++d)
      {
        trees *= coarse[d];
        h[d] = (upper[d] - lower[d]) / counts[d];
      }
    dealii::GridGenerator::subdivided_hyper_rectangle(
      cells, coarse, lower, upper, /*colorize=*/true);
    cells.refine_global(n_levels);
    number_nodes();
  }

  template <int dim>
  void
  BackgroundGrid<dim>::number_nodes()
  {
    numbering.distribute_dofs(element);
    const dealii::IndexSet known =
      dealii::DoFTools::extract_locally_relevant_dofs(numbering);
    node_partition = std::make_shared<dealii::Utilities::MPI::Partitioner>(
      numbering.locally_owned_dofs(), known, communicator());

    node_positions.resize(known.n_elements());
    cells_by_number.clear();
    for (const auto &cell : numbering.active_cell_iterators())
      if (!cell->is_artificial())
        {
          for (const unsigned int v : cell->vertex_indices())
            node_positions[node_partition->global_to_local(
              cell->vertex_dof_index(v, 0))] = cell->vertex(v);
          cells_by_number.emplace_back(cell_number(lattice(cell->center())),
                                       cell);
        }
    std::sort(cells_by_number.begin(),
              cells_by_number.end(),
              [](const auto &a, const auto &b) { return a.first < b.first; });
  }

  template <int dim>
  std::uint64_t
  BackgroundGrid<dim>::cell_number(const Lattice &lattice) const
  {
    std::uint64_t number = 0;
    for (unsigned int d = dim; d-- > 0;)
      number = number * counts[d] + lattice[d];
    return number;
  }

  template <int dim>
  typename BackgroundGrid<dim>::Lattice
  BackgroundGrid<dim>::lattice(const dealii::Point<dim> &position) const
  {
    Lattice result;
    for (unsigned int d = 0; d < dim; ++d)
      result[d] =
        std::min<double>(counts[d] - 1,
                         std::max(0.,
                                  std::floor((position[d] - lower[d]) / h[d])));
    return result;
  }

  template <int dim>
  typename BackgroundGrid<dim>::Cell
  BackgroundGrid<dim>::cell_at(const Lattice &lattice) const
  {
    const auto number = cell_number(lattice);
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
  void
  BackgroundGrid<dim>::repartition(
    const std::function<unsigned int(const Cell &)> &weight)
  {
    const auto connection = cells.signals.weight.connect(
      [&weight](const auto &cell, const auto) -> unsigned int {
        return weight(cell);
      });
    cells.repartition();
    connection.disconnect();
    number_nodes();
  }

  template <int dim>
  MPI_Comm
  BackgroundGrid<dim>::communicator() const
  {
    return cells.get_communicator();
  }

  template <int dim>
  const dealii::Triangulation<dim> &
  BackgroundGrid<dim>::triangulation() const
  {
    return cells;
  }

  template <int dim>
  const dealii::Mapping<dim> &
  BackgroundGrid<dim>::mapping() const
  {
    return cartesian;
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
  const dealii::Tensor<1, dim> &
  BackgroundGrid<dim>::cell_size() const
  {
    return h;
  }

  template <int dim>
  double
  BackgroundGrid<dim>::smallest_cell_size() const
  {
    return *std::min_element(h.begin_raw(), h.end_raw());
  }

  template <int dim>
  unsigned int
  BackgroundGrid<dim>::n_trees() const
  {
    return trees;
  }

  template <int dim>
  std::array<dealii::types::global_dof_index,
             BackgroundGrid<dim>::nodes_per_cell>
  BackgroundGrid<dim>::node_ids(const Cell &cell) const
  {
    const typename dealii::DoFHandler<dim>::active_cell_iterator dof_cell(
      &cells, cell->level(), cell->index(), &numbering);
    std::array<dealii::types::global_dof_index, nodes_per_cell> ids;
    for (unsigned int v = 0; v < nodes_per_cell; ++v)
      ids[v] = dof_cell->vertex_dof_index(v, 0);
    return ids;
  }

  template <int dim>
  const std::shared_ptr<const dealii::Utilities::MPI::Partitioner> &
  BackgroundGrid<dim>::nodes() const
  {
    return node_partition;
  }

  template <int dim>
  const dealii::Point<dim> &
  BackgroundGrid<dim>::node_position(
    const dealii::types::global_dof_index id) const
  {
    return node_positions[node_partition->global_to_local(id)];
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

  template class GridParameters<2>;
  template class GridParameters<3>;
  template class BackgroundGrid<2>;
  template class BackgroundGrid<3>;
} // namespace emmy
