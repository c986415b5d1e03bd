/**
 * What a step costs, and what share of the machine's speed that is: runs the
 * scenes of prm/benchmarks and prints a table. `./run benchmark` builds and
 * calls it:
 *
 *   benchmark EMMY SOURCE_TREE [short] [--json FILE] [--against FILE|EMMY]
 *
 * Each row is the median of some runs, each a process of its own. --against
 * compares with the file of an earlier run, or runs another program in turn
 * with this one; the ratios are of the cost per particle and iteration.
 * doc/performance.md says how work is counted.
 */
#include <nlohmann/json.hpp>

#include "core_speed.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace
{
  using nlohmann::json;

  struct Case
  {
    std::string  name, scene, cells, shape_functions, geometry;
    double       factor; ///< of the step, in cells that a wave travels
    unsigned int steps;
    bool         is_short;
  };

  std::vector<Case>
  all_cases()
  {
    std::vector<Case> cases;
    const std::string cells_3d[]{"20, 15, 15",
                                 "32, 24, 24",
                                 "52, 39, 39",
                                 "96, 72, 72"},
      cells_2d[]{"72, 54", "144, 108", "288, 216"},
      cells_bar[]{"12, 57, 12", "16, 76, 16", "24, 114, 24"};
    const auto add = [&](const char        *name,
                         const char        *scene,
                         const std::string &cells,
                         const char        *functions,
                         const char        *geometry,
                         const double       factor,
                         const bool         is_short) {
      const unsigned int steps = cells == "96, 72, 72" ? 2 : 5;
      cases.push_back(
        {name, scene, cells, functions, geometry, factor, steps, is_short});
    };
    for (const double factor : {1., 15., 150.})
      for (const std::string &cells : cells_3d)
        add("beam, space",
            "cantilever-3d",
            cells,
            "linear",
            "start",
            factor,
            cells == cells_3d[1] && factor > 1.);
    for (const std::string &cells : {cells_3d[0], cells_3d[1], cells_3d[2]})
      for (const char *const geometry : {"start", "middle"})
        add("beam, space",
            "cantilever-3d",
            cells,
            "GIMP",
            geometry,
            15.,
            cells == cells_3d[0]);
    for (const std::string &cells : cells_2d)
      for (const char *const functions : {"linear", "GIMP"})
        add("beam, plane",
            "cantilever-2d",
            cells,
            functions,
            functions[0] == 'G' ? "middle" : "start",
            15.,
            cells == cells_2d[0]);
    for (const std::string &cells : cells_bar)
      add("bar of copper",
          "taylor-bar",
          cells,
          "linear",
          "start",
          2.,
          cells == cells_bar[0]);
    return cases;
  }

  struct Options
  {
    std::string program, tree, other, json_file;
    json        earlier;
    bool        is_short = false;
  };

  [[noreturn]] void
  fail(const std::string &what)
  {
    std::cerr << "benchmark: error: " << what << '\n';
    std::exit(1);
  }

  json
  read_json(const std::string &file)
  {
    std::ifstream in(file);
    json          result = json::parse(in, nullptr, /*exceptions=*/false);
    if (result.is_discarded())
      fail("<" + file + "> is no file of an earlier benchmark");
    return result;
  }

  /** One run of a case: timing.json, and the number of particles. */
  json
  run(const std::string &program, const Options &options, const Case &scene)
  {
    char folder[] = "/tmp/emmy-benchmark-XXXXXX";
    if (!mkdtemp(folder))
      fail("no folder can be made in /tmp");
    const std::string out = folder;
    const auto        set = [](const std::string &name, const auto &value) {
      std::string text = " --set '" + name + "=";
      return text + value + "'";
    };
    const std::string command =
      "'" + program + "' '" + options.tree + "/prm/benchmarks/" + scene.scene +
      ".prm'" + set("Output/Directory", out + "/run") +
      set("Grid/Cells", scene.cells) +
      set("Method/Shape functions", scene.shape_functions) +
      set("Method/Geometry", scene.geometry) +
      set("Time/Factor", std::to_string(scene.factor)) +
      set("Time/Maximum steps", std::to_string(scene.steps)) + " >'" + out +
      "/screen' 2>&1";
    if (std::system(command.c_str()) != 0)
      fail("failed: " + command + "\n  its messages are in " + out + "/screen");
    json          result = read_json(out + "/run/timing.json");
    std::ifstream ledger(out + "/run/ledger.csv");
    const auto    words_of_line = [&ledger] {
      std::string line, word;
      std::getline(ledger, line);
      std::istringstream       words(line);
      std::vector<std::string> result;
      while (std::getline(words, word, ','))
        result.push_back(word);
      return result;
    };
    const std::vector<std::string> names = words_of_line();
    const std::vector<std::string> row   = words_of_line();
    const std::size_t              column =
      std::find(names.begin(), names.end(), "particles") - names.begin();
    if (column >= row.size())
      fail("the ledger of <" + command + "> has no particles");
    result["particles"] = std::stod(row[column]);
    result["dimension"] = scene.scene.find("2d") == std::string::npos ? 3 : 2;
    // the card of the scene has: ... numbers each, ... bytes
    const std::string mark = " numbers each, ";
    std::ifstream     screen(out + "/screen");
    for (std::string line; std::getline(screen, line);)
      if (const auto at = line.find(mark); at != std::string::npos)
        result["bytes_per_particle"] = std::stod(line.substr(at + mark.size()));
    if (!result.contains("bytes_per_particle"))
      fail("the card of <" + command + "> has no bytes of a particle");
    std::filesystem::remove_all(out);
    return result;
  }

  /** Seconds of a phase; 0 if a run has not had it. */
  double
  seconds(const json &timing, const std::string &phase)
  {
    for (const json &row : timing["phases"])
      if (row["name"] == phase)
        return row["seconds"];
    return 0.;
  }

  double
  points(const json &timing, const std::string &phase)
  {
    for (const json &row : timing["phases"])
      if (row["name"] == phase)
        return row.value("points", 0.);
    return 0.;
  }

  /** What a table has of a run; times in microseconds per particle and Newton
   * iteration. */
  std::map<std::string, double>
  figures(const json &timing)
  {
    double whole = timing["total_seconds"];
    for (const char *const phase :
         {"setup", "scene card", "output", "pictures"})
      whole -= seconds(timing, phase);
    const double iterations = timing["newton_iterations"],
                 steps = timing["steps"], particles = timing["particles"],
                 unit = 1e6 / (particles * std::max(1., iterations));
    std::map<std::string, double> result;
    result["particles"] = particles;
    result["s/step"]    = whole / steps;
    result["Newton"]    = iterations / steps;
    result["Krylov"]    = double(timing["linear_iterations"]) / iterations;
    result["us"]        = whole * unit;
    result["tangent"]   = seconds(timing, "residual and tangent") * unit;
    result["solve"]     = seconds(timing, "linear solve") * unit;
    result["map"]       = (seconds(timing, "particles to grid") +
                     seconds(timing, "velocity from momentum")) *
                    unit;
    result["rest"] =
      result["us"] - result["tangent"] - result["solve"] - result["map"];
    result["us/evaluation"] = 1e6 * seconds(timing, "residual and tangent") /
                              points(timing, "residual and tangent");
    result["bytes"] = double(timing["peak_memory_bytes"]);
    // work that formulas count: doc/performance.md, How is work counted?
    const double dim = timing["dimension"], n = std::pow(2., dim),
                 evaluations = points(timing, "residual and tangent"),
                 of_forces   = 4. * dim * dim * n,
                 of_matrix =
                   2. * std::pow(dim, 5) * n + 2. * std::pow(dim, 3) * n * n;
    result["gflops"] =
      1e-9 * (evaluations * of_forces + particles * iterations * of_matrix) /
      seconds(timing, "residual and tangent");
    const double of_weights = 8. * (1. + dim) * n,
                 of_fields  = timing["bytes_per_particle"];
    double transfer         = 0.;
    for (const char *const phase :
         {"stencils", "gather", "particles to grid", "grid to particles"})
      transfer += seconds(timing, phase);
    result["gbytes"] =
      1e-9 * particles * steps * (3. * of_weights + 4. * of_fields) / transfer;
    return result;
  }

  double
  median(std::vector<double> values)
  {
    std::sort(values.begin(), values.end());
    return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
  }

  std::map<std::string, double>
  medians(const std::vector<std::map<std::string, double>> &runs)
  {
    std::map<std::string, double> result;
    for (const auto &[name, value] : runs.front())
      {
        (void)value;
        std::vector<double> values;
        for (const auto &run : runs)
          values.push_back(run.at(name));
        result[name] = median(values);
      }
    return result;
  }

  Options
  read_options(const int argc, char *argv[])
  {
    Options options;
    if (argc < 3)
      fail("usage: benchmark EMMY SOURCE_TREE [short] [--json FILE] "
           "[--against FILE|EMMY]");
    options.program = argv[1];
    options.tree    = argv[2];
    for (int i = 3; i < argc; ++i)
      {
        const std::string word = argv[i];
        if (word == "short")
          options.is_short = true;
        else if (word == "--json" && i + 1 < argc)
          options.json_file = argv[++i];
        else if (word == "--against" && i + 1 < argc)
          {
            const std::string what = argv[++i];
            if (what.size() > 5 && what.substr(what.size() - 5) == ".json")
              options.earlier = read_json(what);
            else
              options.other = what;
          }
        else
          fail("<" + word +
               "> is not known. Known: short, --json FILE, "
               "--against FILE.json, --against EMMY");
      }
    return options;
  }

  std::string
  key_of(const Case &scene)
  {
    return scene.name + ", " + scene.cells + ", " + scene.shape_functions +
           ", " + scene.geometry + ", " + std::to_string(int(scene.factor));
  }
} // namespace

