// The mass as a number for a pair of nodes: its products are those of the
// matrix of all unknowns; gradients solve it under conditions, with followers
// and ghosts; and what ranks sum is what one rank has.

#include <emmy/solve/mass_solver.h>
#include <emmy/transfer/particles_to_grid.h>

#include "../check.h"
#include "../step/cloud.h"

namespace
{
  using namespace emmy;

  /** A cloud on the grid. */
  template <int dim>
  struct Mapped
  {
    test::Cloud<dim>     cloud;
    Stencils<dim>        stencils;
    PointArrays<dim>     points;
    ParticlesToGrid<dim> particles_to_grid;
    GridStart<dim>      &start;

    Mapped(const test::CloudOptions &options, const MPI_Comm communicator)
      : cloud(options, communicator)
      , stencils(cloud.shape_functions->evaluate(cloud.particles, *cloud.grid))
      , points(gather(stencils, cloud.layout))
      , particles_to_grid(*cloud.grid,
                          *cloud.boundary_conditions,
                          cloud.layout,
                          {0.1, 1.})
      , start(particles_to_grid(stencils, points, couplings()))
    {}

    Couplings<dim>
    couplings() const
    {
      cloud.balance->classify(stencils, points, *cloud.grid, nullptr);
      return cloud.balance->couplings(stencils,
                                      *cloud.grid,
                                      *cloud.boundary_conditions,
                                      nullptr);
    }

    /** A vector that depends on places only. */
    Vector
    wave(const double phase) const
    {
      Vector      result = start.active->make_vector();
      const auto &x      = start.active->places().coordinates;
      const auto  first  = x.begin();
      for (unsigned int i = 0; i < x.locally_owned_size(); ++i)
        {
          double argument = phase + i % dim;
          for (unsigned int d = 0; d < dim; ++d)
            argument += (2. + d) * *(first + (i / dim * dim + d));
          *(result.begin() + i) = std::sin(argument);
        }
      return result;
    }
  };

  /** a . A b */
  double
  form(const Vector &a, const Matrix &A, const Vector &b)
  {
    Vector product = a;
    A.vmult(product, b);
    return a * product;
  }

  template <int dim>
  void
  test_mass(const test::CloudOptions &options, const std::string &what)
  {
    using Conditions = typename NodalMatrix<dim>::Conditions;
    Mapped<dim> shared(options, MPI_COMM_WORLD), alone(options, MPI_COMM_SELF);
    const GridStart<dim> &start = shared.start;
    const Vector          a = shared.wave(0.), b = shared.wave(1.);
    const Vector          a_alone = alone.wave(0.), b_alone = alone.wave(1.);

    for (const Conditions conditions :
         {Conditions::left_out, Conditions::worked_in})
      {
        const bool   with = conditions == Conditions::worked_in;
        const Matrix M    = mass_of_unknowns(start, conditions, Damped::no),
                     N = mass_of_unknowns(alone.start, conditions, Damped::no);
        const std::string which =
          what + (with ? ", with conditions" : ", without conditions");
        test::check_close(form(a, M, b),
                          form(a_alone, N, b_alone),
                          1e-13 * N.frobenius_norm(),
                          which + ": as on one rank");
        test::check_close(form(a, M, b),
                          form(b, M, a),
                          1e-13 * N.frobenius_norm(),
                          which + ": symmetric");
        test::check_close(M.frobenius_norm(),
                          N.frobenius_norm(),
                          1e-13 * N.frobenius_norm(),
                          which + ": its norm");

        Vector             v = start.active->make_vector();
        const LinearResult result =
          MassSolver<dim>(start.mass, start.damping, conditions)
            .solve(v, start.momentum);
        test::check(result.is_solved, which + ": solved " + result.problem);
        Vector left = start.active->make_vector();
        start.mass.residual(left, v, start.momentum);
        if (with)
          start.active->constraints().condense(left);
        test::check_close(left.l2_norm(),
                          0.,
                          1e-14 * start.momentum.l2_norm(),
                          which + ": what is left");
        Vector expanded = v;
        if (with)
          start.active->constraints().expand(expanded);
        expanded -= v;
        test::check(expanded.l2_norm() <= 1e-14 * v.l2_norm(),
                    which + ": the velocity keeps the conditions");
      }

    Vector product = a, sums = a;
    start.mass.vmult(product, a);
    mass_of_unknowns(start, Conditions::left_out, Damped::no).vmult(sums, a);
    sums -= product;
    test::check(sums.l2_norm() <= 1e-14 * product.l2_norm(),
                what + ": a product is that of the matrix");
    test::check_close(start.mass.matrix_norm_square(a),
                      a * product,
                      1e-14 * (a * product),
                      what + ": a . M a");
  }
} // namespace

int
main(int argc, char **argv)
{
  const dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  test::CloudOptions                             options;
  options.n_points = 400;
  options.roller   = {"x-min"};
  options.fixed    = {"y-max"};
  test_mass<2>(options, "in the plane");
  test_mass<3>(options, "in space");
  options.gimp = true;
  test_mass<2>(options, "GIMP");
  options.ghost_mass = 0.25;
  test_mass<2>(options, "ghosts");
  test_mass<3>(options, "ghosts in space");
  options.ghost_mass  = 0.;
  options.aggregation = 0.5;
  test_mass<2>(options, "followers");
  test_mass<3>(options, "followers in space");
  return test::report();
}
