// Ranks hand cells and particles to each other: when the load is uneven and it
// pays, and not when nothing would come of it.
//
// Run on 2 and 3 ranks.

#include "../check.h"
#include "../scene.h"

#include <emmy/transfer/particle_sort.h>
#include <emmy/transfer/rank_load.h>

using namespace emmy;

namespace
{
  using test::at_most;
  using test::check;

  /**
   * A disc that flies to the right and hits a smaller one.
   */
  std::string
  flight(const std::string &rebalance_above, const std::string &time = "")
  {
    return "set Dimension = 2\n"
           "subsection Grid\n"
           "set Lower corner = 0, 0\nset Upper corner = 16, 4\n"
           "set Cells = 128, 32\nend\n"
           "subsection Materials\nset Names = rubber\n"
           "subsection rubber\n"
           "set Model = Hencky\nset Density = 5\n"
           "set Young's modulus = 100\nset Poisson's ratio = 0.3\n"
           "end\nend\n"
           "subsection Bodies\nset Names = left, right\n"
           "subsection left\n"
           "set Shape = ball\nset Material = rubber\n"
           "set Points per direction = 2\nset Initial velocity = 3; 0\n"
           "subsection ball\nset Center = 2, 2\nset Radius = 1.2\nend\nend\n"
           "subsection right\n"
           "set Shape = ball\nset Material = rubber\n"
           "set Points per direction = 2\nset Initial velocity = 0; 0\n"
           "subsection ball\nset Center = 8, 2.2\nset Radius = 0.7\n"
           "end\nend\nend\n"
           "subsection Method\nset Shape functions = linear\n"
           "set Starved nodes = follow\nset Geometry = start\nend\n"
           "subsection Time\nset End time = 4\nset Step rule = fixed\n"
           "set Step size = 0.02\n" +
           time +
           "end\nsubsection Ranks\nset Rebalance above = " + rebalance_above +
           "\nend\n";
  }

  struct Flight
  {
    unsigned int n_times = 0;
    RankLoad     largest;
    /** Steps after which there was more than the bound. */
    unsigned int n_uneven = 0;
  };

  Flight
  fly(const std::string &text, const unsigned int n_steps)
  {
    const SceneParameters<2> parameters(ParameterFile::from_text(text, "fly"));
    test::RunningScene<2>    run(parameters);
    Flight                   result;
    for (unsigned int step = 0; step < n_steps; ++step)
      {
        run.advance(1);
        const RankLoad load =
          load_of_ranks(run.scene.grid, run.scene.particles);
        result.largest.work = std::max(result.largest.work, load.work);
        result.largest.particles =
          std::max(result.largest.particles, load.particles);
        result.n_uneven += load.particles > 1.2;
      }
    result.n_times = run.scene.rank_balance.n_times();
    std::cout << "handed over " << result.n_times << " times, largest load "
              << result.largest.work << " of work, " << result.largest.particles
              << " of particles, above 1.2 after " << result.n_uneven
              << " steps\n";
    return result;
  }

  /** Material moves from one rank's cells to another's. */
  void
  test_collision()
  {
    const Flight never = fly(flight("1e9"), 90);
    check(never.n_times == 0,
          "a bound that is never passed hands nothing over");
    check(never.n_uneven > 20, "the scene does get uneven");
    const Flight balanced = fly(flight("1.08"), 90);
    check(balanced.n_times > 0, "cells are handed over");
    check(balanced.n_times < 45, "but not in most steps");
    at_most("particles of the busiest rank over the mean",
            balanced.largest.particles,
            1.2);
  }

  /** What cannot be cured is not tried again and again. */
  void
  test_steady()
  {
    const unsigned int n_ranks =
      dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD);
    // one cell holds all: whatever is handed over, one rank has it
    std::string text    = flight("1.2");
    const auto  replace = [&](const std::string &what, const std::string &by) {
      text.replace(text.find(what), what.size(), by);
    };
    replace("set Cells = 128, 32", "set Cells = 4, 1");
    replace("set Initial velocity = 3; 0", "set Initial velocity = 0.1; 0");
    replace("set Center = 2, 2\nset Radius = 1.2",
            "set Center = 1.1, 2\nset Radius = 1.05");
    replace("set Center = 8, 2.2\nset Radius = 0.7",
            "set Center = 3, 2\nset Radius = 1.05");
    const Flight steady = fly(text, 8);
    check(steady.largest.particles > n_ranks - 1e-10, "one rank has it all");
    check(steady.n_times == 0, "nothing is handed over");
  }

  /** Shortly before the end it does not pay. */
  void
  test_end()
  {
    const Flight flown  = fly(flight("1.08", "set Maximum steps = 12\n"), 12);
    const Flight longer = fly(flight("1.08"), 12);
    check(longer.n_times > 0, "with steps to come cells are handed over");
    check(flown.n_times < longer.n_times, "without, it does not pay");
  }

  /** All particles are there afterwards, in their order, with their fields. */
  void
  test_nothing_lost()
  {
    // so few cells that the window is all of the grid, and stays
    std::string       text = flight("1.2");
    const std::string fine = "set Cells = 128, 32";
    text.replace(text.find(fine), fine.size(), "set Cells = 64, 16");
    const SceneParameters<2> parameters(ParameterFile::from_text(text, "fly"));
    Scene<2>                 scene(parameters, MPI_COMM_WORLD);
    using List     = std::vector<std::vector<double>>;
    const auto all = [&] {
      List list;
      for (const auto &particle : scene.particles)
        {
          const auto fields = particle.get_properties();
          list.emplace_back(1, particle.get_id());
          list.back().push_back(particle.get_location()[0]);
          list.back().push_back(particle.get_location()[1]);
          list.back().insert(list.back().end(), fields.begin(), fields.end());
        }
      List result;
      for (const List &part :
           dealii::Utilities::MPI::all_gather(MPI_COMM_WORLD, list))
        result.insert(result.end(), part.begin(), part.end());
      return result;
    };
    List before = all();
    distribute_anew(scene.grid, scene.particles);
    check(all() == before, "the same particles in the same order");
    // all to the right, far beyond the cells of their ranks
    for (auto &particle : scene.particles)
      particle.set_location(particle.get_location() + dealii::Point<2>(6., 0.));
    for (auto &particle : before)
      particle[1] += 6.;
    sort_into_cells(scene.grid, scene.particles);
    const double uneven = load_of_ranks(scene.grid, scene.particles).work;
    distribute_anew(scene.grid, scene.particles);
    const double even = load_of_ranks(scene.grid, scene.particles).work;
    std::cout << "load " << uneven << " to " << even << '\n';
    check(uneven > 1.2 && even < 1.1, "the load becomes even");
    check(even == load_when_covered(scene.grid).work,
          "the load is that of the cells that were covered");
    List after = all();
    std::sort(before.begin(), before.end());
    std::sort(after.begin(), after.end());
    check(after == before, "the same particles");
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  test_nothing_lost();
  test_collision();
  test_steady();
  test_end();
  return test::report();
}
