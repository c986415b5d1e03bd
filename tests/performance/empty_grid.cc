/**
 * What the empty part of the grid costs: the same body in a small grid and in
 * one about a hundred times larger, slow in its window or so fast that
 * the window must follow it. Prints medians over repetitions.
 *
 *   build/tests/test_empty_grid [repetitions]
 *
 * Each case is a process of its own, as memory is that of a process. Times are
 * seconds of the processor, without output.
 */
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>

#include <emmy/base/text.h>

#include "../scene.h"

namespace
{
  using namespace emmy;

  struct Case
  {
    const char  *name;
    unsigned int dim, body, small, large; ///< cells per direction
    double       velocity;                ///< of each component, m/s
    unsigned int n_steps;
  };

  constexpr std::array<Case, 4> cases{
    {{"40^2 cells, slow", 2, 40, 60, 600, 0.3, 40},
     {"40^2 cells, fast", 2, 40, 60, 600, 2., 80},
     {"16^3 cells, slow", 3, 16, 24, 112, 0.3, 12},
     {"16^3 cells, fast", 3, 16, 24, 112, 2., 24}}};

  struct Result
  {
    double step, start; ///< s
    double memory;      ///< the most so far, MB
    double n_moves;     ///< of the window
  };

  std::string
  text_of(const Case &scene, const unsigned int n_cells)
  {
    const auto all = [&](const double value, const char *separator) {
      std::string list = shortest(value);
      for (unsigned int d = 1; d < scene.dim; ++d)
        list += separator + shortest(value);
      return list;
    };
    // fast bodies need room to fly; on whole blocks of cells
    const unsigned int first =
      n_cells == scene.small ? 0 : 4 * ((n_cells - scene.body) / 8);
    return "set Dimension = " + std::to_string(scene.dim) +
           "\nsubsection Method\nset Shape functions = linear\n"
           "set Starved nodes = free\nend\n"
           "subsection Grid\nset Lower corner = " +
           all(0, ", ") + "\nset Upper corner = " + all(n_cells, ", ") +
           "\nset Cells = " + all(n_cells, ", ") +
           "\nend\nsubsection Materials\nset Names = rubber\n"
           "subsection rubber\nset Model = Hencky\nset Density = 5\n"
           "set Young's modulus = 100\nset Poisson's ratio = 0.3\nend\nend\n"
           "subsection Bodies\nset Names = block\nsubsection block\n"
           "set Shape = box\nset Material = rubber\n"
           "set Points per direction = 2\nset Initial velocity = " +
           all(scene.velocity, "; ") +
           "\nsubsection box\nset Lower corner = " + all(first, ", ") +
           "\nset Upper corner = " + all(first + scene.body, ", ") +
           "\nend\nend\nend\n"
           "subsection Time\nset End time = 1e9\n"
           "set Step rule = fixed\nset Step size = 0.1\nend\n";
  }

  /** VmHWM, MB; 0 where the system does not tell. */
  double
  peak_memory()
  {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
      if (line.compare(0, 6, "VmHWM:") == 0)
        return std::atof(line.c_str() + 6) / 1024.;
    return 0.;
  }

  double
  processor_seconds()
  {
    return double(std::clock()) / CLOCKS_PER_SEC;
  }

  /** One case in this process; prints a Result. */
  template <int dim>
  void
  run_here(const Case &scene, const unsigned int n_cells)
  {
    const SceneParameters<dim> parameters(
      ParameterFile::from_text(text_of(scene, n_cells), "benchmark"));
    const double            begin = processor_seconds();
    test::RunningScene<dim> run(parameters);
    const double            start   = processor_seconds() - begin;
    unsigned int            n_moves = 0;
    double                  steps   = 0.;
    for (unsigned int i = 0; i < scene.n_steps; ++i)
      {
        const auto   blocks = run.scene.grid.window().blocks();
        const double before = processor_seconds();
        run.advance(1);
        steps += processor_seconds() - before;
        n_moves += run.scene.grid.window().blocks() != blocks;
      }
    std::printf("%.17g %.17g %.17g %u\n",
                steps / scene.n_steps,
                start,
                peak_memory(),
                n_moves);
  }

  Result
  run_apart(const std::string &program,
            const unsigned int number,
            const unsigned int n_cells)
  {
    const std::string command = program + " --case " + std::to_string(number) +
                                " " + std::to_string(n_cells);
    std::FILE *pipe = popen(command.c_str(), "r");
    Result     result{};
    const int  n_read = std::fscanf(pipe,
                                   "%lf %lf %lf %lf",
                                   &result.step,
                                   &result.start,
                                   &result.memory,
                                   &result.n_moves);
    if (pclose(pipe) != 0 || n_read != 4)
      {
        std::fprintf(stderr, "failed: %s\n", command.c_str());
        std::exit(1);
      }
    return result;
  }

  double
  median(const std::vector<Result> &results, double Result::*value)
  {
    std::vector<double> values;
    for (const Result &result : results)
      values.push_back(result.*value);
    std::sort(values.begin(), values.end());
    return 0.5 * (values[values.size() / 2] + values[(values.size() - 1) / 2]);
  }
} // namespace

int
main(int argc, char *argv[])
{
  if (argc == 4 && std::string(argv[1]) == "--case")
    {
      dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
      const Case        &scene   = cases.at(std::atoi(argv[2]));
      const unsigned int n_cells = std::atoi(argv[3]);
      if (scene.dim == 2)
        run_here<2>(scene, n_cells);
      else
        run_here<3>(scene, n_cells);
      return 0;
    }

  const int n_repetitions = argc > 1 ? std::max(1, std::atoi(argv[1])) : 5;
  std::printf("medians of %d repetitions\n\n"
              "| body | grid | moves | s/step | ratio | start, s | MB | ratio "
              "|\n|---|---|---|---|---|---|---|---|\n",
              n_repetitions);
  for (unsigned int number = 0; number < cases.size(); ++number)
    {
      const Case                        &scene = cases[number];
      const std::array<unsigned int, 2>  n_cells{{scene.small, scene.large}};
      std::array<std::vector<Result>, 2> results;
      // in turn, so that both meet the same disturbances
      for (int i = 0; i < n_repetitions; ++i)
        for (unsigned int grid = 0; grid < 2; ++grid)
          results[grid].push_back(run_apart(argv[0], number, n_cells[grid]));
      for (unsigned int grid = 0; grid < 2; ++grid)
        {
          const auto ratio = [&](double Result::*value) {
            return median(results[grid], value) / median(results[0], value);
          };
          std::printf("| %s | %u^%u | %.0f | %.4f | %.2f | %.2f | %.0f | %.2f "
                      "|\n",
                      scene.name,
                      n_cells[grid],
                      scene.dim,
                      median(results[grid], &Result::n_moves),
                      median(results[grid], &Result::step),
                      ratio(&Result::step),
                      median(results[grid], &Result::start),
                      median(results[grid], &Result::memory),
                      ratio(&Result::memory));
        }
    }
  return 0;
}
