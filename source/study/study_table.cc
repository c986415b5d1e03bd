#include <deal.II/base/utilities.h>

#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/base/whole_file.h>
#include <emmy/study/study_table.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <ostream>
#include <sstream>

namespace emmy
{
  namespace
  {
    /** Of timing.json, in the order of study.csv. */
    const std::vector<std::pair<const char *, const char *>> counts = {
      {"peak_memory_bytes", "peak_memory_bytes"},
      {"total_newton_iterations", "newton_iterations"},
      {"total_linear_iterations", "linear_iterations"},
      {"steps", "steps"},
      {"ranks", "ranks"}};

    /** What a study takes from the timing.json of a run. */
    struct Timing
    {
      double                        seconds;
      std::map<std::string, double> counts;
      /** Columns seconds_PHASE, in the order of the phases. */
      std::vector<std::pair<std::string, double>> phases;
    };

    Timing
    read_timing(const std::string &filename)
    {
      Timing timing;
      try
        {
          std::ifstream file(filename);
          const auto    json = nlohmann::json::parse(file);
          timing.seconds     = json.at("total_seconds").get<double>();
          for (const auto &[column, key] : counts)
            timing.counts[column] = json.at(key).get<double>();
          for (const auto &phase : json.at("phases"))
            timing.phases.emplace_back(
              "seconds_" + dealii::Utilities::replace_in_string(
                             phase.at("name").get<std::string>(), " ", "_"),
              phase.at("seconds").get<double>());
        }
      catch (const nlohmann::json::exception &error)
        {
          AssertThrow(false,
                      ExcRun("Study",
                             "cannot read <" + filename + ">: " + error.what(),
                             "remove its folder, or run with --overwrite."));
        }
      return timing;
    }

    /** As a cell of a CSV file: on one line, in quotes where it needs them. */
    std::string
    cell(std::string text)
    {
      std::replace(text.begin(), text.end(), '\n', ' ');
      if (text.find_first_of(",\"") == std::string::npos)
        return text;
      return "\"" + dealii::Utilities::replace_in_string(text, "\"", "\"\"") +
             "\"";
    }

    /** Exactly; empty if it is not known. */
    std::string
    cell(const double number)
    {
      return std::isnan(number) ? std::string() : shortest(number);
    }
  } // namespace

  StudyTable::StudyTable(const StudyPlan &plan)
    : plan(plan)
    , rows(plan.members.size())
    , limits(plan.quantities.size(), {unknown, unknown})
  {
    for (Row &row : rows)
      row.values.assign(plan.quantities.size(), unknown);
    const auto names = column_names();
    for (const std::string &name : names)
      AssertThrow(std::count(names.begin(), names.end(), name) == 1,
                  ExcParameter("Study",
                               "Names",
                               name,
                               "study.csv would have two columns of this name. "
                               "Rename the list, or give the quantity once."));
  }

  bool
  StudyTable::has_difference(const unsigned int quantity) const
  {
    return plan.references[quantity].kind != StudyReference::Kind::none &&
           plan.quantities[quantity].kind != StudyQuantity::Kind::path;
  }

  std::vector<std::string>
  StudyTable::column_names() const
  {
    std::vector<std::string> names{"member"};
    for (const StudyList &list : plan.lists)
      names.push_back(list.name);
    names.push_back("state");
    for (unsigned int q = 0; q < plan.quantities.size(); ++q)
      {
        const std::string name = plan.quantities[q].name();
        if (plan.quantities[q].kind != StudyQuantity::Kind::path)
          names.push_back(name);
        if (has_difference(q))
          names.push_back(name + "_difference");
        names.insert(names.end(), {name + "_error", name + "_is_best"});
      }
    names.insert(names.end(),
                 {"final_balance_error", "median_seconds", "spread_seconds"});
    for (const auto &[column, key] : counts)
      names.push_back(column);
    names.insert(names.end(), phase_columns.begin(), phase_columns.end());
    return names;
  }

