/**
 * Where no body is near the grid has no cells, and nobody can tell: bodies that
 * fly through a large grid, followed by windows, have bitwise the ledger that
 * they have in a small grid with the same lattice. In parallel, ranks agree.
 */
#include <algorithm>

#include "../scene.h"

namespace
{
  using namespace emmy;
  using namespace emmy::test;

  using Settings = std::vector<std::string>;

  unsigned int
  n_ranks()
  {
    return dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD);
  }

  Settings
  operator+(Settings a, const Settings &b)
  {
    a.insert(a.end(), b.begin(), b.end());
    return a;
  }

  /** Cells that are there over those of the grid. */
  template <int dim>
  double
  share_of_cells(const BackgroundGrid<dim> &grid)
  {
    double n_cells = grid.triangulation().n_global_active_cells();
    for (const unsigned int n : grid.n_cells())
      n_cells /= n;
    return n_cells;
  }

  /** A run, and how often the window moved. */
  template <int dim>
  struct Flight
  {
    SceneParameters<dim> parameters;
    RunningScene<dim>    run;
    unsigned int         n_moves = 0;

    Flight(ParameterFile      file,
           const Settings    &settings,
           const unsigned int n_steps,
           const MPI_Comm     communicator)
      : parameters(changed(file, settings))
      , run(parameters, communicator)
    {
      run.most_residual_work = 1e-7; // some have nodes with next to no mass
      for (unsigned int step = 0; step < n_steps; ++step)
        {
          const auto blocks = run.scene.grid.window().blocks();
          run.advance(1);
          n_moves += run.scene.grid.window().blocks() != blocks;
        }
    }

    static const ParameterFile &
    changed(ParameterFile &file, const Settings &settings)
    {
      for (const std::string &assignment : settings)
        file.set(assignment);
      return file;
    }
  };

  template <int dim>
  void
  check_bitwise(const std::string       &name,
                const RunningScene<dim> &a,
                const RunningScene<dim> &b)
  {
    check(a.ledger.columns() == b.ledger.columns(), name + ": same columns");
    check(a.ledger.rows().size() == b.ledger.rows().size(),
          name + ": as many rows");
    for (const std::string &column : a.ledger.columns())
      check(a.column(column) == b.column(column),
            name + ": " + column + " is bitwise the same");
    check(largest(a.column("strain_energy")) > 0.,
          name + ": the bodies are strained");
  }

  template <int dim>
  void
  check_flight(const std::string   &what,
               const ParameterFile &file,
               const Settings      &method,
               const Settings      &small_grid,
               const Settings      &large_grid,
               const unsigned int   n_steps)
  {
    const std::string name = std::to_string(dim) + "D, " + what;
    const Flight<dim> small(file, method + small_grid, n_steps, MPI_COMM_SELF),
      large(file, method + large_grid, n_steps, MPI_COMM_SELF);
    check_bitwise(name, small.run, large.run);
    const double share = share_of_cells(large.run.scene.grid);
    if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
      std::cout << name << ": " << large.n_moves << " moves of the window, "
                << 100. * share << " % of the cells exist\n";
    check(large.n_moves >= 2, name + ": the window moves");
    check(share < 0.02, name + ": the empty part has no cells");
    if (n_ranks() == 1)
      return;
    const Flight<dim> ranks(file, method + large_grid, n_steps, MPI_COMM_WORLD);
    check(ranks.n_moves >= 2, name + ": the window moves on all ranks");
    for (const std::string &column : small.run.ledger.columns())
      if (column != "residual_work" && column != "balance_error" &&
          column != "linear_iterations" && column != "newton_iterations")
        {
          const auto a = small.run.column(column), b = ranks.run.column(column);
          const double scale = std::max(1., largest(a));
          for (unsigned int row = 0; row < a.size(); ++row)
            check_close(b[row],
                        a[row],
                        1e-10 * scale,
                        name + ": ranks agree, " + column);
        }
  }

  void
  check_flights(const ParameterFile &two_balls)
  {
    const ParameterFile discs =
      ParameterFile::from_text(collision_text(3), "test");
    const Settings small{"Grid/Upper corner=20, 20", "Grid/Cells=40, 40"},
      large{"Grid/Lower corner=-100, 0",
            "Grid/Upper corner=100, 200",
            "Grid/Cells=400, 400"},
      fast{"Bodies/left/Initial velocity=4.9; 3.1",
           "Bodies/right/Initial velocity=3.3; 3",
           "Time/Step rule=fixed",
           "Time/Step size=0.05"};
    // to the scene's end: later a step takes 85 iterations, as free nodes
    // starve, and round-off grows beyond the bound, on 6 ranks or by another
    // cut
    check_flight<2>("linear", discs, fast, small, large, 40);
    check_flight<2>("GIMP, ghost stabilisation",
                    discs,
                    fast + Settings{"Method/Shape functions=GIMP",
                                    "Effects/Names=ghost stabilisation"},
                    small,
                    large,
                    50);
    // along the floor, which is y-min of both grids
    check_flight<2>("aggregation, floor",
                    discs,
                    fast + Settings{"Method/Starved nodes=follow",
                                    "Effects/Names=gravity",
                                    "Effects/Gravity/Acceleration=0, -1.5",
                                    "Boundary conditions/Roller=y-min",
                                    "Bodies/left/Initial velocity=4.9; 0"},
                    small,
                    large,
                    50);
    check_flight<3>("ghost stabilisation",
                    two_balls,
                    {"Effects/Names=ghost stabilisation",
                     "Bodies/left/Initial velocity=5; 4; 3",
                     "Bodies/right/Initial velocity=3; 4; 3",
                     "Bodies/left/Points per direction=3",
                     "Bodies/right/Points per direction=3",
                     "Time/Step rule=fixed",
                     "Time/Step size=0.14",
                     "Solver/Newton tolerance=1e-15"},
                    {"Grid/Upper corner=48, 48, 48", "Grid/Cells=24, 24, 24"},
                    {"Grid/Lower corner=-80, -80, -80",
                     "Grid/Upper corner=160, 160, 160",
                     "Grid/Cells=120, 120, 120"},
                    30);
  }

  /** Bodies far apart have windows of their own, and may meet. */
  void
  check_far_apart()
  {
    const Flight<2> flight(ParameterFile::from_text(collision_text(3), "test"),
                           {"Grid/Lower corner=-100, -100",
                            "Grid/Upper corner=100, 100",
                            "Grid/Cells=400, 400",
                            "Bodies/left/ball/Center=-90, -90",
                            "Bodies/right/ball/Center=90, 90"},
                           2,
                           MPI_COMM_WORLD);
    const double    share = share_of_cells(flight.run.scene.grid);
    check(share < 0.01, "two distant bodies: most of the grid has no cells");
  }

  /**
   * Where the blocks of cells stick out of the grid, the wall is where it
   * was: a body that bounces off the upper side does what its mirror image
   * does at the lower side.
   */
  void
  check_ragged_side()
  {
    const Settings  common{"Grid/Upper corner=18.5, 10.5",
                          "Grid/Cells=37, 21",
                          "Boundary conditions/Roller=x-min, x-max",
                          "Bodies/right/ball/Center=9.25, 5",
                          "Bodies/right/Initial velocity=0; 0",
                          "Time/Step rule=fixed",
                          "Time/Step size=0.05"};
    const auto      file = ParameterFile::from_text(collision_text(3), "test");
    const Flight<2> lower(file,
                          common +
                            Settings{"Bodies/left/ball/Center=1.5, 5",
                                     "Bodies/left/Initial velocity=-3; 0"},
                          20,
                          MPI_COMM_WORLD),
      upper(file,
            common + Settings{"Bodies/left/ball/Center=17, 5",
                              "Bodies/left/Initial velocity=3; 0"},
            20,
            MPI_COMM_WORLD);
    for (const char *column : {"kinetic_energy", "strain_energy"})
      {
        const auto a = lower.run.column(column), b = upper.run.column(column);
        for (unsigned int row = 0; row < a.size(); ++row)
          check_close(a[row],
                      b[row],
                      1e-9 * lower.run.column("kinetic_energy")[0],
                      "ragged side: mirrored " + std::string(column));
      }
    check(largest(lower.run.column("strain_energy")) >
            0.1 * lower.run.column("kinetic_energy")[0],
          "ragged side: the body hits the wall");
  }

  /** The number of blocks stays bounded, and all that is asked for is there.
   */
  void
  check_blocks()
  {
    using Window = emmy::Window<3>;
    const std::vector<unsigned int> n_cells{1001, 999, 500};
    std::vector<Window::Place>      cells;
    for (unsigned int i = 0; i < 150; ++i)
      for (unsigned int j = 0; j < 150; ++j)
        for (unsigned int k = 0; k < 150; ++k)
          cells.push_back({{851 + i, 849 + j, 10 + k}});
    const Window window = Window::around(cells, n_cells, MPI_COMM_SELF);
    check(window.blocks().size() <= Window::most_blocks,
          "a large window has few blocks");
    check(window.blocks().size() << (3 * window.level()) < 3 * cells.size(),
          "a large window is not much larger than the body");
    check(std::all_of(cells.begin(),
                      cells.end(),
                      [&](const Window::Place &cell) {
                        return window.has_surroundings_of(cell);
                      }),
          "cells and what is around them are there");
    check(!window.has_surroundings_of({{500, 500, 250}}),
          "other cells are not there");

    // a layer of one cell in a grid of one cell in height
    std::vector<Window::Place> layer;
    for (unsigned int i = 0; i < 200; ++i)
      for (unsigned int j = 0; j < 200; ++j)
        layer.push_back({{i, j, 0}});
    const Window thin = Window::around(layer, {200, 200, 1}, MPI_COMM_SELF);
    check(thin.blocks().size() << (3 * thin.level()) <= 2 * layer.size(),
          "a thin grid has at most one cell above the layer");

    const Window nothing = Window::around({}, n_cells, MPI_COMM_SELF);
    check(nothing.blocks().size() == 1, "no cell asked for: one block");
    const Window all = Window::whole({12, 20, 8});
    check(all.level() == 2 && all.blocks().size() == 3 * 5 * 2,
          "the whole grid in the largest blocks that fit");
    const Window most =
      Window::around({{{4, 4, 4}}}, {11, 11, 11}, MPI_COMM_SELF);
    check(most.blocks().size() == 27 &&
            most.has_surroundings_of({{10, 10, 10}}),
          "more than half of the grid: all of it");
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_blocks();
  if (argc != 2)
    {
      std::cerr << "usage: test_window FILE.prm\n";
      return 2;
    }
  check_flights(ParameterFile(argv[1]));
  check_far_apart();
  check_ragged_side();
  return report();
}
