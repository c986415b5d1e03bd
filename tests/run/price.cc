// What a run says of its price: timing.json is JSON, its numbers add up, and
// agree with run.log and with the ledger. Runs on any number of ranks.

#include <emmy/run/run.h>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <map>

#include "../scene.h"

using namespace emmy;
using test::check;
using test::check_close;
using Json = nlohmann::json;

namespace
{
  const MPI_Comm world = MPI_COMM_WORLD;

  bool
  is_first()
  {
    return dealii::Utilities::MPI::this_mpi_process(world) == 0;
  }


  Json
  read_json(const std::string &filename)
  {
    std::ifstream file(filename);
    return Json::parse(file);
  }


  /** Throws if it is anything but a number, in quotes for example. */
  double
  number(const Json &object, const char *key)
  {
    AssertThrow(object.at(key).is_number(),
                dealii::ExcMessage(object.dump() + ": " + key));
    return object.at(key).get<double>();
  }


  /** Two materials, an effect of each kind, losses, and steps to halve. */
  std::string
  scene_text(const std::string &folder)
  {
    return test::collision_text(3, "GIMP") +
           "subsection Time\nset Maximum steps = 12\nend\n"
           "subsection Effects\n"
           "set Names = gravity, point load, ghost stabilisation\n"
           "subsection Point load\nset Force = 0.1; 0\n"
           "set Points nearest to = 4, 2.3\nend\n"
           "subsection Gravity\nset Acceleration = 0, -0.1\nend\nend\n"
           "subsection Method\nset Mapping = blend\nset FLIP fraction = 0.9\n"
           "set Stress rule = end-point\nend\n"
           "subsection Solver\nset Maximum iterations = 2\nend\n"
           "subsection Output\nset Frames = 1\nset Pictures = false\n"
           "set Directory = " +
           folder + "\nend\n";
  }


  /** A disc at a wall that needs a second map, with a Krylov solver. */
  ParameterFile
  wall_scene(const std::string &folder)
  {
    ParameterFile file = ParameterFile::from_text(
      dealii::Utilities::replace_in_string(test::collision_text(3),
                                           "rubber",
                                           "r\xfc"
                                           "bber"), // Latin-1
      "price");
    for (const std::string setting : {"Bodies/left/ball/Center=0.8, 1.8",
                                      "Boundary conditions/Fixed=x-min",
                                      "Method/Wall mapping=inelastic",
                                      "Effects/Names=ghost stabilisation",
                                      "Solver/Linear solver=GMRES",
                                      "Time/Maximum steps=3",
                                      "Output/Frames=0",
                                      "Output/Pictures=false"})
      file.set(setting);
    file.set("Output/Directory=" + folder);
    return file;
  }


  std::vector<std::string>
  lines_of(const std::string &filename)
  {
    std::ifstream            file(filename);
    std::vector<std::string> lines;
    for (std::string line; std::getline(file, line);)
      lines.push_back(line);
    return lines;
  }


  /** The last row of a ledger by column, and the sums of all rows. */
  std::pair<std::map<std::string, double>, std::map<std::string, double>>
  read_ledger(const std::string &filename)
  {
    const auto lines = lines_of(filename);
    const auto names = dealii::Utilities::split_string_list(lines.at(0), ',');
    std::map<std::string, double> last, sums;
    for (std::size_t row = 1; row < lines.size(); ++row)
      {
        const auto values =
          dealii::Utilities::split_string_list(lines[row], ',');
        for (std::size_t c = 0; c < names.size(); ++c)
          sums[names[c]] += last[names[c]] = std::stod(values.at(c));
      }
    return {last, sums};
  }


  /** Times of phases and effects by name, as run.log prints them. */
  std::map<std::string, double>
  read_log(const std::string &filename, const std::vector<std::string> &names)
  {
    std::map<std::string, double> seconds;
    for (const std::string &line : lines_of(filename))
      for (const std::string &name : names)
        {
          const std::size_t begin = line.find_first_not_of(' ');
          if (begin == std::string::npos || begin > 2 ||
              line.compare(begin, name.size() + 1, name + " ") != 0 ||
              line.find(" %") == std::string::npos)
            continue;
          std::istringstream numbers(line.substr(begin + name.size()));
          double             calls;
          numbers >> calls >> seconds[name];
        }
    return seconds;
  }


