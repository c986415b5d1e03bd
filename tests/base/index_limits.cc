// Numbers that 32 bits do not hold are refused in words, one below is not. A
// grid that is too large for its places or cells is refused before it is made.

#include <emmy/base/index_limits.h>
#include <emmy/grid/background_grid.h>

#include "../check.h"

namespace
{
  using namespace emmy;
  using test::check;
  using test::check_throws_with;

  const MPI_Comm world = MPI_COMM_WORLD;

  void
  check_numbers()
  {
    const std::uint64_t most = 2147483647; // 2^31 - 1
    refuse_unknowns(most);
    check_throws_with([&] { refuse_unknowns(most + 1); },
                      {"Grid: 2.14748e+09 unknowns",
                       "end at 2147483647",
                       "fewer Cells"});
    check_throws_with([&] { refuse_unknowns(3 * (std::uint64_t(1) << 32)); },
                      {"1.28849e+10 unknowns"});
    refuse_matrix_entries(most, world);
    // on the last rank alone: all throw
    const bool is_last = dealii::Utilities::MPI::this_mpi_process(world) + 1 ==
                         dealii::Utilities::MPI::n_mpi_processes(world);
    check_throws_with(
      [&] { refuse_matrix_entries(is_last ? most + 1 : 1, world); },
      {"entries of a matrix on one rank", "start on more ranks"});
    refuse_cells(4294967294., 4294967294.);
    check_throws_with([&] { refuse_cells(4294967295., 1.); },
                      {"4.29497e+09 cells", "end at 4294967294"});
    check_throws_with([&] { refuse_cells(1., 4294967295.); },
                      {"4.29497e+09 nodes"});
  }

  /** The unit square or cube, n cells across. */
  template <int dim>
  struct Large : GridParameters<dim>
  {
    explicit Large(const unsigned int n)
    {
      for (unsigned int d = 0; d < dim; ++d)
        this->upper_corner[d] = 1.;
      this->cells.assign(dim, n);
    }
  };

  void
  check_grids()
  {
    using Grid = BackgroundGrid<2>;
    // 2^34 cells, which cost nothing unless they are made
    const Large<2> wide(1 << 17);
    check_throws_with([&] { Grid(wide, world, Grid::Cells::all); },
                      {"Grid: 1.71799e+10 cells"});
    // bodies that are everywhere make all of them
    Grid covered(wide, world, Grid::Cells::none);
    std::vector<typename Grid::Occupied> everywhere;
    for (unsigned int i = 0; i < 64; ++i)
      for (unsigned int j = 0; j < 64; ++j)
        everywhere.push_back({{{2048 * i, 2048 * j}}, 1});
    check_throws_with([&] { covered.cover(everywhere); },
                      {"cells around the bodies"});
    // 2^93 places
    check_throws_with(
      [] {
        BackgroundGrid<3>(Large<3>(2147483647),
                          world,
                          BackgroundGrid<3>::Cells::none);
      },
      {"Grid: 9.90352e+27 places for cells", "fewer Cells"});
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_numbers();
  check_grids();
  return test::report();
}
