// What the grid answers of cells and nodes by their keys.

#include <emmy/grid/background_grid.h>

#include <algorithm>

#include "../check.h"

using namespace emmy;

namespace
{
  template <int dim>
  void
  check_keys()
  {
    dealii::ParameterAcceptor::clear();
    GridParameters<dim> parameters;
    parameters.cells = std::vector<unsigned int>(dim, 3);
    double volume    = 1.;
    for (unsigned int d = 0; d < dim; ++d)
      {
        parameters.lower_corner[d] = -1. - d;
        parameters.upper_corner[d] = 0.5 + d;
        volume *= parameters.upper_corner[d] - parameters.lower_corner[d];
      }
    const BackgroundGrid<dim> grid(parameters, MPI_COMM_WORLD);
    CellKey<dim>              corner{}, middle;
    middle.fill(1);

    for (unsigned int face = 0; face < 2 * dim; ++face)
      {
        const auto beside = grid.neighbour(middle, face);
        test::check(beside && grid.neighbour(*beside, face ^ 1) == middle,
                    "a neighbour has this cell as its neighbour");
        test::check(grid.neighbour(corner, face).has_value() == (face % 2 == 1),
                    "there is nothing beyond a side");
      }
    const unsigned int two = 1 << dim, three = dim == 2 ? 9 : 27;
    test::check(grid.cells_around(middle).size() == three &&
                  grid.cells_around(corner).size() == two,
                "cells around a cell");
    test::check(grid.cells_at_node(middle).size() == two &&
                  grid.cells_at_node(corner) ==
                    std::vector<CellKey<dim>>{corner},
                "cells at a node");

    // sides, corners and nodes agree
    double all = 0.;
    for (const auto &cell : grid.cells_around(middle))
      {
        const auto far = grid.corner(node_of<dim>(cell, two - 1));
        test::check((far - grid.corner(cell) - grid.size_of(cell)).norm() <
                      1e-14,
                    "from corner to corner");
        test::check(grid.key_above(grid.corner(cell)) == cell,
                    "the cell above a node");
        dealii::Tensor<1, dim> quarter;
        for (unsigned int d = 0; d < dim; ++d)
          quarter[d] = 0.25;
        const auto x = grid.corner(cell) + 0.25 * grid.size_of(cell);
        test::check((dealii::Tensor<1, dim>(grid.reference_position(cell, x)) -
                     quarter)
                        .norm() < 1e-14,
                    "a position in the unit cell");
        for (unsigned int v = 0; v < two; ++v)
          {
            const auto node = node_of<dim>(cell, v);
            test::check(layers_between<dim>(node, cell) == 0,
                        "a cell has its nodes");
            all += grid.volume_of_node(grid.corner(node)) /
                   grid.cells_at_node(node).size();
          }
      }
    test::check_close(all, volume, 1e-13 * volume, "volumes of nodes fill it");

    // the same of blocks of two cells
    const unsigned int two_cells = 2;
    const CellKey<dim> block     = block_of<dim>(middle, two_cells);
    for (const auto &cell : grid.cells_around(middle))
      {
        const auto         weights = continued<dim>(block, cell, two_cells);
        dealii::Point<dim> sum;
        for (unsigned int v = 0; v < two; ++v)
          sum += weights[v] * grid.corner(node_of<dim>(block, v, two_cells));
        test::check(sum.distance(grid.corner(cell)) < 1e-13,
                    "continued polynomials of a block are linear");
        const auto center = grid.corner(block) + grid.size_of(block);
        test::check((grid.from_node_to_center(cell, block, two_cells) -
                     (center - grid.corner(cell)))
                        .norm() < 1e-13,
                    "from a node to the centre of a block");
      }

    // polynomials of a cell, continued to all nodes, give back positions
    for (const auto &cell : grid.cells_around(middle))
      {
        const auto         weights = continued<dim>(corner, cell);
        dealii::Point<dim> sum;
        for (unsigned int v = 0; v < two; ++v)
          sum += weights[v] * grid.corner(node_of<dim>(corner, v));
        test::check(sum.distance(grid.corner(cell)) < 1e-13,
                    "continued polynomials are linear");
        test::check(layers_between<dim>(cell, corner) ==
                      std::max(1u,
                               *std::max_element(cell.begin(), cell.end())) -
                        1,
                    "layers to a node");
        const auto center = grid.corner(corner) + 0.5 * grid.size_of(corner);
        test::check((grid.from_node_to_center(cell, corner) -
                     (center - grid.corner(cell)))
                        .norm() < 1e-13,
                    "from a node to a centre");
      }
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_keys<2>();
  check_keys<3>();
  return test::report();
}
