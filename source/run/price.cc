#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/base/whole_file.h>
#include <emmy/run/price.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iomanip>
#include <ostream>

namespace emmy
{
  namespace
  {
    using Json = nlohmann::ordered_json;

    /** A count that was summed as a double, without the point. */
    std::int64_t
    whole(const double count)
    {
      return std::llround(count);
    }

    /** Add what another phase or part took. */
    void
    add_times(Phases::Row &sum, const Phases::Row &row)
    {
      sum.calls += row.calls;
      sum.seconds += row.seconds;
      sum.mean_seconds += row.mean_seconds;
      sum.points += row.points;
      sum.iterations += row.iterations;
    }

    Json
    json_of(const Phases::Row &row, const double total)
    {
      Json object{{"name", row.name}};
      if (!row.within.empty())
        object["within"] = row.within;
      object["calls"]         = whole(row.calls);
      object["seconds"]       = row.seconds;
      object["mean_seconds"]  = row.mean_seconds;
      object["share_percent"] = total > 0. ? 100. * row.seconds / total : 0.;
      if (row.points > 0.)
        {
          object["points"]            = whole(row.points);
          object["points_per_second"] = row.points_per_second();
        }
      if (row.iterations > 0.)
        object["linear_iterations"] = whole(row.iterations);
      return object;
    }

    /** The sum of a column of the ledger over its last steps. */
    double
    sum_of(const Ledger      &ledger,
           const std::string &column,
           const unsigned int n_steps)
    {
      const auto &names = ledger.columns();
      const auto  c =
        std::find(names.begin(), names.end(), column) - names.begin();
      const auto &rows = ledger.rows();
      double      sum  = 0.;
      for (std::size_t i = rows.size() - n_steps; i < rows.size(); ++i)
        sum += rows[i][c];
      return sum;
    }
  } // namespace

  Price::Price(const Phases                  &phases,
               const std::vector<EffectCard> &cards,
               const MPI_Comm                 communicator)
    : phases(phases)
    , communicator(communicator)
    , phase_rows(phases.rows())
    , total(phases.total_seconds())
  {
    const std::vector<Phases::Row> booked = phases.effects();
    const auto find = [](const std::vector<Phases::Row> &rows,
                         const std::string              &name) {
      return std::find_if(rows.begin(), rows.end(), [&](const auto &row) {
        return row.name == name;
      });
    };
    std::vector<std::string> told;
    for (const EffectCard &card : cards)
      {
        Line line;
        line.time.name = card.name;
        // the first has what several share, as all loads do their work
        for (const std::string &column : card.ledger_columns)
          if (std::find(told.begin(), told.end(), column) == told.end())
            {
              told.push_back(column);
              line.ledger_columns.push_back(column);
            }
        if (const auto row = find(booked, card.name); row != booked.end())
          line.time = *row;
        for (const std::string &phase : card.phases)
          if (const auto row = find(phase_rows, phase); row != phase_rows.end())
            add_times(line.time, *row);
        lines.push_back(line);
      }

    dealii::Utilities::System::MemoryStats memory; // in kB
    dealii::Utilities::System::get_memory_stats(memory);
    const auto over_ranks =
      dealii::Utilities::MPI::min_max_avg(1024. * memory.VmHWM, communicator);
    largest_memory = over_ranks.max;
    sum_of_memory  = over_ranks.sum;
  }

  void
  Price::print(std::ostream &out, const Ledger &ledger) const
  {
    phases.print(out, phase_rows, total);

    constexpr std::size_t indent = 2;
    std::size_t           width  = 16;
    for (const Line &line : lines)
      width = std::max(width,
                       line.time.name.size() +
                         (line.time.within.empty() ? 0 : indent));
    const bool has_iterations =
      std::any_of(lines.begin(), lines.end(), [](const Line &line) {
        return line.time.iterations > 0.;
      });
    const std::string headings =
      time_headings("effect", width) + (has_iterations ? "  iterations" : "");
    out << '\n'
        << headings << '\n'
        << std::string(headings.size(), '-') << '\n';
    for (const Line &line : lines)
      {
        Phases::Row time = line.time;
        if (!time.within.empty())
          time.name = std::string(indent, ' ') + time.name;
        out << time_line(time, total, width) << '\n';
        for (const EnergyEntry &entry : ledger.energies())
          if (std::count(line.ledger_columns.begin(),
                         line.ledger_columns.end(),
                         entry.name) > 0)
            out << "    " << std::left << std::setw(width + 10) << entry.name
                << std::right << ' ' << entry.change << " J\n";
      }
    out << "memory at its peak " << brief(largest_memory / 1e6)
        << " MB on one rank, " << brief(sum_of_memory / 1e6) << " MB on all\n";
  }

  void
  Price::write_json(const std::string &filename,
                    const Ledger      &ledger,
                    const RunCounts   &counts) const
  {
    Json json{{"version", EMMY_VERSION},
              {"ranks", dealii::Utilities::MPI::n_mpi_processes(communicator)},
              {"steps", counts.steps},
              {"halvings", counts.halvings},
              {"damped_steps", counts.damped},
              {"rebalancings", counts.rebalancings},
              {"newton_iterations",
               whole(sum_of(ledger, "newton_iterations", counts.steps))},
              {"linear_iterations",
               whole(sum_of(ledger, "linear_iterations", counts.steps))},
              {"peak_memory_bytes", whole(sum_of_memory)},
              {"peak_memory_bytes_of_a_rank", whole(largest_memory)},
              {"total_seconds", total},
              {"seconds_outside_phases",
               Phases::seconds_outside(phase_rows, total)},
              {"phases", Json::array()},
              {"effects", Json::array()},
              {"residual_work", ledger["residual_work"]},
              {"balance_error", ledger["balance_error"]}};
    for (const Phases::Row &row : phase_rows)
      json["phases"].push_back(json_of(row, total));
    for (const Line &line : lines)
      {
        Json effect        = json_of(line.time, total);
        effect["energies"] = Json::object();
        for (const EnergyEntry &entry : ledger.energies())
          if (std::count(line.ledger_columns.begin(),
                         line.ledger_columns.end(),
                         entry.name) > 0)
            effect["energies"][entry.name] = entry.change;
        json["effects"].push_back(effect);
      }

    std::string problem;
    if (dealii::Utilities::MPI::this_mpi_process(communicator) == 0)
      // bytes that are not UTF-8, as in names of old files, are replaced
      problem = write_whole_file(
        filename,
        json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n');
    throw_together(communicator,
                   "Writing the price of the run",
                   problem,
                   file_remedy);
  }
} // namespace emmy
