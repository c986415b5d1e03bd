// Walls that move remember how far, and go no further than they may.

#include <emmy/base/exceptions.h>
#include <emmy/effects/moving_walls.h>

#include "../check.h"

using namespace emmy;

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  GridParameters<2>                        grid_parameters;
  grid_parameters.cells        = {2, 2};
  grid_parameters.upper_corner = dealii::Point<2>(2., 2.);
  const BackgroundGrid<2> grid(grid_parameters, MPI_COMM_WORLD);
  BoundaryParameters      boundary;
  boundary.fixed = {"x-max"};
  const BoundaryConditions<2> conditions(boundary, grid);
  MovingWallParameters        parameters(2);
  test::check(!parameters.are_present(), "no wall moves unless it is told to");
  parameters.velocities[1] = "0.004; 0.1*t";
  test::check(parameters.are_present(), "this one moves");

  MovingWalls<2> walls(parameters, conditions, grid);
  for (const double time : {0., 1.})
    {
      walls.check_step(time, 1., "here"); // leaves no trace
      walls.check_step(time, 1., "here");
      walls.end_step(time, 1.);
    }
  const std::vector<double> memory = walls.contents();
  for (unsigned int i = 0; i < 8; ++i)
    test::check_close(memory.at(i),
                      i == 2 ? 0.008 : (i == 3 ? 0.2 : 0.),
                      1e-15,
                      "how far sides have moved");
  const std::vector<std::string> refused{"here",
                                         "x-max would have moved by 0.012 m"};
  test::check_throws_with([&] { walls.check_step(2., 1., "here"); }, refused);

  MovingWalls<2> later(parameters, conditions, grid);
  later.check_step(2., 1., "here"); // for all it knows
  later.recall({memory, memory});
  test::check_throws_with([&] { later.check_step(2., 1., "here"); }, refused);
  test::check(later.contents() == memory, "what is recalled is remembered");
  return test::report();
}
