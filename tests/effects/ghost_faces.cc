// The matrix of ghost stabilisation against its definition by quadrature, its
// kernel and its sign; and the set of ghost faces of a block in the middle of
// the grid, of a sliver, and of a block at a wall and at a free side.

#include <deal.II/base/quadrature_lib.h>

#include <deal.II/lac/lapack_full_matrix.h>

#include <emmy/effects/ghost_faces.h>
#include <emmy/material/hencky.h>
#include <emmy/particles/field_layout.h>

#include <random>

#include "../check.h"

using namespace emmy;

namespace
{
  template <int dim>
  dealii::Tensor<1, dim>
  sizes()
  {
    dealii::Tensor<1, dim> h;
    for (unsigned int d = 0; d < dim; ++d)
      h[d] = 0.3 + 0.2 * d;
    return h;
  }

  /** Nodes of a face from the lower corner, layer by layer. */
  template <int dim>
  std::vector<dealii::Point<dim>>
  nodes(const unsigned int direction)
  {
    std::vector<dealii::Point<dim>> result;
    for (unsigned int layer = 0; layer < 3; ++layer)
      for (unsigned int i = 0; i < GhostFace<dim>::nodes_per_layer; ++i)
        {
          dealii::Point<dim> x;
          for (unsigned int d = 0, bit = 0; d < dim; ++d)
            x[d] =
              sizes<dim>()[d] * (d == direction ? layer : (i >> bit++) % 2);
          result.push_back(x);
        }
    return result;
  }

  /** h^3/3 int over the face of [d_n N_a][d_n N_b]. */
  template <int dim>
  double
  by_quadrature(const unsigned int direction,
                const unsigned int a,
                const unsigned int b)
  {
    const auto                    h = sizes<dim>();
    const dealii::QGauss<dim - 1> gauss(2);
    const auto                    x   = nodes<dim>(direction);
    double                        sum = 0.;
    for (unsigned int q = 0; q < gauss.size(); ++q)
      {
        // a hat's slope in normal direction on both sides, times the others
        const auto jump = [&](const dealii::Point<dim> &node) {
          const double layer = node[direction] / h[direction];
          const double below = layer < 0.5   ? -1.
                               : layer < 1.5 ? 1.
                                             : 0.,
                       above = layer < 0.5   ? 0.
                               : layer < 1.5 ? -1.
                                             : 1.;
          double value       = (above - below) / h[direction];
          for (unsigned int d = 0, i = 0; d < dim; ++d)
            if (d != direction)
              value *= 1. - std::abs(gauss.point(q)[i++] - node[d] / h[d]);
          return value;
        };
        sum += gauss.weight(q) * jump(x[a]) * jump(x[b]);
      }
    double area = 1.;
    for (unsigned int d = 0; d < dim; ++d)
      area *= d == direction ? 1. : h[d];
    return std::pow(h[direction], 3) / 3. * area * sum;
  }

  template <int dim>
  void
  check_matrix()
  {
    constexpr unsigned int n = GhostFace<dim>::n_nodes;
    for (unsigned int direction = 0; direction < dim; ++direction)
      {
        const std::string name =
          std::to_string(dim) + "D, normal " + std::to_string(direction) + ": ";
        const auto J = ghost_matrix<dim>(direction, sizes<dim>());
        for (unsigned int a = 0; a < n; ++a)
          for (unsigned int b = 0; b < n; ++b)
            {
              test::check_close(J(a, b),
                                by_quadrature<dim>(direction, a, b),
                                1e-15,
                                name + "J by quadrature");
              test::check_close(J(a, b), J(b, a), 0., name + "J is symmetric");
            }
        // multilinear fields, the affine ones among them, have no jump
        const auto x = nodes<dim>(direction);
        for (unsigned int powers = 0; powers < (1u << dim); ++powers)
          {
            dealii::Vector<double> field(n), product(n);
            for (unsigned int a = 0; a < n; ++a)
              {
                field[a] = 1.;
                for (unsigned int d = 0; d < dim; ++d)
                  field[a] *= (powers >> d) % 2 ? x[a][d] : 1.;
              }
            J.vmult(product, field);
            test::check_close(product.linfty_norm(),
                              0.,
                              1e-16,
                              name + "the kernel holds multilinear fields");
          }
        dealii::LAPACKFullMatrix<double> copy(n, n);
        copy = J;
        copy.compute_eigenvalues();
        for (unsigned int i = 0; i < n; ++i)
          {
            test::check(copy.eigenvalue(i).real() > -1e-16,
                        name + "J is positive semi-definite");
            test::check(std::abs(copy.eigenvalue(i).imag()) < 1e-16,
                        name + "eigenvalues are real");
          }
      }
  }