  void
  check_results(const std::string &folder)
  {
    const Json tree         = read_json(folder + "/timing.json");
    const auto [last, sums] = read_ledger(folder + "/ledger.csv");
    const double total      = number(tree, "total_seconds");

    // counts
    check(tree.at("version") == EMMY_VERSION, "version");
    check(number(tree, "ranks") ==
            dealii::Utilities::MPI::n_mpi_processes(world),
          "ranks");
    check(number(tree, "steps") == last.at("step") && last.at("step") == 12.,
          "steps");
    for (const char *column : {"newton_iterations", "linear_iterations"})
      check(number(tree, column) == sums.at(column),
            std::string(column) + " of all steps");
    std::size_t n_halved = 0;
    for (const std::string &line : lines_of(folder + "/run.log"))
      n_halved += line.find("; halved to ") != std::string::npos;
    check(number(tree, "halvings") == n_halved && n_halved > 0, "halvings");
    check(number(tree, "peak_memory_bytes") >=
              number(tree, "peak_memory_bytes_of_a_rank") &&
            number(tree, "peak_memory_bytes_of_a_rank") > 1e6,
          "memory");

    // seconds
    std::vector<std::string>      names;
    std::map<std::string, double> seconds, within;
    double                        sum = number(tree, "seconds_outside_phases");
    for (const Json &phase : tree.at("phases"))
      {
        names.push_back(phase.at("name"));
        seconds[names.back()] = number(phase, "seconds");
        sum += number(phase, "mean_seconds");
        check(number(phase, "mean_seconds") <=
                seconds[names.back()] * (1. + 1e-12),
              "no rank is slower than the slowest");
      }
    check_close(sum, total, 1e-9 * total, "phases add up to the wall time");
    double of_effects = 0., points_of_materials = 0.;
    for (const Json &effect : tree.at("effects"))
      {
        names.push_back(effect.at("name"));
        seconds[names.back()] = number(effect, "seconds");
        if (names.back().find("material ") == 0)
          points_of_materials += number(effect, "points");
        if (effect.contains("within"))
          within[effect.at("within")] += number(effect, "mean_seconds");
        else
          of_effects += number(effect, "mean_seconds");
      }
    check(of_effects > 0. && of_effects < total,
          "effects are less than the whole");
    for (const Json &effect : tree.at("effects"))
      if (effect.at("name") == "internal force")
        check(number(effect, "points") == points_of_materials,
              "each point belongs to a material");
    check(within.size() == 1 &&
            within["internal force"] <= seconds["internal force"],
          "materials and stress rule are parts of the internal force");
    for (const char *name : {"inertia",
                             "internal force",
                             "material rubber",
                             "material cork",
                             "stress rule",
                             "GIMP",
                             "domain update",
                             "gravity",
                             "point load",
                             "ghost stabilisation",
                             "PIC"})
      check(seconds.count(name) == 1 && seconds[name] > 0.,
            std::string("time of ") + name);
    check(seconds["GIMP"] == seconds["stencils"],
          "the phase of the stencils is that of the shape functions");

    // run.log has the same, to its digits
    const auto logged = read_log(folder + "/run.log", names);
    for (const auto &[name, value] : seconds)
      {
        check(logged.count(name) == 1, name + " is in run.log");
        check_close(logged.count(name) ? logged.at(name) : -1.,
                    value,
                    0.00051,
                    "seconds of " + name + " in run.log");
      }

    // every joule of the ledger has an effect, once
    std::map<std::string, double> energies;
    for (const Json &effect : tree.at("effects"))
      for (const auto &[column, value] : effect.at("energies").items())
        {
          check(energies.count(column) == 0, column + " has one owner");
          energies[column] = value.get<double>();
          check(energies[column] == last.at(column),
                column + " as in the ledger");
        }
    const std::vector<std::string> losses{"strain_energy",
                                          "stress_rule_loss",
                                          "load_work",
                                          "mapping_loss",
                                          "ghost_mass_loss",
                                          "ghost_stiffness_loss"};
    check(energies.size() == losses.size(), "all energies are told");
    for (const std::string &name : losses)
      {
        check(energies.count(name) == 1, name + " is told");
        std::size_t n = 0;
        for (const std::string &line : lines_of(folder + "/run.log"))
          n += line.compare(0, name.size() + 5, "    " + name + " ") == 0 &&
               line.find(" J") != std::string::npos;
        check(n == 1, name + " has its line in run.log");
      }
    check(number(tree, "balance_error") == last.at("balance_error") &&
            number(tree, "residual_work") == last.at("residual_work"),
          "what has no effect");
  }


  /** The second map of inelastic walls has its iterations, and no other. */
  void
  check_iterations(const std::string &folder)
  {
    const Json tree   = read_json(folder + "/timing.json");
    double     of_map = 0.;
    for (const Json &phase : tree.at("phases"))
      if (phase.at("name") == "velocity from momentum")
        of_map = number(phase, "linear_iterations");
    double      of_walls = 0.;
    std::string others;
    for (const Json &effect : tree.at("effects"))
      if (effect.at("name") == "inelastic walls")
        of_walls = number(effect, "linear_iterations");
      else if (effect.contains("linear_iterations"))
        others += effect.at("name");
    std::cout << "iterations of the map " << of_map << ", of inelastic walls "
              << of_walls << '\n';
    check(of_walls > 0. && of_walls < of_map,
          "a part of the map's iterations is that of inelastic walls");
    check(others.empty(), "no other effect has iterations: " + others);
    unsigned int      n_headings = 0, n_lines = 0;
    const std::string number = ' ' + shortest(of_walls);
    for (const std::string &line : lines_of(folder + "/run.log"))
      {
        n_headings += line.compare(0, 7, "effect ") == 0 &&
                      line.find("  iterations") != std::string::npos;
        n_lines += line.compare(0, 16, "inelastic walls ") == 0 &&
                   line.size() > number.size() &&
                   line.substr(line.size() - number.size()) == number;
      }
    check(n_headings == 1 && n_lines == 1, "run.log has the iterations");

    bool is_named = false;
    for (const Json &effect : tree.at("effects"))
      is_named |= effect.at("name") == "material r\xef\xbf\xbd"
                                       "bber";
    check(is_named, "a name that is not UTF-8 is written as U+FFFD");
  }
} // namespace


int
main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::string                        folder =
    (std::filesystem::temp_directory_path() /
     ("emmy_price_test_" +
      std::to_string(dealii::Utilities::MPI::broadcast(world, getpid(), 0))))
      .string();
  run<2>(ParameterFile::from_text(scene_text(folder), "price"),
         RunOptions(),
         world);
  run<2>(wall_scene(folder + "/wall"), RunOptions(), world);
  MPI_Barrier(world);
  if (is_first())
    {
      check_results(folder);
      check_iterations(folder + "/wall");
      std::filesystem::remove_all(folder);
      return test::report();
    }
  return 0;
}
