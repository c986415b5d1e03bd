// The table of phases: what it counts, what it costs, and how ranks that do
// not know the same phases are combined. Runs on any number of ranks.

#include <emmy/base/phases.h>

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "../check.h"

using namespace emmy;
using test::check;
using test::check_throws_with;

namespace
{
  const MPI_Comm world = MPI_COMM_WORLD;

  unsigned int
  rank()
  {
    return dealii::Utilities::MPI::this_mpi_process(world);
  }


  std::size_t
  count(const std::string &text, const std::string &part)
  {
    std::size_t n = 0;
    for (auto at = text.find(part); at != std::string::npos;
         at      = text.find(part, at + 1))
      ++n;
    return n;
  }


  void
  test_phases(const std::string &filename)
  {
    Phases phases(world);
    {
      const auto timed = phases.scope("first");
      phases.add_count("first", 10);
    }
    if (rank() == 0)
      const auto timed = phases.scope("only on rank 0");

    double least = 1.;
    for (unsigned int attempt = 0; attempt < 10; ++attempt)
      {
        constexpr unsigned int n     = 10000;
        const auto             start = std::chrono::steady_clock::now();
        for (unsigned int i = 0; i < n; ++i)
          const auto timed = phases.scope("a phase that costs nothing");
        least = std::min(least,
                         std::chrono::duration<double>(
                           std::chrono::steady_clock::now() - start)
                             .count() /
                           n);
      }
    check(least < 1e-6, "timing a phase costs less than a microsecond");

    const auto rows = phases.rows();
    check(rows.size() == 3 && rows[0].name == "first" &&
            rows[1].name == "only on rank 0" && rows[1].calls == 1. &&
            rows[2].calls == 100000.,
          "phases in the order of their first use");
    check(rows[0].points ==
            10. * dealii::Utilities::MPI::n_mpi_processes(world),
          "points are added over the ranks");

    std::ostringstream table;
    phases.print(table);
    check(count(table.str(), "total wall time") == (rank() == 0 ? 1 : 0) &&
            (rank() != 0 || count(table.str(), "\n") == 8),
          "the table is printed by rank 0");
    phases.write_json(filename);
    std::ifstream      in(filename);
    std::ostringstream json;
    json << in.rdbuf();
    check(count(json.str(), "\"name\": \"only on rank 0\"") == 1 &&
            count(json.str(), "\"calls\": 100000") == 1,
          "the phases are in the JSON file");
    check_throws_with([&] { phases.write_json(filename + "/t.json"); },
                      {filename + "/t.json", "check that its folder exists"});
  }
} // namespace


int
main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);

  const std::string filename =
    (std::filesystem::temp_directory_path() /
     ("emmy_phases_test_" +
      std::to_string(dealii::Utilities::MPI::broadcast(world, getpid(), 0)) +
      ".json"))
      .string();
  test_phases(filename);

  MPI_Barrier(world);
  if (rank() == 0)
    std::filesystem::remove(filename);
  return test::report();
}
