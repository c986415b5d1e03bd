#include <deal.II/base/utilities.h>

#include <boost/property_tree/json_parser.hpp>

#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/study/study_table.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <ostream>

namespace emmy
{
  namespace
  {
    /** Last and largest values of each column of a ledger.csv. */
    struct LedgerEnds
    {
      std::vector<std::string> columns;
      std::vector<double>      last, largest;

      explicit LedgerEnds(const std::string &filename);

      /** A number of a column; @p missing if there is none. */
      double
      value(const StudyQuantity &quantity, const double missing) const
      {
        const auto c =
          std::find(columns.begin(), columns.end(), quantity.column) -
          columns.begin();
        if (c == static_cast<std::ptrdiff_t>(columns.size()))
          return missing;
        return quantity.is_largest ? largest[c] : last[c];
      }
    };

    LedgerEnds::LedgerEnds(const std::string &filename)
    {
      std::ifstream file(filename);
      std::string   line;
      std::getline(file, line);
      columns = dealii::Utilities::split_string_list(line, ',');
      while (std::getline(file, line))
        {
          last.clear();
          for (const std::string &word :
               dealii::Utilities::split_string_list(line, ','))
            last.push_back(std::strtod(word.c_str(), nullptr));
          largest.resize(last.size(), 0.);
          for (unsigned int c = 0; c < last.size(); ++c)
            if (std::abs(last[c]) >= std::abs(largest[c]))
              largest[c] = last[c];
        }
      AssertThrow(!last.empty() && last.size() == columns.size(),
                  ExcRun("Study",
                         "cannot read <" + filename + ">",
                         "remove its folder, or run with --overwrite."));
    }

