#include <emmy/system/active_cells.h>

#include <map>
#include <vector>

namespace emmy
{
  template <int dim>
  std::set<CellOfBody<dim>>
  owned_active_cells(const Stencils<dim>       &stencils,
                     const BackgroundGrid<dim> &grid)
  {
    std::set<CellOfBody<dim>> found, owned;
    for (const auto &group : stencils.groups)
      {
        const auto first = grid.key_above(group.origin);
        for_each_cell_of<dim>(group, [&](const auto &index) {
          found.insert({group.body, further<dim>(first, index)});
        });
      }
    std::map<unsigned int, std::vector<CellOfBody<dim>>> of_others;
    for (const auto &entry : found)
      {
        const auto cell = grid.cell_at(entry.second);
        AssertThrow(cell != grid.triangulation().end(),
                    dealii::ExcMessage("A cell of the stencils is unknown."));
        if (cell->is_locally_owned())
          owned.insert(entry);
        else
          of_others[cell->subdomain_id()].push_back(entry);
      }
    for (const auto &[sender, entries] :
         dealii::Utilities::MPI::some_to_some(grid.communicator(), of_others))
      {
        (void)sender;
        owned.insert(entries.begin(), entries.end());
      }
    return owned;
  }

  template std::set<CellOfBody<2>>
  owned_active_cells<2>(const Stencils<2> &, const BackgroundGrid<2> &);
  template std::set<CellOfBody<3>>
  owned_active_cells<3>(const Stencils<3> &, const BackgroundGrid<3> &);
} // namespace emmy
