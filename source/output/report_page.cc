#include <emmy/base/text.h>
#include <emmy/base/whole_file.h>
#include <emmy/output/report_page.h>
#include <emmy/output/report_template.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <set>

namespace emmy
{
  namespace
  {
    using nlohmann::json;

    constexpr std::size_t most_rows = 2000;

    /** Nothing if there is no such file. */
    std::optional<std::string>
    content_of(const std::string &filename)
    {
      std::ifstream in(filename);
      if (!in)
        return {};
      return std::string(std::istreambuf_iterator<char>(in), {});
    }

    /** The page with @p content where it has a name between two @ signs. */
    void
    put(std::string &page, const std::string &name, const std::string &content)
    {
      const std::string mark = "@" + name + "@";
      page.replace(page.find(mark), mark.size(), content);
    }

    /** JSON in which nothing can end the script that it stands in. */
    std::string
    in_script(const json &object)
    {
      const std::string text =
        object.dump(-1, ' ', false, json::error_handler_t::replace);
      std::string result;
      for (const char letter : text)
        if (letter == '<') // in strings only
          result += "\\u003c";
        else
          result += letter;
      return result;
    }

    /** The scene as run.log has it, before the first step; how it ended. */
    void
    add_log(json &run, const std::string &directory)
    {
      std::istringstream log(content_of(directory + "/run.log").value_or(""));
      std::string        card;
      bool               is_card = true;
      std::string        ended   = "complete";
      for (std::string line; std::getline(log, line);)
        {
          is_card = is_card && line.compare(0, 5, "step ") != 0 &&
                    line.compare(0, 5, "Step ") != 0;
          if (is_card)
            card += line + '\n';
          if (line.compare(0, 8, "stopped:") == 0 ||
              line.compare(0, 15, "interrupted by ") == 0)
            ended = line;
          else if (line.compare(0, 15, "continued from ") == 0)
            ended = "complete";
        }
      run["card"]  = card;
      run["ended"] = ended;
    }

    void
    add_ledger(json                           &run,
               const Ledger                   &ledger,
               const std::vector<std::string> &measurements)
    {
      const auto       &rows   = ledger.rows();
      const std::size_t stride = (rows.size() + most_rows - 1) / most_rows;
      json              drawn  = json::array();
      for (std::size_t i = 0; i < rows.size(); ++i)
        if (i % stride == 0 || i + 1 == rows.size())
          drawn.push_back(rows[i]); // what is not finite becomes null
      run["columns"] = ledger.columns();
      run["rows"]    = std::move(drawn);
      run["steps"]   = rows.back()[0];
      run["thinned"] = stride > 1 ? stride : 0;
      for (const char *const kind : {"stored", "dissipated", "work"})
        run[kind] = json::array();
      for (const EnergyEntry &entry : ledger.energies())
        run[entry.kind == EnergyEntry::Kind::stored       ? "stored"
            : entry.kind == EnergyEntry::Kind::dissipated ? "dissipated"
                                                          : "work"]
          .push_back(entry.name);
      run["measured"]  = json::array();
      const auto group = [&](const std::string &name,
                             const std::string &beginning) {
        json columns = json::array();
        for (const std::string &column : ledger.columns())
          if (column == name ||
              column.compare(0, beginning.size(), beginning) == 0)
            columns.push_back(column);
        if (!columns.empty())
          run["measured"].push_back({{"name", name}, {"columns", columns}});
      };
      // forces on sides, tools and held parts
      std::set<std::string> forces;
      for (const std::string &column : ledger.columns())
        if (const auto end = column.find("_force_"); end != std::string::npos)
          if (forces.insert(column.substr(0, end)).second)
            group(column.substr(0, end), column.substr(0, end) + "_force_");
      for (const std::string &name : measurements)
        group(name, name + "_");
    }

    std::vector<std::string>
    files_in(const std::string &directory)
    {
      std::vector<std::string> files;
      std::error_code          error; // a folder that vanished has no files
      for (const auto &entry :
           std::filesystem::recursive_directory_iterator(directory, error))
        if (entry.is_regular_file(error))
          {
            const auto name     = entry.path().lexically_relative(directory);
            const auto end      = name.extension();
            const bool is_shown = name.begin() == --name.end()
                                    ? end != ".vtu" && end != ".pvtu"
                                    : end == ".png" || end == ".svg";
            if (is_shown && name != "report.html")
              files.push_back(name.string());
          }
      std::sort(files.begin(), files.end());
      return files;
    }

    std::string
    library_folder()
    {
      const char *const folder = std::getenv("EMMY_DYGRAPHS");
      return folder ? folder : "/usr/share/javascript/dygraphs";
    }
  } // namespace

  std::string
  write_report(const std::string &directory,
               const Ledger      &ledger,
               const Report      &report)
  {
    json run{{"title", report.title},
             {"version", EMMY_VERSION},
             {"command", report.command},
             {"files", files_in(directory)}};
    add_log(run, directory);
    add_ledger(run, ledger, report.measurements);
    run["timing"] =
      json::parse(content_of(directory + "/timing.json").value_or("{}"),
                  nullptr,
                  /*allow_exceptions=*/false);
    if (report.film)
      run["film"] = json::parse(report.film->json());

    const auto library = content_of(library_folder() + "/dygraph.min.js"),
               style   = content_of(library_folder() + "/dygraph.min.css");
    std::string page   = report_template;
    put(page, "STYLE", style.value_or(""));
    put(page, "LIBRARY", library.value_or(""));
    put(page, "DATA", in_script(run));
    const std::string problem =
      write_whole_file(directory + "/report.html", page);
    if (!problem.empty())
      return problem;
    return library ? ""
                   : "report.html has no curves: install the package "
                     "libjs-dygraphs";
  }
} // namespace emmy