    boost::property_tree::ptree
    read_json(const std::string &filename)
    {
      boost::property_tree::ptree tree;
      try
        {
          boost::property_tree::read_json(filename, tree);
        }
      catch (const boost::property_tree::ptree_error &error)
        {
          AssertThrow(false,
                      ExcRun("Study",
                             "cannot read <" + filename + ">: " + error.what(),
                             "remove its folder, or run with --overwrite."));
        }
      return tree;
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
  {
    for (Row &row : rows)
      row.quantities.assign(plan.quantities.size(), unknown);
    const auto names = column_names();
    for (const std::string &name : names)
      AssertThrow(std::count(names.begin(), names.end(), name) == 1,
                  ExcParameter("Study",
                               "Names",
                               name,
                               "study.csv would have two columns of this name. "
                               "Rename the list, or give the quantity once."));
  }

  std::vector<std::string>
  StudyTable::column_names() const
  {
    std::vector<std::string> names{"member"};
    for (const StudyList &list : plan.lists)
      names.push_back(list.name);
    names.push_back("state");
    for (const StudyQuantity &quantity : plan.quantities)
      names.insert(names.end(),
                   {quantity.name(), quantity.name() + "_difference"});
    names.insert(names.end(),
                 {"final_balance_error",
                  "median_seconds",
                  "spread_seconds",
                  "peak_memory_bytes",
                  "total_newton_iterations",
                  "total_linear_iterations",
                  "steps",
                  "ranks"});
    return names;
  }

  void
  StudyTable::add_done(const unsigned int m)
  {
    Row &row  = rows[m];
    row.state = "done";
    row.seconds.clear();
    for (unsigned int r = 0; r < plan.repetitions; ++r)
      {
        const std::string folder = plan.folder(plan.members[m], r);
        const auto        timing = read_json(folder + "/timing.json");
        const auto        number = [&timing](const char *key) {
          return timing.get<double>(key, unknown);
        };
        row.seconds.push_back(number("total_seconds"));
        row.memory = std::fmax(row.memory, number("peak_memory_bytes"));
        if (r > 0)
          continue;
        row.ranks             = number("ranks");
        row.steps             = number("steps");
        row.newton_iterations = number("newton_iterations");
        row.linear_iterations = number("linear_iterations");
        const LedgerEnds ledger(folder + "/ledger.csv");
        row.balance_error = ledger.value({"balance_error", false}, unknown);
        for (unsigned int q = 0; q < plan.quantities.size(); ++q)
          row.quantities[q] = ledger.value(plan.quantities[q], unknown);
        for (const std::string &column : ledger.columns)
          if (std::count(ledger_columns.begin(),
                         ledger_columns.end(),
                         column) == 0)
            ledger_columns.push_back(column);
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

  double
  StudyTable::Row::median_seconds() const
  {
    if (seconds.empty())
      return unknown;
    return 0.5 *
           (seconds[(seconds.size() - 1) / 2] + seconds[seconds.size() / 2]);
  }

  double
  StudyTable::difference(const unsigned int m,
                         const unsigned int quantity) const
  {
    return plan.reference == StudyPlan::no_reference
             ? unknown
             : rows[m].quantities[quantity] -
                 rows[plan.reference].quantities[quantity];
  }

  void
  StudyTable::write_csv(const std::string &filename) const
  {
    std::ofstream            out(filename);
    std::vector<std::string> cells = column_names();
    std::transform(cells.begin(), cells.end(), cells.begin(), [](auto name) {
      return cell(std::string(name));
    });
    const auto finish_line = [&out, &cells] {
      out << join(cells, ",") << '\n';
      cells.clear();
    };
    finish_line();

    for (unsigned int m = 0; m < rows.size(); ++m)
      {
        const Row &row = rows[m];
        cells          = {plan.members[m].name};
        for (const std::string &value : plan.members[m].values)
          cells.push_back(cell(value));
        cells.push_back(
          cell(row.reason.empty() ? row.state : row.state + ": " + row.reason));
        for (unsigned int q = 0; q < plan.quantities.size(); ++q)
          for (const double number : {row.quantities[q], difference(m, q)})
            cells.push_back(cell(number));
        for (const double number :
             {row.balance_error,
              row.median_seconds(),
              row.seconds.empty() ? unknown
                                  : row.seconds.back() - row.seconds.front(),
              row.memory,
              row.newton_iterations,
              row.linear_iterations,
              row.steps,
              row.ranks})
          cells.push_back(cell(number));
        finish_line();
      }
    out << std::flush;
    AssertThrow(out,
                ExcRun("Study",
                       "cannot write <" + filename + ">",
                       "check the folder's permissions and the disk's free "
                       "space."));
  }

  void
  StudyTable::print(std::ostream &out) const
  {
    const bool has_reference = plan.reference != StudyPlan::no_reference;
    std::vector<std::vector<std::string>> lines{{"member"}};
    for (const StudyList &list : plan.lists)
      lines[0].push_back(list.name);
    lines[0].insert(lines[0].end(), {"state", "seconds"});
    for (const StudyQuantity &quantity : plan.quantities)
      lines[0].push_back(quantity.name());
    for (unsigned int m = 0; m < rows.size(); ++m)
      {
        const auto text = [](const double number) {
          return std::isnan(number) ? std::string("-") : brief(number);
        };
        lines.push_back({plan.members[m].name});
        for (const std::string &value : plan.members[m].values)
          lines.back().push_back(value);
        lines.back().insert(lines.back().end(),
                            {rows[m].state, text(rows[m].median_seconds())});
        for (unsigned int q = 0; q < plan.quantities.size(); ++q)
          lines.back().push_back(text(has_reference && m != plan.reference
                                        ? difference(m, q)
                                        : rows[m].quantities[q]));
      }
    std::vector<std::size_t> widths(lines[0].size(), 0);
    for (const auto &line : lines)
      for (unsigned int c = 0; c < line.size(); ++c)
        widths[c] = std::max(widths[c], line[c].size());
    out << '\n';
    for (const auto &line : lines)
      {
        for (unsigned int c = 0; c < line.size(); ++c)
          out << line[c]
              << (c + 1 == line.size()
                    ? std::string("\n")
                    : std::string(widths[c] - line[c].size() + 2, ' '));
      }
    if (has_reference && !plan.quantities.empty())
      out << "quantities: differences to " << plan.members[plan.reference].name
          << ", its own values in its line"
          << (rows[plan.reference].state == "done" ? ""
                                                   : "; it is not done, so "
                                                     "there are none")
          << '\n';
    for (unsigned int m = 0; m < rows.size(); ++m)
      if (!rows[m].reason.empty())
        out << plan.members[m].name << " failed: " << rows[m].reason << '\n';
  }
} // namespace emmy