int
main(int argc, char *argv[])
{
  const Options      options   = read_options(argc, argv);
  const unsigned int n_repeats = options.is_short ? 3 : 5;
  const double       peak      = core_speed::peak_gflops(),
               bandwidth       = core_speed::triad_bandwidth();
  std::printf("One core: %.1f 1e9 flops/s (multiply and add), %.1f 1e9 bytes/s "
              "(triad).\n"
              "Times in 1e-6 s per particle and Newton iteration, without "
              "setup, output and pictures; medians of %u runs.\n\n",
              peak,
              bandwidth,
              n_repeats);
  std::printf(
    "| scene | cells | functions, geometry | h/c | particles | "
    "Newton | Krylov | s/step | all | tangent | solve | map | rest "
    "| kB | %% peak | %% triad |%s\n|---|---|---|---|---|---|---|---|---|---"
    "|---|---|---|---|---|---|%s\n",
    options.other.empty() && options.earlier.is_null() ? "" : " ratio |",
    options.other.empty() && options.earlier.is_null() ? "" : "---|");
  json written{{"peak_gflops", peak}, {"triad_gbytes", bandwidth}};

  // what a program takes that has next to no particles
  const Case empty{
    "", "cantilever-2d", "8, 6", "linear", "start", 15., 1, true};
  const double empty_bytes =
    run(options.program, options, empty)["peak_memory_bytes"];
  for (const Case &scene : all_cases())
    {
      if (options.is_short && !scene.is_short)
        continue;
      std::vector<std::map<std::string, double>> runs, others;
      for (unsigned int i = 0; i < n_repeats; ++i)
        {
          runs.push_back(figures(run(options.program, options, scene)));
          if (!options.other.empty())
            others.push_back(figures(run(options.other, options, scene)));
        }
      auto median_of = medians(runs);
      median_of["bytes"] =
        (median_of["bytes"] - empty_bytes) / median_of["particles"];
      written["cases"][key_of(scene)] = median_of;
      std::printf("| %s | %s | %s, %s | %g | %.0f | %.1f | %.1f | %.3f | %.2f "
                  "| %.2f | %.2f | %.2f | %.2f | %.1f |",
                  scene.name.c_str(),
                  scene.cells.c_str(),
                  scene.shape_functions.c_str(),
                  scene.geometry.c_str(),
                  scene.factor,
                  median_of["particles"],
                  median_of["Newton"],
                  median_of["Krylov"],
                  median_of["s/step"],
                  median_of["us"],
                  median_of["tangent"],
                  median_of["solve"],
                  median_of["map"],
                  median_of["rest"],
                  1e-3 * median_of["bytes"]);
      // formulas know the nodes of a point with linear functions only
      if (scene.shape_functions == "linear")
        std::printf(" %.1f | %.1f |",
                    100. * median_of["gflops"] / peak,
                    100. * median_of["gbytes"] / bandwidth);
      else
        std::printf("  |  |");
      if (!others.empty())
        {
          std::vector<double> ratios;
          for (unsigned int i = 0; i < n_repeats; ++i)
            ratios.push_back(runs[i]["us"] / others[i]["us"]);
          written["cases"][key_of(scene)]["ratio"] = median(ratios);
          std::printf(" %.2f |", median(ratios));
        }
      else if (!options.earlier.is_null())
        {
          const json &cases = options.earlier["cases"];
          if (cases.contains(key_of(scene)))
            std::printf(" %.2f |",
                        median_of["us"] / double(cases[key_of(scene)]["us"]));
          else
            std::printf(" |");
        }
      std::printf("\n");
      std::fflush(stdout);
    }
  if (!options.json_file.empty())
    {
      std::ofstream out(options.json_file);
      out << written.dump(2) << '\n';
      if (!out.flush())
        fail("<" + options.json_file +
             "> cannot be written: check the folder and the disk's space");
    }
}
