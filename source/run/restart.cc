#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/run/restart.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <ostream>
#include <sstream>

namespace emmy
{
  namespace
  {
    /** Whether two values are the same text, or the same numbers. */
    bool
    is_same(const std::string &a, const std::string &b)
    {
      if (a == b)
        return true;
      const auto list_a = dealii::Utilities::split_string_list(a, ',');
      const auto list_b = dealii::Utilities::split_string_list(b, ',');
      return list_a.size() == list_b.size() &&
             std::equal(list_a.begin(),
                        list_a.end(),
                        list_b.begin(),
                        [](const std::string &x, const std::string &y) {
                          char        *end_x = nullptr, *end_y = nullptr;
                          const double number_x =
                                         std::strtod(x.c_str(), &end_x),
                                       number_y =
                                         std::strtod(y.c_str(), &end_y);
                          return x == y ||
                                 (!x.empty() && !y.empty() && *end_x == '\0' &&
                                  *end_y == '\0' && number_x == number_y);
                        });
    }

    /** All values of a printed parameter file, by path. */
    std::map<std::string, std::string>
    values_in(const std::string &parameters)
    {
      std::map<std::string, std::string> result;
      std::vector<std::string>           sections;
      std::istringstream                 in(parameters);
      for (std::string line; std::getline(in, line);)
        {
          std::istringstream words(line.substr(0, line.find('#')));
          std::string        first, rest;
          words >> first;
          std::getline(words, rest);
          rest = dealii::Utilities::trim(rest);
          if (first == "subsection")
            sections.push_back(rest);
          else if (first == "end")
            sections.pop_back();
          else if (first == "set")
            {
              const auto        equal = rest.find('=');
              const std::string name =
                dealii::Utilities::trim(rest.substr(0, equal));
              std::vector<std::string> path = sections;
              path.push_back(name);
              result[join(path, "/")] =
                dealii::Utilities::trim(rest.substr(equal + 1));
            }
        }
      return result;
    }

    bool
    starts_with(const std::string &text, const std::string &start)
    {
      return text.compare(0, start.size(), start) == 0;
    }

    /** What says how a run goes on, and nothing of what it is. */
    bool
    may_differ(const std::string &path)
    {
      for (const char *section :
           {"Output/", "Solver/", "Checkpoint/", "Ranks/", "Start/"})
        if (starts_with(path, section))
          return true;
      if (starts_with(path, "Time/"))
        return path != "Time/Integrator" && path != "Time/Stress update";
      return path == "Title" || path == "Method/Geometry tolerance" ||
             path == "Diagnosis/Report above";
    }

    /** What acts from outside; not which particles hold it. */
    bool
    is_load(const std::string &path)
    {
      const std::string entry = path.substr(path.rfind('/') + 1);
      if (starts_with(path, "Boundary conditions/"))
        return entry.find("elocity") != std::string::npos;
      const std::vector<std::string> loads{
        "Acceleration", "Force", "Amplitude", "Amplitude table", "Sampling"};
      if (starts_with(path, "Effects/Surface loads/"))
        return entry == "Traction" || entry == "Pressure" ||
               std::count(loads.begin(), loads.end(), entry) > 0;
      // what stands deeper is of a part of an effect, as of an exact motion
      return starts_with(path, "Effects/") &&
             std::count(path.begin(), path.end(), '/') == 2 &&
             std::count(loads.begin(), loads.end(), entry) > 0;
    }
  } // namespace

  ParameterFile
  parameters_to_go_on(const SavedRun                 &saved,
                      const std::string              &filename,
                      const std::vector<std::string> &assignments)
  {
    ParameterFile file =
      filename.empty() ? ParameterFile::from_text(saved.parameters, saved.path)
                       : ParameterFile(filename);
    file.set("Output/Directory=" + saved.directory, "--restart");
    file.set("Output/Overwrite=false", "--restart");
    // kept there, as the other run may be gone
    if (!file.value("Start/From", "").empty())
      file.set("Start/From=" + saved.directory + "/start", "--restart");
    if (saved.is_failure)
      file.set("Time/Maximum steps=" + std::to_string(saved.step + 1),
               "--restart");
    for (const std::string &assignment : assignments)
      file.set(assignment);
    AssertThrow(file.value("Output/Directory", "") == saved.directory,
                ExcRun("Restart",
                       "--set Output/Directory names another folder than "
                       "--restart",
                       "a run goes on in its own folder. Copy the folder and "
                       "restart the copy, or start a new run from it (section "
                       "Start)."));
    return file;
  }

