// What a run says of its price: timing.json is JSON, its numbers add up, and
// agree with run.log and with the ledger. Runs on any number of ranks.

#include <emmy/base/json.h>
#include <emmy/run/run.h>

#include <boost/property_tree/json_parser.hpp>

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <map>

#include "../scene.h"

using namespace emmy;
using test::check;
using test::check_close;
using Tree = boost::property_tree::ptree;

namespace
{
  const MPI_Comm world = MPI_COMM_WORLD;

  bool
  is_first()
  {
    return dealii::Utilities::MPI::this_mpi_process(world) == 0;
  }


  void
  test_json()
  {
    JsonObject inner, json;
    inner.add("quote", std::string("a \"b\" \\ c\n\x01"));
    json.add("number", 0.1 + 0.2);
    json.add("no number", std::numeric_limits<double>::quiet_NaN());
    json.add("empty list", std::vector<JsonObject>());
    json.add("list", {inner, JsonObject()});
    json.add("object", inner);
    std::istringstream text(json.text());
    Tree               tree;
    boost::property_tree::read_json(text, tree);
    check(tree.get<double>("number") == 0.1 + 0.2, "numbers keep all digits");
    check(tree.get<std::string>("no number") == "null", "NaN is null");
    check(tree.get_child("list").size() == 2 &&
            tree.get_child("empty list").empty(),
          "lists have their length");
    check(tree.get<std::string>("object.quote") == "a \"b\" \\ c\n\x01",
          "what text needs is escaped");

    const auto written = [](const std::string &bytes) {
      JsonObject object;
      object.add("a", bytes);
      return object.line();
    };
    check(written("M\xc3\xbcller \xe2\x82\xac \xf0\x9f\x8e\xb2") ==
            "{\"a\": \"M\xc3\xbcller \xe2\x82\xac \xf0\x9f\x8e\xb2\"}",
          "UTF-8 stays as it is");
    check(written("M\xfcller") == "{\"a\": \"M\\u00fcller\"}",
          "Latin-1 becomes what it means");
    // cut off, too long, a surrogate, beyond Unicode, alone
    check(written("\xc3") == "{\"a\": \"\\u00c3\"}" &&
            written("\xc0\xaf") == "{\"a\": \"\\u00c0\\u00af\"}" &&
            written("\xed\xa0\x80") == "{\"a\": \"\\u00ed\\u00a0\\u0080\"}" &&
            written("\xf4\x90\x80\x80") ==
              "{\"a\": \"\\u00f4\\u0090\\u0080\\u0080\"}" &&
            written("\x80z") == "{\"a\": \"\\u0080z\"}",
          "what only looks like UTF-8 is escaped byte by byte");
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
    ParameterFile file =
      ParameterFile::from_text(test::collision_text(3), "price");
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
    Tree tree;
    boost::property_tree::read_json(folder + "/timing.json", tree);
    const auto [last, sums] = read_ledger(folder + "/ledger.csv");
    const double total      = tree.get<double>("total_seconds");

    // counts
    check(tree.get<std::string>("version") == EMMY_VERSION, "version");
    check(tree.get<double>("ranks") ==
            dealii::Utilities::MPI::n_mpi_processes(world),
          "ranks");
    check(tree.get<double>("steps") == last.at("step") &&
            last.at("step") == 12.,
          "steps");
    for (const char *column : {"newton_iterations", "linear_iterations"})
      check(tree.get<double>(column) == sums.at(column),
            std::string(column) + " of all steps");
    std::size_t n_halved = 0;
    for (const std::string &line : lines_of(folder + "/run.log"))
      n_halved += line.find("; halved to ") != std::string::npos;
    check(tree.get<double>("halvings") == n_halved && n_halved > 0, "halvings");
    check(tree.get<double>("peak_memory_bytes") >=
              tree.get<double>("peak_memory_bytes_of_a_rank") &&
            tree.get<double>("peak_memory_bytes_of_a_rank") > 1e6,
          "memory");

    // seconds
    std::vector<std::string>      names;
    std::map<std::string, double> seconds, within;
    double sum = tree.get<double>("seconds_outside_phases");
    for (const auto &[key, phase] : tree.get_child("phases"))
      {
        names.push_back(phase.get<std::string>("name"));
        seconds[names.back()] = phase.get<double>("seconds");
        sum += phase.get<double>("mean_seconds");
        check(phase.get<double>("mean_seconds") <=
                seconds[names.back()] * (1. + 1e-12),
              "no rank is slower than the slowest");
      }
    check_close(sum, total, 1e-9 * total, "phases add up to the wall time");
    double of_effects = 0., points_of_materials = 0.;
    for (const auto &[key, effect] : tree.get_child("effects"))
      {
        names.push_back(effect.get<std::string>("name"));
        seconds[names.back()] = effect.get<double>("seconds");
        if (names.back().find("material ") == 0)
          points_of_materials += effect.get<double>("points");
        if (const auto whole = effect.get_optional<std::string>("within"))
          within[*whole] += effect.get<double>("mean_seconds");
        else
          of_effects += effect.get<double>("mean_seconds");
      }
    check(of_effects > 0. && of_effects < total,
          "effects are less than the whole");
    for (const auto &[key, effect] : tree.get_child("effects"))
      if (effect.get<std::string>("name") == "internal force")
        check(effect.get<double>("points") == points_of_materials,
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
    for (const auto &[key, effect] : tree.get_child("effects"))
      for (const auto &[column, value] : effect.get_child("energies"))
        {
          check(energies.count(column) == 0, column + " has one owner");
          energies[column] = value.get_value<double>();
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
    check(tree.get<double>("balance_error") == last.at("balance_error") &&
            tree.get<double>("residual_work") == last.at("residual_work"),
          "what has no effect");
  }


  /** The second map of inelastic walls has its iterations, and no other. */
  void
  check_iterations(const std::string &folder)
  {
    Tree tree;
    boost::property_tree::read_json(folder + "/timing.json", tree);
    double of_map = 0.;
    for (const auto &[key, phase] : tree.get_child("phases"))
      if (phase.get<std::string>("name") == "velocity from momentum")
        of_map = phase.get<double>("linear_iterations");
    double      of_walls = 0.;
    std::string others;
    for (const auto &[key, effect] : tree.get_child("effects"))
      if (const auto n = effect.get_optional<double>("linear_iterations"))
        {
          if (effect.get<std::string>("name") == "inelastic walls")
            of_walls = *n;
          else
            others += effect.get<std::string>("name");
        }
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
  }
} // namespace


int
main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  test_json();
  const std::string folder =
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
    }
  return test::report();
}