  void
  StudyTable::add_done(const unsigned int m)
  {
    Row &row  = rows[m];
    row.state = "done";
    row.seconds.clear();
    row.paths.resize(plan.quantities.size());
    const auto remember = [](std::vector<std::string>       &all,
                             const std::vector<std::string> &names) {
      for (const std::string &name : names)
        if (std::count(all.begin(), all.end(), name) == 0)
          all.push_back(name);
    };
    for (unsigned int r = 0; r < plan.repetitions; ++r)
      {
        const std::string folder = plan.folder(plan.members[m], r);
        const Timing      timing = read_timing(folder + "/timing.json");
        row.seconds.push_back(timing.seconds);
        if (r > 0)
          continue;
        row.numbers = timing.counts;
        for (const auto &[column, seconds] : timing.phases)
          {
            row.numbers[column] = seconds;
            remember(phase_columns, {column});
          }
        const LedgerHistory ledger(folder + "/ledger.csv");
        if (ledger.has("balance_error"))
          row.numbers["final_balance_error"] =
            ledger.column("balance_error").back();
        for (unsigned int q = 0; q < plan.quantities.size(); ++q)
          {
            const StudyQuantity &quantity = plan.quantities[q];
            if (!quantity.is_in(ledger))
              continue;
            remember(ledger_columns, {quantity.column});
            if (quantity.kind == StudyQuantity::Kind::path)
              row.paths[q] = quantity.path(ledger);
            else
              row.values[q] = quantity.value(ledger);
          }
        remember(ledger_columns, ledger.names);
      }
    std::sort(row.seconds.begin(), row.seconds.end());
  }

  void
  StudyTable::add_failed(const unsigned int m, const std::string &reason)
  {
    rows[m].state  = "failed";
    rows[m].reason = reason;
  }

  unsigned int
  StudyTable::n_done() const
  {
    return std::count_if(rows.begin(), rows.end(), [](const Row &row) {
      return row.state == "done";
    });
  }

  std::string
  StudyTable::unknown_quantities() const
  {
    std::vector<std::string> result;
    if (n_done() > 0)
      for (const StudyQuantity &quantity : plan.quantities)
        if (std::count(ledger_columns.begin(),
                       ledger_columns.end(),
                       quantity.column) == 0)
          {
            const std::string nearest =
              nearest_name(quantity.column, ledger_columns);
            result.push_back(
              "<" + quantity.column + ">" +
              (nearest.empty() ? "" : " (did you mean <" + nearest + ">?)"));
          }
    return join(result);
  }

  void
  StudyTable::find_limits()
  {
    if (!plan.has_sizes())
      return;
    std::vector<unsigned int> finest;
    const StudyCurve          last = study_curves(plan).back();
    for (const unsigned int m : last.members)
      if (is_done(m))
        finest.push_back(m);
    if (finest.size() < 3)
      return;
    finest.erase(finest.begin(), finest.end() - 3);
    for (unsigned int q = 0; q < plan.quantities.size(); ++q)
      {
        std::array<double, 3> sizes, values;
        for (unsigned int i = 0; i < 3; ++i)
          {
            sizes[i]  = size_of(plan, finest[i]);
            values[i] = rows[finest[i]].values[q];
          }
        limits[q] = richardson_limit(sizes, values);
      }
  }

  bool
  StudyTable::is_done(const unsigned int m) const
  {
    return rows[m].state == "done";
  }

  std::string
  StudyTable::state(const unsigned int m) const
  {
    return rows[m].state +
           (rows[m].reason.empty() ? "" : ": " + rows[m].reason);
  }

  double
  StudyTable::seconds(const unsigned int m) const
  {
    const std::vector<double> &all = rows[m].seconds;
    return all.empty()
             ? unknown
             : 0.5 * (all[(all.size() - 1) / 2] + all[all.size() / 2]);
  }

  double
  StudyTable::spread(const unsigned int m) const
  {
    const std::vector<double> &all = rows[m].seconds;
    return all.empty() ? unknown : all.back() - all.front();
  }

  double
  StudyTable::number(const unsigned int m, const std::string &column) const
  {
    const auto found = rows[m].numbers.find(column);
    return found == rows[m].numbers.end() ? unknown : found->second;
  }

  double
  StudyTable::reference(const unsigned int quantity) const
  {
    const StudyReference &reference = plan.references[quantity];
    switch (reference.kind)
      {
        case StudyReference::Kind::number:
          return reference.number;
        case StudyReference::Kind::member:
          return rows[reference.member].values[quantity];
        case StudyReference::Kind::limit:
          return limits[quantity].value;
        default:
          return unknown;
      }
  }

  double
  StudyTable::limit_order(const unsigned int quantity) const
  {
    return plan.references[quantity].kind == StudyReference::Kind::limit
             ? limits[quantity].order
             : unknown;
  }

  double
  StudyTable::difference(const unsigned int m,
                         const unsigned int quantity) const
  {
    return rows[m].values[quantity] - reference(quantity);
  }

