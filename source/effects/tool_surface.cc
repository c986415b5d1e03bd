#include <emmy/effects/tool_surface.h>

#include <deal.II/dofs/dof_handler.h>

#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/mapping_q1.h>

#include <deal.II/grid/grid_generator.h>
#include <deal.II/grid/grid_tools.h>
#include <deal.II/grid/tria.h>

#include <deal.II/lac/vector.h>

#include <algorithm>
#include <cmath>

namespace emmy
{
  template <int dim>
  Surface<dim>
  surface_of(const ToolShape<dim>         &shape,
             const dealii::Point<dim>     &place,
             const dealii::Tensor<2, dim> &directions,
             const dealii::Point<dim>     &lower,
             const dealii::Point<dim>     &upper)
  {
    constexpr double most = dim == 2 ? 200. : 40.;

    const dealii::Tensor<1, dim> size    = upper - lower;
    double                       longest = 0.;
    for (unsigned int d = 0; d < dim; ++d)
      longest = std::max(longest, size[d]);
    std::vector<unsigned int> n_cells(dim);
    for (unsigned int d = 0; d < dim; ++d)
      n_cells[d] = std::ceil(most * size[d] / longest);
    dealii::Triangulation<dim> lattice;
    dealii::GridGenerator::subdivided_hyper_rectangle(lattice,
                                                      n_cells,
                                                      lower,
                                                      upper);
    const dealii::FE_Q<dim>      element(1);
    dealii::DoFHandler<dim>      numbering(lattice);
    const dealii::MappingQ1<dim> mapping;
    numbering.distribute_dofs(element);

    const auto             turned = transpose(directions);
    dealii::Vector<double> distance(numbering.n_dofs());
    for (const auto &cell : numbering.active_cell_iterators())
      for (const unsigned int v : cell->vertex_indices())
        distance(cell->vertex_dof_index(v, 0)) =
          shape.distance(turned * (cell->vertex(v) - place)).value;

    std::vector<dealii::Point<dim>>        vertices;
    std::vector<dealii::CellData<dim - 1>> cells;
    dealii::GridTools::MarchingCubeAlgorithm<dim, dealii::Vector<double>>(
      mapping, element)
      .process(numbering, distance, 0., vertices, cells);

    Surface<dim> result;
    for (const auto &cell : cells)
      {
        auto &facet = result.facets.emplace_back();
        for (unsigned int i = 0; i < dim; ++i)
          facet[i] = vertices[cell.vertices[i]];
      }
    return result;
  }

  template Surface<2>
  surface_of(const ToolShape<2> &,
             const dealii::Point<2> &,
             const dealii::Tensor<2, 2> &,
             const dealii::Point<2> &,
             const dealii::Point<2> &);
  template Surface<3>
  surface_of(const ToolShape<3> &,
             const dealii::Point<3> &,
             const dealii::Tensor<2, 3> &,
             const dealii::Point<3> &,
             const dealii::Point<3> &);
} // namespace emmy