  std::vector<std::string>
  changes_to_go_on(const SavedRun    &saved,
                   const std::string &parameters,
                   const bool         new_loads)
  {
    const auto then = values_in(saved.parameters), now = values_in(parameters);
    std::map<std::string, std::string> both = then;
    both.insert(now.begin(), now.end());
    std::vector<std::string> changes, refused;
    for (const auto &[path, ignored] : both)
      {
        (void)ignored;
        const auto value_in = [&path = path](const auto &all) {
          const auto found = all.find(path);
          return found == all.end() ? std::string() : found->second;
        };
        const std::string before = value_in(then), after = value_in(now);
        if (is_same(before, after) || path == "Output/Directory" ||
            path == "Output/Overwrite" || path == "Start/From")
          continue;
        const std::string line =
          path + " = " + after + " (it was: " + before + ")";
        const bool is_of_loads = is_load(path);
        if (saved.is_failure || may_differ(path) || (new_loads && is_of_loads))
          changes.push_back(line);
        else
          refused.push_back(line);
      }
    AssertThrow(refused.empty(),
                ExcRun("Restart",
                       "this scene contradicts the run in <" + saved.directory +
                         ">:\n    " + join(refused, "\n    "),
                       std::string("leave these as they were. Time, Output, "
                                   "Solver and Checkpoint may be others") +
                         (new_loads ? ""
                                    : "; with --new-loads also forces, "
                                      "accelerations, amplitudes and the "
                                      "velocities of walls") +
                         ". Another scene can start from the state of this "
                         "run: section Start."));
    return changes;
  }

  template <int dim>
  void
  go_on(const SavedRun     &saved,
        const RunDirectory &directory,
        Scene<dim>         &scene,
        Ledger             &ledger)
  {
    recall(saved, scene);
    if (saved.is_failure) // its folder has no frames
      for (auto *files : {&scene.state.frames.particle_files,
                          &scene.state.frames.grid_files,
                          &scene.state.frames.surface_files})
        files->clear();
    if (saved.is_failure)
      scene.state.frames.film.clear();
    const MPI_Comm communicator = scene.grid.communicator();
    const bool     is_first =
      dealii::Utilities::MPI::this_mpi_process(communicator) == 0;
    std::string problem;
    if (is_first)
      problem =
        ledger.go_on(directory.file("ledger.csv"), saved.step, saved.time);
    throw_together(communicator,
                   "Restart",
                   problem,
                   "the ledger of a run goes on row by row. Put back the "
                   "ledger.csv that the run wrote, or start a new run from its "
                   "state (section Start).");
    ledger.set_rows(
      dealii::Utilities::MPI::broadcast(communicator, ledger.rows()));
    CheckpointFolder(directory.path(), communicator)
      .set_aside_after(saved.step);
  }

  void
  describe_restart(const SavedRun                 &saved,
                   const std::vector<std::string> &changes,
                   const unsigned int              n_ranks,
                   std::ostream                   &out)
  {
    const auto ranks = [](const unsigned int n) {
      return std::to_string(n) + (n == 1 ? " rank" : " ranks");
    };
    out << "continued from step " << saved.step << ", t = " << saved.time
        << " s, on " << ranks(n_ranks) << " (checkpoint <" << saved.path
        << ">, written on " << ranks(saved.n_ranks) << ")\n";
    for (const std::string &problem : saved.passed_over)
      out << "  note: a newer checkpoint is not used: " << problem << '\n';
    for (const std::string &change : changes)
      out << "  changed: " << change << '\n';
  }

  template void
  go_on<2>(const SavedRun &, const RunDirectory &, Scene<2> &, Ledger &);
  template void
  go_on<3>(const SavedRun &, const RunDirectory &, Scene<3> &, Ledger &);
} // namespace emmy
