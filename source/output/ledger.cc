#include <emmy/base/exceptions.h>
#include <emmy/base/sealed_file.h>
#include <emmy/base/text.h>
#include <emmy/base/whole_file.h>
#include <emmy/output/ledger.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <sstream>
#include <system_error>

namespace emmy
{
  namespace
  {
    /** The column of the first energy entry. */
    constexpr unsigned int first_energy = 6;

    std::vector<std::string>
    column_names(const StepReport &initial, const unsigned int dim)
    {
      std::vector<std::string> names{"step",
                                     "time",
                                     "time_step",
                                     "kinetic_energy",
                                     "kinetic_energy_grid_old",
                                     "kinetic_energy_grid_new"};
      for (const EnergyEntry &entry : initial.energies)
        names.push_back(entry.name);
      names.insert(names.end(), {"residual_work", "balance_error"});
      for (unsigned int d = 0; d < dim; ++d)
        names.push_back(std::string("linear_momentum_") + "xyz"[d]);
      for (unsigned int d = (dim == 2 ? 2 : 0); d < 3; ++d)
        names.push_back(std::string("angular_momentum_") + "xyz"[d]);
      names.insert(names.end(),
                   {"newton_iterations",
                    "linear_iterations",
                    "active_cells",
                    "active_dofs",
                    "particles"});
      for (const StepMeasure &measure : initial.measures)
        names.push_back(measure.name);
      for (const std::string &name : names)
        AssertThrow(std::count(names.begin(), names.end(), name) == 1,
                    ExcParameter("Measurements",
                                 "Names",
                                 name,
                                 "the ledger would have two columns of this "
                                 "name. Rename the measurement, or the tool or "
                                 "body that has it."));
      return names;
    }
  } // namespace

  Ledger::Ledger(const StepReport  &initial,
                 const unsigned int dim,
                 LedgerSums        *sums_of_run)
    : dim(dim)
    , names(column_names(initial, dim))
    , sums(sums_of_run ? *sums_of_run : own_sums)
  {
    sums             = {initial.energies};
    StepReport first = initial;
    first.time_step  = 0.; // no step led here
    for (EnergyEntry &entry : first.energies)
      entry.change = 0.;
    add(first);
  }

  void
  Ledger::write_to(const std::string &filename)
  {
    errno = 0;
    file.open(filename);
    name = filename;
    if (!file.is_open())
      write_problem = cannot_write(name, errno);
    file.precision(std::numeric_limits<double>::max_digits10);
    for (unsigned int c = 0; c < names.size(); ++c)
      file << (c ? "," : "") << names[c];
    file << '\n';
    for (const Row &row : all_rows)
      write_row(row);
  }

  void
  Ledger::add(const StepReport &report)
  {
    AssertDimension(report.energies.size(), sums.energies.size());
    sums.balance_error += report.kinetic_energy_change - report.residual_work;
    sums.residual_work += report.residual_work;
    for (unsigned int i = 0; i < sums.energies.size(); ++i)
      {
        const double change = report.energies[i].change;
        sums.energies[i].change += change;
        sums.balance_error +=
          sums.energies[i].kind == EnergyEntry::Kind::work ? -change : change;
      }

    Row row{static_cast<double>(report.step),
            report.time,
            report.time_step,
            report.totals.kinetic_energy,
            report.kinetic_energy_grid_old,
            report.kinetic_energy_grid_new};
    for (const EnergyEntry &sum : sums.energies)
      row.push_back(sum.change);
    row.insert(row.end(), {sums.residual_work, sums.balance_error});
    for (unsigned int d = 0; d < dim; ++d)
      row.push_back(report.totals.linear_momentum[d]);
    for (unsigned int d = (dim == 2 ? 2 : 0); d < 3; ++d)
      row.push_back(report.totals.angular_momentum[d]);
    for (const auto count :
         {static_cast<std::uint64_t>(report.newton_iterations),
          static_cast<std::uint64_t>(report.linear_iterations),
          report.active_cells,
          report.active_dofs,
          report.totals.particles})
      row.push_back(count);
    for (const StepMeasure &measure : report.measures)
      row.push_back(measure.value);
    AssertDimension(row.size(), names.size());
    all_rows.push_back(row);
    if (file.is_open())
      write_row(row);
  }

