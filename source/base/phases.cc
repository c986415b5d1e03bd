#include <emmy/base/exceptions.h>
#include <emmy/base/phases.h>

#include <boost/serialization/utility.hpp>

#include <algorithm>
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
  } // namespace


  Phases::Scope::Scope(Phases           &phases,
                       const std::size_t index,
                       const bool        is_effect)
    : phases(&phases)
    , index(index)
    , is_effect(is_effect)
    , outer(phases.open_effect)
    , start(Clock::now())
  {
    if (is_effect)
      phases.open_effect = index;
  }


  Phases::Scope::~Scope()
  {
    if (!phases)
      return;
    Entry &entry = (is_effect ? phases->effects_of_run : phases->phases)[index];
    entry.seconds += seconds_since(start);
    ++entry.calls;
    if (is_effect)
      phases->open_effect = outer;
    else
      phases->phase_is_open = false;
  }


  Phases::Phases(const MPI_Comm communicator)
    : communicator(communicator)
    , start(Clock::now())
  {}


  Phases::Scope
  Phases::scope(const std::string_view phase)
  {
    Assert(phase_is_open == false,
           ExcRun("Phase " + std::string(phase),
                  "another phase is still being timed",
                  "end the scope of that phase first: phases do not nest."));
    phase_is_open = true;
    return Scope(*this, find_or_add(phases, phase), /*is_effect=*/false);
  }


  Phases::Scope
  Phases::effect(const std::string_view name)
  {
    const std::size_t index = find_or_add(effects_of_run, name);
    if (open_effect != no_effect)
      effects_of_run[index].within = effects_of_run[open_effect].name;
    return Scope(*this, index, /*is_effect=*/true);
  }


  void
  Phases::add_count(const std::string_view phase, const std::size_t n_points)
  {
    phases[find_or_add(phases, phase)].points += n_points;
  }


  void
  Phases::add_effect_count(const std::string_view effect,
                           const std::size_t      n_points)
  {
    effects_of_run[find_or_add(effects_of_run, effect)].points += n_points;
  }


  void
  Phases::add_iterations(const std::string_view phase, const std::size_t n)
  {
    phases[find_or_add(phases, phase)].iterations += n;
    if (open_effect != no_effect)
      effects_of_run[open_effect].iterations += n;
  }


  void
  Phases::set_listener(std::function<void(const std::string &)> listener)
  {
    this->listener = std::move(listener);
  }


  void
  Phases::begin_task(const std::string &task)
  {
    this->task = task;
  }


  void
  Phases::tell(const std::string &news) const
  {
    if (listener)
      listener(task + ": " + news);
  }


  std::vector<Phases::Row>
  Phases::rows() const
  {
    return combined(phases);
  }


  std::vector<Phases::Row>
  Phases::effects() const
  {
    return combined(effects_of_run);
  }


  double
  Phases::seconds_here(const std::string_view effects) const
  {
    double seconds = 0.;
    for (const Entry &entry : effects_of_run)
      if (entry.name.compare(0, effects.size(), effects) == 0)
        seconds += entry.seconds;
    return seconds;
  }


  std::vector<Phases::Row>
  Phases::combined(const Entries &entries) const
  {
    // Ranks usually know the same names, but what only one rank does (a
    // picture drawn by rank 0) must not let the others wait for ever.
    using Name = std::pair<std::string, std::string>; // and what it is within
    // So rank 0 tells its names, and the others those that it has not.
    std::vector<Name> names, further;
    for (const Entry &entry : entries)
      names.emplace_back(entry.name, entry.within);
    names = dealii::Utilities::MPI::broadcast(communicator, names);
    const auto is_known = [&](const Name &name) {
      return std::find_if(names.begin(), names.end(), [&](const Name &other) {
               return other.first == name.first;
             }) != names.end();
    };
    for (const Entry &entry : entries)
      if (!is_known({entry.name, entry.within}))
        further.emplace_back(entry.name, entry.within);
    if (dealii::Utilities::MPI::max(further.size(), communicator) > 0)
      for (const auto &names_of_rank :
           dealii::Utilities::MPI::all_gather(communicator, further))
        for (const Name &name : names_of_rank)
          if (!is_known(name))
            names.push_back(name);

    std::vector<Row> rows;
    for (const auto &[name, within] : names)
      {
        Entry here;
        for (const Entry &entry : entries)
          if (entry.name == name)
            here = entry;
        const auto seconds =
          dealii::Utilities::MPI::min_max_avg(here.seconds, communicator);
        const auto largest = [&](const std::size_t n) {
          return dealii::Utilities::MPI::max(static_cast<double>(n),
                                             communicator);
        };
        Row row;
        row.name         = name;
        row.within       = within;
        row.seconds      = seconds.max;
        row.mean_seconds = seconds.avg;
        row.calls        = largest(here.calls);
        row.iterations   = largest(here.iterations);
        row.points =
          dealii::Utilities::MPI::sum(static_cast<double>(here.points),
                                      communicator);
        rows.push_back(row);
      }
    return rows;
  }


  double
  Phases::seconds_outside(const std::vector<Row> &rows, const double total)
  {
    double outside = total;
    for (const Row &row : rows)
      outside -= row.mean_seconds;
    return std::max(outside, 0.);
  }


  std::string
  time_headings(const std::string &what, const std::size_t name_width)
  {
    std::ostringstream line;
    line << std::left << std::setw(name_width) << what << std::right
         << std::setw(10) << "calls" << std::setw(12) << "seconds"
         << std::setw(9) << "share" << std::setw(12) << "points/s";
    return line.str();
  }


  std::string
  time_line(const Phases::Row &row,
            const double       total,
            const std::size_t  name_width)
  {
    const auto count = [](const double n) {
      std::ostringstream text;
      if (n > 0.)
        text << std::fixed << std::setprecision(0) << n;
      return text.str();
    };
    std::ostringstream line;
    line << std::left << std::setw(name_width) << row.name << std::right
         << std::setw(10) << count(row.calls) << std::fixed
         << std::setprecision(3) << std::setw(12) << row.seconds
         << std::setprecision(1) << std::setw(7)
         << (total > 0. ? 100. * row.seconds / total : 0.) << " %";
    if (row.points_per_second() > 0.)
      line << std::scientific << std::setprecision(2) << std::setw(12)
           << row.points_per_second();
    else if (row.iterations > 0.)
      line << std::setw(12) << "";
    if (row.iterations > 0.)
      line << std::setw(12) << count(row.iterations);
    return line.str();
  }


  void
  Phases::print(std::ostream           &out,
                const std::vector<Row> &rows,
                const double            total) const
  {
    std::size_t width = 16;
    for (const Row &row : rows)
      width = std::max(width, row.name.size());
    const std::string headings = time_headings("phase", width) + "  iterations";
    const std::string rule(headings.size(), '-');

    Row outside, whole;
    outside.name    = "(outside phases)";
    outside.seconds = seconds_outside(rows, total);
    whole.name      = "total wall time";
    whole.seconds   = total;

    out << headings << '\n' << rule << '\n';
    for (const Row &row : rows)
      out << time_line(row, total, width) << '\n';
    const unsigned int n_ranks =
      dealii::Utilities::MPI::n_mpi_processes(communicator);
    out << time_line(outside, total, width) << '\n'
        << rule << '\n'
        << time_line(whole, total, width) << "   on " << n_ranks
        << (n_ranks == 1 ? " rank" : " ranks") << '\n';
  }


  std::size_t
  Phases::find_or_add(Entries &entries, const std::string_view name)
  {
    // Some ten names: comparing them is faster than any map.
    for (std::size_t i = 0; i < entries.size(); ++i)
      if (entries[i].name == name)
        return i;
    entries.emplace_back();
    entries.back().name = name;
    return entries.size() - 1;
  }


  double
  Phases::total_seconds() const
  {
    return dealii::Utilities::MPI::max(seconds_since(start), communicator);
  }
} // namespace emmy
