// The limit of travel: nothing passes through something else in a step, and
// what flies or turns as a whole is not slowed.

#include <deal.II/base/mpi.h>

#include <emmy/particles/field_layout.h>
#include <emmy/step/travel_limit.h>

#include <functional>
#include <limits>
#include <random>

#include "../check.h"

namespace
{
  using namespace emmy;
  using namespace emmy::test;
  using dealii::Point;
  using dealii::Tensor;

  /** A grid of cells of half a metre, with a wall at x-max. */
  template <int dim>
  struct Scatter
  {
    GridParameters<dim>                      grid_parameters;
    BoundaryParameters                       boundary_parameters;
    std::unique_ptr<BackgroundGrid<dim>>     grid;
    std::unique_ptr<BoundaryConditions<dim>> boundary_conditions;
    FieldLayout                              layout = basic_fields(dim);
    std::vector<Point<dim>>                  x;
    std::vector<Tensor<1, dim>>              v;

    Scatter()
    {
      grid_parameters.cells = std::vector<unsigned int>(dim, 40);
      for (unsigned int d = 0; d < dim; ++d)
        {
          grid_parameters.lower_corner[d] = -5.;
          grid_parameters.upper_corner[d] = 15.;
        }
      boundary_parameters.roller = {"x-max"};
      grid =
        std::make_unique<BackgroundGrid<dim>>(grid_parameters,
                                              MPI_COMM_WORLD,
                                              BackgroundGrid<dim>::Cells::none);
      boundary_conditions =
        std::make_unique<BoundaryConditions<dim>>(boundary_parameters, *grid);
    }

    /** A cube with four particles in a cell's length. */
    void
    add_cube(const Point<dim>                                        &corner,
             const double                                             length,
             const std::function<Tensor<1, dim>(const Point<dim> &)> &velocity)
    {
      const unsigned int n = std::lround(length / 0.125);
      for (unsigned int i = 0; i + 0.5 < std::pow(n, dim); ++i)
        {
          Point<dim> at = corner;
          for (unsigned int d = 0, rest = i; d < dim; ++d, rest /= n)
            at[d] += (rest % n + 0.5) * 0.125;
          x.push_back(at);
          v.push_back(velocity(at));
        }
    }

    /** The step that is allowed if a second is asked for; ranks share. */
    double
    operator()(const double travel = 0.5) const
    {
      const unsigned int n_ranks = dealii::Utilities::MPI::n_mpi_processes(
                           MPI_COMM_WORLD),
                         rank = dealii::Utilities::MPI::this_mpi_process(
                           MPI_COMM_WORLD);
      std::vector<std::size_t> own;
      for (std::size_t p = 0; p < x.size(); ++p)
        if (grid->key_of(x[p])[1] % n_ranks == rank)
          own.push_back(p);
      PointArrays<dim> points(own.size(), layout.n_components());
      for (std::size_t q = 0; q < own.size(); ++q)
        {
          for (unsigned int d = 0; d < dim; ++d)
            points.position(d)[q] = x[own[q]][d];
          points.set(layout["velocity"], q, v[own[q]]);
          points.component(layout["mass"])[q] = 2.;
        }
      return TravelLimit<dim>(travel, *grid, *boundary_conditions)(
        1., points, layout["velocity"], layout["mass"]);
    }
  };

  template <int dim>
  Tensor<1, dim>
  along_x(const double speed)
  {
    Tensor<1, dim> v;
    v[0] = speed;
    return v;
  }

  template <int dim>
  Point<dim>
  at(const double first, const double other)
  {
    Point<dim> result;
    for (unsigned int d = 0; d < dim; ++d)
      result[d] = d == 0 ? first : other;
    return result;
  }