  /** How many ghost faces particles at the centres of these cells have. */
  unsigned int
  n_faces(const std::vector<std::array<unsigned int, 2>> &cells,
          const std::vector<std::string>                 &rollers)
  {
    dealii::ParameterAcceptor::clear();
    GridParameters<2> parameters;
    parameters.cells        = {8, 6};
    parameters.upper_corner = dealii::Point<2>(4., 3.);
    const BackgroundGrid<2> grid(parameters, MPI_COMM_WORLD);
    BoundaryParameters      boundary;
    boundary.roller = rollers;
    const BoundaryConditions<2> walls(boundary, grid);

    FieldLayout                           layout = basic_fields(2);
    const LinearShapeFunctions<2>         shape_functions(layout["body"]);
    dealii::Particles::ParticleHandler<2> particles(grid.triangulation(),
                                                    grid.mapping(),
                                                    layout.n_components());
    const std::vector<double>             values = layout.initial_values();
    unsigned int                          id     = 0;
    for (const auto &index : cells)
      {
        const auto cell = grid.cell_at(index);
        if (cell != grid.triangulation().end() && cell->is_locally_owned())
          particles.insert_particle(
            cell->center(),
            dealii::Point<2>(0.5, 0.5),
            id,
            cell,
            dealii::ArrayView<const double>(values.data(), values.size()));
        ++id;
      }
    particles.update_cached_numbers();

    ElasticConstants constants;
    constants.density       = 2.;
    constants.young_modulus = 3.;
    constants.poisson_ratio = 0.;
    const Hencky<2>     material(constants.completed("test"));
    const GhostFaces<2> find(0.25, 0.01, {&material});
    const auto          faces =
      find(shape_functions.evaluate(particles, grid), grid, walls);
    for (const auto &face : faces)
      {
        test::check_close(face.mass, 0.25 * 2., 1e-15, "gamma_M rho");
        test::check_close(face.stiffness,
                          0.01 * 3. / (0.5 * 0.5),
                          1e-15,
                          "gamma_K E/h^2");
      }
    return dealii::Utilities::MPI::sum(static_cast<unsigned int>(faces.size()),
                                       MPI_COMM_WORLD);
  }

  /** Cells of a block: first and last in each direction. */
  std::vector<std::array<unsigned int, 2>>
  block(const unsigned int i0,
        const unsigned int i1,
        const unsigned int j0,
        const unsigned int j1)
  {
    std::vector<std::array<unsigned int, 2>> cells;
    for (unsigned int i = i0; i <= i1; ++i)
      for (unsigned int j = j0; j <= j1; ++j)
        cells.push_back({{i, j}});
    return cells;
  }

  void
  check_faces()
  {
    // 4 x 4 cells: 24 inner faces, but not the 4 between the 4 inner cells
    test::check(n_faces(block(2, 5, 1, 4), {}) == 20, "a block");
    test::check(n_faces({{{3, 3}}}, {}) == 0, "a lonely cell has no face");
    test::check(n_faces(block(2, 5, 3, 3), {}) == 3, "a row of cells");
    // a block that fills the grid: its outer cells are at free sides
    test::check(n_faces(block(0, 7, 0, 5), {}) ==
                  (7 * 6 + 8 * 5) - (5 * 4 + 6 * 3),
                "free sides of the grid are boundaries");
    test::check(n_faces(block(0, 7, 0, 5),
                        {"x-min", "x-max", "y-min", "y-max"}) == 0,
                "walls are not");
    // one cell beside a wall, with a neighbour away from it
    test::check(n_faces(block(0, 1, 2, 2), {"x-min"}) == 1,
                "a sliver at a wall is bound to its neighbour");
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_matrix<2>();
  check_matrix<3>();
  check_faces();
  return test::report();
}
