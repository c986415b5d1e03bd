#include <emmy/base/exceptions.h>
#include <emmy/base/phases.h>

#include <algorithm>
#include <fstream>
#include <iomanip>
#include <ostream>
#include <sstream>

namespace emmy
{
  namespace
  {
    using Clock = std::chrono::steady_clock;

    double
    seconds_since(const Clock::time_point start)
    {
      return std::chrono::duration<double>(Clock::now() - start).count();
    }


    /** Percent of the total; 0 before any time has passed. */
    double
    share(const double seconds, const double total)
    {
      return total > 0. ? 100. * seconds / total : 0.;
    }


    /** Seconds of the run that no phase accounts for. */
    double
    seconds_outside(const std::vector<Phases::Row> &rows, const double total)
    {
      double outside = total;
      for (const Phases::Row &row : rows)
        outside -= row.mean_seconds;
      return std::max(outside, 0.);
    }


    /** Text in quotes, with what JSON does not allow in them escaped. */
    std::string
    quoted(const std::string &text)
    {
      std::ostringstream out;
      out << '"';
      for (const char c : text)
        if (c == '"' || c == '\\')
          out << '\\' << c;
        else if (static_cast<unsigned char>(c) < 0x20)
          out << "\\u" << std::hex << std::setw(4) << std::setfill('0')
              << static_cast<int>(c);
        else
          out << c;
      out << '"';
      return out.str();
    }
  } // namespace


  Phases::Scope::Scope(Phases &phases, const std::size_t index)
    : phases(phases)
    , index(index)
    , start(Clock::now())
  {}


  Phases::Scope::~Scope()
  {
    Entry &entry = phases.entries[index];
    entry.seconds += seconds_since(start);
    ++entry.calls;
    phases.scope_is_open = false;
  }


  Phases::Phases(const MPI_Comm communicator)
    : communicator(communicator)
    , start(Clock::now())
  {}


  Phases::Scope
  Phases::scope(const std::string_view phase)
  {
    Assert(scope_is_open == false,
           ExcRun("Phase " + std::string(phase),
                  "another phase is still being timed",
                  "end the scope of that phase first: phases do not nest."));
    scope_is_open = true;
    return Scope(*this, find_or_add(phase));
  }


  void
  Phases::add_count(const std::string_view phase, const std::size_t n_points)
  {
    entries[find_or_add(phase)].points += n_points;
  }


  std::vector<Phases::Row>
  Phases::rows() const
  {
    // Ranks usually know the same phases, but what only one rank does (a
    // picture drawn by rank 0) must not let the others wait for ever.
    std::vector<std::string> own_names;
    for (const Entry &entry : entries)
      own_names.push_back(entry.name);
    std::vector<std::string> names;
    for (const auto &names_of_rank :
         dealii::Utilities::MPI::all_gather(communicator, own_names))
      for (const std::string &name : names_of_rank)
        if (std::find(names.begin(), names.end(), name) == names.end())
          names.push_back(name);

    std::vector<Row> rows;
    for (const std::string &name : names)
      {
        const auto entry =
          std::find_if(entries.begin(), entries.end(), [&](const Entry &e) {
            return e.name == name;
          });
        const bool is_here = entry != entries.end();

        const auto seconds =
          dealii::Utilities::MPI::min_max_avg(is_here ? entry->seconds : 0.,
                                              communicator);
        Row row;
        row.name         = name;
        row.seconds      = seconds.max;
        row.mean_seconds = seconds.avg;
        row.calls        = dealii::Utilities::MPI::max(
          is_here ? static_cast<double>(entry->calls) : 0., communicator);
        row.points = dealii::Utilities::MPI::sum(
          is_here ? static_cast<double>(entry->points) : 0., communicator);
        rows.push_back(row);
      }
    return rows;
  }


  void
  Phases::print(std::ostream &out) const
  {
    const std::vector<Row> rows  = this->rows();
    const double           total = total_seconds();
    if (dealii::Utilities::MPI::this_mpi_process(communicator) != 0)
      return;

    std::size_t width = 16;
    for (const Row &row : rows)
      width = std::max(width, row.name.size());

    // A stream of our own: the caller's keeps its format.
    std::ostringstream table;
    table << std::left << std::setw(width) << "phase" << std::right
          << std::setw(10) << "calls" << std::setw(12) << "seconds"
          << std::setw(9) << "share" << std::setw(13) << "points/s"
          << "\n"
          << std::string(width + 44, '-') << "\n";
    const auto begin_line = [&](const std::string &name,
                                const std::string &calls,
                                const double       seconds) {
      table << std::left << std::setw(width) << name << std::right
            << std::setw(10) << calls << std::fixed << std::setprecision(3)
            << std::setw(12) << seconds << std::setprecision(1) << std::setw(7)
            << share(seconds, total) << " %" << std::defaultfloat;
    };
    for (const Row &row : rows)
      {
        std::ostringstream calls;
        calls << std::fixed << std::setprecision(0) << row.calls;
        begin_line(row.name, calls.str(), row.seconds);
        if (row.points > 0. && row.seconds > 0.)
          table << std::scientific << std::setprecision(2) << std::setw(13)
                << row.points / row.seconds << std::defaultfloat;
        table << "\n";
      }
    begin_line("(outside phases)", "", seconds_outside(rows, total));
    table << "\n" << std::string(width + 44, '-') << "\n";
    begin_line("total wall time", "", total);

    const unsigned int n_ranks =
      dealii::Utilities::MPI::n_mpi_processes(communicator);
    table << "   on " << n_ranks << (n_ranks == 1 ? " rank" : " ranks") << "\n";
    out << table.str() << std::flush;
  }


  void
  Phases::write_json(const std::string &filename) const
  {
    const std::vector<Row> rows  = this->rows();
    const double           total = total_seconds();

    std::string problem;
    if (dealii::Utilities::MPI::this_mpi_process(communicator) == 0)
      {
        std::ofstream out(filename);
        out << std::setprecision(9) << "{\n  \"ranks\": "
            << dealii::Utilities::MPI::n_mpi_processes(communicator)
            << ",\n  \"total_seconds\": " << total
            << ",\n  \"seconds_outside_phases\": "
            << seconds_outside(rows, total) << ",\n  \"phases\": [";
        const char *separator = "\n";
        for (const Row &row : rows)
          {
            out << separator << "    {\"name\": " << quoted(row.name)
                << ", \"calls\": " << row.calls
                << ", \"seconds\": " << row.seconds
                << ", \"mean_seconds\": " << row.mean_seconds
                << ", \"share_percent\": " << share(row.seconds, total);
            if (row.points > 0.)
              out << ", \"points\": " << std::setprecision(17) << row.points
                  << std::setprecision(9) << ", \"points_per_second\": "
                  << (row.seconds > 0. ? row.points / row.seconds : 0.);
            out << "}";
            separator = ",\n";
          }
        out << "\n  ]\n}\n" << std::flush;
        if (!out)
          problem = "the file <" + filename + "> cannot be written";
      }
    throw_together(communicator,
                   "Writing the table of phases",
                   problem,
                   "check that its folder exists, may be written to, and "
                   "that the disk is not full.");
  }


  std::size_t
  Phases::find_or_add(const std::string_view phase)
  {
    // Some ten names: comparing them is faster than any map.
    for (std::size_t i = 0; i < entries.size(); ++i)
      if (entries[i].name == phase)
        return i;
    entries.push_back({std::string(phase)});
    return entries.size() - 1;
  }


  double
  Phases::total_seconds() const
  {
    return dealii::Utilities::MPI::max(seconds_since(start), communicator);
  }
} // namespace emmy