  template <int dim>
  void
  check_free_motion()
  {
    const std::string space = std::to_string(dim) + "D: ";
    Scatter<dim>      flight;
    flight.add_cube(at<dim>(0., 0.), 2., [](const auto &) {
      return along_x<dim>(-400.);
    });
    check_close(flight(), 1., 0., space + "a body that flies is not slowed");

    for (const double turn : {0.5, 3.})
      {
        Scatter<dim> spin;
        spin.add_cube(at<dim>(4., 4.), 3., [turn](const auto &x) {
          Tensor<1, dim> v;
          v[0] = -turn * (x[1] - 5.5);
          v[1] = turn * (x[0] - 5.5);
          return v;
        });
        check_close(spin(), 1., 0., space + "a body that turns is not slowed");
      }

    Scatter<dim> passing;
    passing.add_cube(at<dim>(-4., 0.), 1., [](const auto &) {
      return along_x<dim>(12.);
    });
    passing.add_cube(at<dim>(3., 5.), 1., [](const auto &) {
      return along_x<dim>(0.);
    });
    check_close(passing(), 1., 0., space + "nor are bodies that miss");

    Scatter<dim> parting;
    parting.add_cube(at<dim>(2., 0.), 1., [](const auto &) {
      return along_x<dim>(9.);
    });
    parting.add_cube(at<dim>(0., 0.), 1., [](const auto &) {
      return along_x<dim>(0.);
    });
    check_close(parting(), 1., 0., space + "nor those that part");
  }

  template <int dim>
  void
  check_meetings()
  {
    const std::string space = std::to_string(dim) + "D: ";
    // means of cells lie in their middle: front ones at 0.75 and 5.25 m
    Scatter<dim> approach;
    approach.add_cube(at<dim>(0., 0.), 1., [](const auto &) {
      return along_x<dim>(6.);
    });
    approach.add_cube(at<dim>(5., 0.), 1., [](const auto &) {
      return along_x<dim>(-4.);
    });
    check_close(approach(),
                (4.5 - 1.) / 10.,
                1e-12,
                space + "parts come to two cells from one another");

    Scatter<dim> contact;
    contact.add_cube(at<dim>(0., 0.), 1., [](const auto &) {
      return along_x<dim>(6.);
    });
    contact.add_cube(at<dim>(1., 0.), 1., [](const auto &) {
      return along_x<dim>(-4.);
    });
    check_close(contact(),
                0.25 / 10.,
                1e-12,
                space + "where they meet, half a cell nearer");
    check_close(contact(0.1), 0.05 / 10., 1e-12, space + "or what is asked");

    Scatter<dim> wall; // the front particles at 2 - 0.0625 m
    wall.add_cube(at<dim>(1., 0.), 1., [](const auto &) {
      return along_x<dim>(20.);
    });
    check_close(wall(),
                (15. - 0.5 - 1.9375) / 20.,
                1e-12,
                space + "a particle comes to a cell from a wall");
    Scatter<dim> open;
    open.add_cube(at<dim>(1., 0.), 1., [](const auto &) {
      return along_x<dim>(-20.);
    });
    check_close(open(), 1., 0., space + "an open side is no wall");
    Scatter<dim> at_wall;
    at_wall.add_cube(at<dim>(14., 0.), 1., [](const auto &) {
      return along_x<dim>(20.);
    });
    check_close(at_wall(), 0.25 / 20., 1e-12, space + "at a wall half a cell");
  }

  /** The tree leaves out no pair: it finds what any one pair allows. */
  template <int dim>
  void
  check_tree()
  {
    using Part = typename TravelLimit<dim>::Part;
    std::mt19937                           generator(7);
    std::uniform_real_distribution<double> unit(-1., 1.);
    double                                 shortest = 1.;
    for (unsigned int trial = 0; trial < 20; ++trial)
      {
        std::vector<Part> parts(25);
        const double      speed = std::pow(10., 1. + unit(generator));
        for (Part &part : parts)
          for (unsigned int d = 0; d < dim; ++d)
            {
              part.x[d] = 10. * unit(generator);
              part.v[d] = speed * unit(generator);
            }
        double by_pairs = 1.;
        for (const Part &a : parts)
          for (const Part &b : parts)
            by_pairs =
              std::min(by_pairs, time_to_meeting<dim>({a}, {b}, 0.5, 1.));
        check_close(time_to_meeting<dim>(parts, parts, 0.5, 1.),
                    by_pairs,
                    0.,
                    "tree of " + std::to_string(dim) + "D parts");
        shortest = std::min(shortest, by_pairs);
      }
    check(shortest < 0.1, "some of the random parts meet");
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_free_motion<2>();
  check_free_motion<3>();
  check_meetings<2>();
  check_meetings<3>();
  check_tree<2>();
  check_tree<3>();
  return report();
}
