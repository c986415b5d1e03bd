// How the weights of a particle change with its place, position and
// half-lengths of its box, against centred differences: linear functions and
// GIMP, boxes within a cell, across faces, clipped at the edge of the grid,
// longer than two cells, and with corners that weigh nothing.

#include <emmy/particles/gimp.h>

#include <random>

#include "../check.h"

using namespace emmy;

namespace
{
  unsigned int n_compared = 0;

  /** The weights of the only particle: S and grad S of each node. */
  template <int dim>
  std::vector<double>
  weights(const Stencils<dim> &stencils)
  {
    const auto         &group = stencils.groups[0];
    std::vector<double> result;
    for (unsigned int a = 0; a < group.n_nodes; ++a)
      {
        result.push_back(stencils.value(group, a)[0]);
        for (unsigned int d = 0; d < dim; ++d)
          result.push_back(stencils.gradient(group, a, d)[0]);
      }
    return result;
  }

  template <int dim>
  void
  compare(const ShapeFunctions<dim> &shape_functions,
          const BackgroundGrid<dim> &grid,
          const Places<dim>         &places,
          const std::string         &what)
  {
    const Stencils<dim>   here  = shape_functions.evaluate(places, grid);
    const auto           &group = here.groups[0];
    PlaceDerivatives<dim> derivatives;
    shape_functions.differentiate(places, 0, group, grid, derivatives);
    const double step = 1e-6;
    for (unsigned int k = 0; k < PlaceDerivatives<dim>::n; ++k)
      {
        std::array<std::vector<double>, 2> around;
        bool                               is_smooth = true;
        for (const int side : {0, 1})
          {
            Places<dim>  moved  = places;
            const double change = side == 0 ? -step : step;
            if (k < dim)
              moved.positions[0][k] += change;
            else if (!places.half_lengths.empty())
              moved.half_lengths[0][k - dim] += change;
            moved.cells[0]   = grid.key_of(moved.positions[0]);
            const auto there = shape_functions.evaluate(moved, grid);
            is_smooth        = is_smooth && there.node_ids == here.node_ids;
            around[side]     = weights(there);
          }
        if (!is_smooth) // reaches other nodes on one side
          continue;
        ++n_compared;
        for (unsigned int a = 0; a < group.n_nodes; ++a)
          for (unsigned int d = 0; d <= dim; ++d)
            {
              const unsigned int i = a * (dim + 1) + d;
              const double       difference =
                (around[1][i] - around[0][i]) / (2. * step);
              test::check_close(d == 0 ? derivatives.value(k)[a]
                                       : derivatives.gradient(k, d - 1)[a],
                                difference,
                                2e-7,
                                what + ", with place " + std::to_string(k));
            }
      }
  }

  template <int dim>
  void
  check_functions()
  {
    dealii::ParameterAcceptor::clear();
    GridParameters<dim> parameters;
    for (unsigned int d = 0; d < dim; ++d)
      {
        parameters.cells[d]        = 5;
        parameters.lower_corner[d] = -0.5 + d;
        parameters.upper_corner[d] = 3. + 1.5 * d;
      }
    const BackgroundGrid<dim>               grid(parameters, MPI_COMM_WORLD);
    FieldLayout                             layout = basic_fields(dim);
    const LinearShapeFunctions<dim>         linear(layout["body"]);
    const GimpShapeFunctions<dim>           gimp(layout);
    dealii::Particles::ParticleHandler<dim> particles(grid.triangulation(),
                                                      grid.mapping(),
                                                      layout.n_components());
    CellKey<dim>                            middle;
    middle.fill(2);
    particles.insert_particle(grid.corner(middle),
                              dealii::Point<dim>(),
                              0,
                              grid.cell_at(middle));
    std::mt19937                           generator(3);
    std::uniform_real_distribution<double> unit(0., 1.);
    for (unsigned int sample = 0; sample < 200; ++sample)
      {
        Places<dim> places = linear.places(particles, grid);
        for (unsigned int d = 0; d < dim; ++d)
          places.positions[0][d] =
            grid.lower_corner()[d] +
            (grid.upper_corner()[d] - grid.lower_corner()[d]) * unit(generator);
        places.cells[0] = grid.key_of(places.positions[0]);
        compare<dim>(linear, grid, places, "linear");
        places.half_lengths.resize(1);
        for (unsigned int d = 0; d < dim; ++d)
          places.half_lengths[0][d] =
            grid.cell_size()[d] * (sample % 5 == 0
                                     ? 0.1 + unit(generator)
                                     : 0.05 + 0.4 * unit(generator));
        compare<dim>(gimp, grid, places, "GIMP");
        // corners that are left out, as they reach 1e-5 of a cell
        for (unsigned int d = 0; d < dim; ++d)
          {
            const double h            = grid.cell_size()[d];
            places.half_lengths[0][d] = (sample % 2 ? 0.25 : 0.7) * h;
            const double from_face    = places.half_lengths[0][d] - 1e-5 * h;
            const bool   is_lower     = (sample >> d) & 2;
            places.positions[0][d] =
              grid.corner(middle)[d] + (is_lower ? from_face : h - from_face);
          }
        places.cells[0]       = grid.key_of(places.positions[0]);
        const auto   stencils = gimp.evaluate(places, grid);
        const auto  &group    = stencils.groups[0];
        unsigned int n_in_box = 1;
        for (const unsigned int n : group.n_along)
          n_in_box *= n;
        test::check(group.n_nodes < n_in_box, "a corner is left out");
        compare<dim>(gimp, grid, places, "GIMP, corners left out");
      }
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_functions<2>();
  check_functions<3>();
  test::check(n_compared > 3000, "most places are compared");
  return test::report();
}