  double
  StudyTable::error(const unsigned int m, const unsigned int quantity) const
  {
    const StudyReference &to    = plan.references[quantity];
    const double          given = plan.scales[quantity];
    const auto            over  = [given](const double size) {
      return given > 0. ? given : size > 0. ? size : 1.;
    };
    if (to.kind == StudyReference::Kind::none)
      return std::abs(rows[m].values[quantity]) / over(1.);
    if (to.kind == StudyReference::Kind::member && to.member == m)
      return unknown; // it is zero by definition
    if (plan.quantities[quantity].kind != StudyQuantity::Kind::path)
      return std::abs(difference(m, quantity)) /
             over(std::abs(reference(quantity)));
    if (!is_done(m) || !is_done(to.member))
      return unknown;
    const StudyPath &path = rows[to.member].paths[quantity];
    return distance(rows[m].paths[quantity], path) / over(path.range());
  }

  void
  StudyTable::write_csv(const std::string &filename) const
  {
    std::ostringstream       out;
    std::vector<std::string> cells = column_names();
    std::transform(cells.begin(), cells.end(), cells.begin(), [](auto name) {
      return cell(std::string(name));
    });
    const auto finish_line = [&out, &cells] {
      out << join(cells, ",") << '\n';
      cells.clear();
    };
    finish_line();

    std::vector<std::vector<bool>> is_best;
    for (unsigned int q = 0; q < plan.quantities.size(); ++q)
      is_best.push_back(pareto_front(all_seconds(), errors(q)));
    for (unsigned int m = 0; m < rows.size(); ++m)
      {
        const Row &row = rows[m];
        cells          = {plan.members[m].name};
        for (const std::string &value : plan.members[m].values)
          cells.push_back(cell(value));
        cells.push_back(cell(state(m)));
        for (unsigned int q = 0; q < plan.quantities.size(); ++q)
          {
            if (plan.quantities[q].kind != StudyQuantity::Kind::path)
              cells.push_back(cell(row.values[q]));
            if (has_difference(q))
              cells.push_back(cell(difference(m, q)));
            cells.push_back(cell(error(m, q)));
            cells.push_back(std::isnan(error(m, q)) ? ""
                            : is_best[q][m]         ? "1"
                                                    : "0");
          }
        for (const double value :
             {number(m, "final_balance_error"), seconds(m), spread(m)})
          cells.push_back(cell(value));
        for (const auto &[column, key] : counts)
          cells.push_back(cell(number(m, column)));
        for (const std::string &column : phase_columns)
          cells.push_back(cell(number(m, column)));
        finish_line();
      }
    const std::string problem = write_whole_file(filename, out.str());
    AssertThrow(problem.empty(), ExcRun("Study", problem, file_remedy));
  }

  std::vector<double>
  StudyTable::all_seconds() const
  {
    std::vector<double> result;
    for (unsigned int m = 0; m < rows.size(); ++m)
      result.push_back(seconds(m));
    return result;
  }

  std::vector<double>
  StudyTable::errors(const unsigned int quantity) const
  {
    std::vector<double> result;
    for (unsigned int m = 0; m < rows.size(); ++m)
      result.push_back(error(m, quantity));
    return result;
  }

  void
  StudyTable::print(std::ostream &out) const
  {
    std::vector<std::vector<std::string>> lines{{"member"}};
    for (const StudyList &list : plan.lists)
      if (list.varies())
        lines[0].push_back(list.name);
    lines[0].insert(lines[0].end(), {"state", "seconds"});
    for (const StudyQuantity &quantity : plan.quantities)
      lines[0].push_back(quantity.name() + "_error");
    for (unsigned int m = 0; m < rows.size(); ++m)
      {
        const auto text = [](const double number) {
          return std::isnan(number) ? std::string("-") : brief(number);
        };
        lines.push_back({plan.members[m].name});
        for (unsigned int i = 0; i < plan.lists.size(); ++i)
          if (plan.lists[i].varies())
            lines.back().push_back(plan.members[m].values[i]);
        lines.back().insert(lines.back().end(),
                            {rows[m].state, text(seconds(m))});
        for (unsigned int q = 0; q < plan.quantities.size(); ++q)
          lines.back().push_back(text(error(m, q)));
      }
    std::vector<std::size_t> widths(lines[0].size(), 0);
    for (const auto &line : lines)
      for (unsigned int c = 0; c < line.size(); ++c)
        widths[c] = std::max(widths[c], line[c].size());
    out << '\n';
    for (const auto &line : lines)
      for (unsigned int c = 0; c < line.size(); ++c)
        out << line[c]
            << (c + 1 == line.size()
                  ? std::string("\n")
                  : std::string(widths[c] - line[c].size() + 2, ' '));
    for (unsigned int m = 0; m < rows.size(); ++m)
      if (!rows[m].reason.empty())
        out << plan.members[m].name << " failed: " << rows[m].reason << '\n';
  }
} // namespace emmy
