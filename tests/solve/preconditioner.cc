// What the preconditioner of large systems can do: ILU without fill is exact
// where there is none, coarse boxes know rigid motions, and with both the
// iterations of a stiff lattice hardly grow with its size. On any number of
// ranks.

#include <deal.II/lac/lapack_full_matrix.h>
#include <deal.II/lac/trilinos_sparsity_pattern.h>

#include <emmy/solve/band_lu.h>
#include <emmy/solve/block_ilu.h>
#include <emmy/solve/coarse_boxes.h>
#include <emmy/solve/linear_solver.h>

#include "../check.h"

using namespace emmy;
using test::check;
using test::check_close;

namespace
{
  constexpr unsigned int dim   = 2;
  const MPI_Comm         world = MPI_COMM_WORLD;

  /**
   * Nodes of a lattice of unit cells whose sides and diagonals are springs of
   * stiffness one, each node with some mass; those of the first column are
   * held.
   */
  class Lattice
  {
  public:
    Lattice(const int      nx,
            const int      ny,
            const double   mass,
            const MPI_Comm communicator = world)
      : nx(nx)
      , ny(ny)
    {
      const unsigned int rank = dealii::Utilities::MPI::this_mpi_process(
                           communicator),
                         n_ranks = dealii::Utilities::MPI::n_mpi_processes(
                           communicator);
      const auto first = [&](const unsigned int part) {
        return dim * (nx * ny * part / n_ranks);
      };
      dealii::IndexSet rows(dim * nx * ny);
      rows.add_range(first(rank), first(rank + 1));
      rows.compress();
      dealii::TrilinosWrappers::SparsityPattern pattern(rows, communicator);
      for_each_entry(rows, mass, [&](const auto i, const auto j, const double) {
        pattern.add(i, j);
      });
      pattern.compress();
      matrix.reinit(pattern);
      for_each_entry(rows, mass, [&](auto i, auto j, const double value) {
        matrix.add(i, j, value);
      });
      matrix.compress(dealii::VectorOperation::add);
      places.cell_size = 1.;
      places.coordinates.reinit(rows, communicator);
      for (const auto i : rows)
        places.coordinates(i) =
          i % dim == 0 ? int(i / dim) / ny : int(i / dim) % ny;
      places.coordinates.compress(dealii::VectorOperation::insert);
    }

    /** A vector with a value for the place of each free unknown. */
    template <class Value>
    Vector
    vector(const Value &value) const
    {
      Vector result(places.coordinates);
      result = 0.;
      for (const auto i : result.locally_owned_elements())
        {
          const int node = i / dim;
          if (node >= ny)
            result(i) = value(node / ny, node % ny, i % dim);
        }
      result.compress(dealii::VectorOperation::insert);
      return result;
    }

    Matrix     matrix;
    NodePlaces places;

  private:
    template <class Function>
    void
    for_each_entry(const dealii::IndexSet &rows,
                   const double            mass,
                   const Function         &function) const
    {
      for (const auto row : rows)
        {
          const int node = row / dim, c = row % dim;
          const int x = node / ny, y = node % ny;
          function(row, row, x == 0 ? 1. : mass);
          for (int dx = -1; dx <= 1; ++dx)
            for (int dy = -1; dy <= 1; ++dy)
              {
                const bool is_inside =
                  x + dx >= 0 && x + dx < nx && y + dy >= 0 && y + dy < ny;
                if ((dx == 0 && dy == 0) || !is_inside)
                  continue;
                const int    direction[dim]{dx, dy};
                const double length = std::hypot(dx, dy);
                for (unsigned int d = 0; d < dim; ++d)
                  {
                    const double k =
                      direction[c] * direction[d] / (length * length);
                    const bool couples = x > 0 && x + dx > 0;
                    function(row, dim * node + d, x > 0 ? k : 0.);
                    function(row,
                             dim * ((x + dx) * ny + y + dy) + d,
                             couples ? -k : 0.);
                  }
              }
        }
    }

    const int nx, ny;
  };

  /**
   * A row of nodes has no fill, so ILU is LU, to single precision: of the nodes
   * of this rank and the neighbours that they have on others.
   */
  void
  check_no_fill(const int n)
  {
    const Lattice line(n, 1, 1.), whole(n, 1, 1., MPI_COMM_SELF);
    const auto    force = [](const int x, int, const int c) {
      return std::sin(1. + 3 * x * x + c);
    };
    const Vector  b = line.vector(force), all = whole.vector(force);
    BlockIlu<dim> ilu;
    ilu.make(line.matrix);
    Vector z(b);
    ilu.vmult(z, b);
    Vector twice(z);
    ilu.vmult_add(twice, b);
    twice.add(-2., z);
    check(twice.linfty_norm() == 0., "vmult_add adds what vmult gives");

    const auto &owned = b.locally_owned_elements();
    double      error = 0.;
    if (owned.n_elements() > 0)
      {
        const int first =
                    std::max(0, int(owned.nth_index_in_set(0)) - int(dim)),
                  last = std::min(dim * n,
                                  unsigned(*owned.begin() + owned.n_elements() +
                                           dim));
        dealii::LAPACKFullMatrix<double> part(last - first);
        dealii::Vector<double>           solution(last - first);
        for (int i = first; i < last; ++i)
          {
            solution[i - first] = all(i);
            for (int j = first; j < last; ++j)
              part(i - first, j - first) = whole.matrix.el(i, j);
          }
        part.compute_lu_factorization();
        part.solve(solution);
        for (const auto i : owned)
          error += std::abs(z(i) - solution[i - first]);
      }
    check_close(dealii::Utilities::MPI::sum(error, world) / z.l1_norm(),
                0.,
                1e-5,
                "ILU of a row of nodes");
  }