  const std::string &
  Ledger::problem() const
  {
    return write_problem;
  }

  const std::vector<std::string> &
  Ledger::columns() const
  {
    return names;
  }

  const std::vector<Ledger::Row> &
  Ledger::rows() const
  {
    return all_rows;
  }

  const std::vector<EnergyEntry> &
  Ledger::energies() const
  {
    return sums.energies;
  }

  double
  Ledger::operator[](const std::string &column) const
  {
    const auto position = std::find(names.begin(), names.end(), column);
    AssertThrow(position != names.end(),
                dealii::ExcMessage("The ledger has no column <" + column +
                                   ">."));
    return all_rows.back()[position - names.begin()];
  }

  double
  Ledger::total_energy() const
  {
    return energy_of(all_rows.back());
  }

  double
  Ledger::energy_at_start() const
  {
    return energy_of(all_rows.front());
  }

  double
  Ledger::largest_energy() const
  {
    double largest = energy_of(all_rows.front());
    for (const Row &row : all_rows)
      largest = std::max(largest, energy_of(row));
    return largest;
  }

  double
  Ledger::energy_of(const Row &row) const
  {
    double total = row[3]; // kinetic
    for (unsigned int i = 0; i < sums.energies.size(); ++i)
      if (sums.energies[i].kind == EnergyEntry::Kind::stored)
        total += row[first_energy + i];
    return total;
  }

  std::string
  Ledger::go_on(const std::string &filename,
                const unsigned int step,
                const double       time)
  {
    std::ifstream in(filename, std::ios::binary);
    if (!in)
      return "the file <" + filename + "> cannot be read";
    std::string line;
    const auto  whole_line = [&] {
      // a line without its end was cut
      return static_cast<bool>(std::getline(in, line)) && !in.eof();
    };
    if (!whole_line() || line != join(names, ","))
      return "the file <" + filename + "> has other columns than the run";
    std::vector<Row> rows;
    while (rows.size() <= step && whole_line())
      {
        Row         row;
        const char *from = line.c_str();
        for (char *end = nullptr; *from != '\0'; from = end + (*end == ','))
          {
            row.push_back(std::strtod(from, &end));
            if (end == from || (*end != ',' && *end != '\0'))
              break;
          }
        if (row.size() != names.size() || row[0] != rows.size())
          return "the file <" + filename + "> has no row of step " +
                 std::to_string(rows.size()) + " where it should be";
        rows.push_back(row);
      }
    if (rows.size() <= step)
      return "the file <" + filename + "> ends before step " +
             std::to_string(step) + ", with " + std::to_string(rows.size()) +
             " rows";
    if (rows[step][1] != time)
      return "the file <" + filename + "> has another time at step " +
             std::to_string(step) + " than the checkpoint";
    const std::streamoff length = in.tellg();
    in.close();
    std::error_code error;
    std::filesystem::resize_file(filename, length, error);
    if (error)
      return cannot_write(filename, error.value());
    errno = 0;
    file.open(filename, std::ios::app);
    if (!file.is_open())
      return cannot_write(filename, errno);
    name = filename;
    file.precision(std::numeric_limits<double>::max_digits10);
    set_rows(rows);
    return {};
  }

  void
  Ledger::set_rows(const std::vector<Row> &rows)
  {
    all_rows = rows;
  }

  std::string
  Ledger::flush() const
  {
    return file.is_open() ? flush_to_disk(name) : std::string();
  }

  void
  Ledger::write_row(const Row &row)
  {
    // in one piece, so that who is killed leaves whole lines
    std::ostringstream line;
    line.precision(file.precision());
    for (unsigned int c = 0; c < row.size(); ++c)
      line << (c ? "," : "") << row[c];
    line << '\n';
    errno = 0;
    file << line.str() << std::flush;
    if (!file.good() && write_problem.empty())
      write_problem = cannot_write(name, errno);
  }
} // namespace emmy