  /** A band is solved as a full matrix is, also where its diagonal is zero. */
  void
  check_band()
  {
    constexpr unsigned int           n = 50, width = 7;
    BandLu                           band;
    dealii::LAPACKFullMatrix<double> full(n);
    dealii::Vector<double>           expected(n);
    band.reinit(n, width);
    for (unsigned int i = 0; i < n; ++i)
      {
        expected[i] = std::sin(5. * i);
        for (unsigned int j = i > width ? i - width : 0;
             j < std::min(n, i + width + 1);
             ++j)
          full(i, j) = band(i, j) =
            i == j && i % 3 == 0 ? 0. : std::sin(1. + i * i + 2. * j);
      }
    std::vector<double> x(expected.begin(), expected.end());
    band.factorise();
    band.solve(x.data());
    full.compute_lu_factorization();
    full.solve(expected);
    double error = 0.;
    for (unsigned int i = 0; i < n; ++i)
      error = std::max(error, std::abs(x[i] - expected[i]));
    check_close(error / expected.linfty_norm(), 0., 1e-11, "a band");
  }

  /** A rigid motion of all that is free comes back from its forces. */
  void
  check_rigid_motions()
  {
    const Lattice    plate(40, 25, 0.01);
    CoarseBoxes<dim> boxes;
    boxes.make(plate.matrix, plate.places);
    for (unsigned int motion = 0; motion < 3; ++motion)
      {
        const Vector u =
          plate.vector([&](const int x, const int y, const int c) {
            if (motion < 2)
              return c == int(motion) ? 1. : 0.;
            return c == 0 ? -0.1 * y : 0.1 * x;
          });
        Vector force(u), found(u), rest(u);
        plate.matrix.vmult(force, u);
        boxes.correct(force, found, rest);
        found -= u;
        check_close(found.linfty_norm(), 0., 1e-5, "rigid motion");
        check_close(rest.l2_norm() / force.l2_norm(), 0., 1e-5, "nothing left");
      }
    // what is left has no share in the motions of any box
    const Vector r = plate.vector([](const int x, const int y, const int c) {
      return std::sin(1. + x * x + 2 * y * y + c);
    });
    Vector       y(r), rest(r), residual(r), again(r), nothing(r);
    boxes.correct(r, y, rest);
    plate.matrix.residual(residual, y, r);
    residual -= rest;
    check_close(residual.linfty_norm(), 0., 1e-10, "the rest is r - A y");
    boxes.correct(rest, again, nothing);
    check_close(again.linfty_norm() / y.linfty_norm(),
                0.,
                1e-6,
                "a second correction has nothing to do");
  }

  unsigned int
  iterations(const int      n,
             const bool     with_places,
             const MPI_Comm communicator = world)
  {
    const Lattice plate(n, n, 1e-4, communicator);
    const Vector  b = plate.vector([](const int x, const int y, const int c) {
      return c == 0 ? 0. : 1. + 0.1 * std::sin(x + 2. * y);
    });
    SolverParameters parameters;
    parameters.linear_solver = "GMRES";
    const auto solver        = make_linear_solver(parameters, b.size(), dim);
    solver->prepare(plate.matrix, with_places ? &plate.places : nullptr);
    Vector             x(b), residual(b);
    const LinearResult result = solver->solve(x, b, 1e-8);
    check(result.is_solved, "solved: " + result.problem);
    check(plate.matrix.residual(residual, x, b) <= 1.01e-8 * b.l2_norm(),
          "to the true residual");
    return result.iterations;
  }

  void
  check_iterations()
  {
    const unsigned int alone = iterations(60, false),
                       small = iterations(30, true),
                       large = iterations(60, true),
                       one   = iterations(60, true, MPI_COMM_SELF);
    const std::string text   = std::to_string(small) + " iterations on 30^2, " +
                             std::to_string(large) + " on 60^2, " +
                             std::to_string(alone) + " without boxes, " +
                             std::to_string(one) + " on one rank";
    std::cout << text << '\n';
    check(large <= 1.4 * small, "they hardly grow: " + text);
    check(2 * large <= alone, "boxes halve them: " + text);
    // one more: whether a last cycle of refinement is needed is round-off
    check(large <= 1.1 * one + 1, "ranks hardly add to them: " + text);
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_band();
  check_no_fill(200);
  check_no_fill(2); // with more ranks some own nothing
  check_rigid_motions();
  check_iterations();
  return test::report();
}
