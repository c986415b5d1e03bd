#include <deal.II/base/timer.h>

#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/output/ledger.h>
#include <emmy/run/scene.h>
#include <emmy/study/verify.h>

#include <cmath>
#include <iomanip>
#include <iostream>

namespace emmy
{
  namespace
  {
    template <int dim>
    LedgerColumns
    history_of(const ParameterFile &file, const MPI_Comm communicator)
    {
      const SceneParameters<dim> parameters(file);
      Scene<dim>                 scene(parameters, communicator);
      Ledger                     ledger(scene.initial_report(), dim);
      const TimeParameters      &time = parameters.time;
      while (ledger["time"] < time.end_time * (1. - 1e-12) &&
             (time.maximum_steps == 0 || ledger["step"] < time.maximum_steps))
        ledger.add(scene.advance());
      LedgerColumns history;
      for (const auto &row : ledger.rows())
        for (unsigned int c = 0; c < row.size(); ++c)
          history[ledger.columns()[c]].push_back(row[c]);
      return history;
    }

    /** What the claims of a scene come to. */
    class Table
    {
    public:
      explicit Table(std::ostream &out)
        : out(out)
      {}

      void
      begin(const std::string &scene)
      {
        out << '\n' << scene << '\n' << std::flush;
      }

      void
      add(const Claim &claim, const double value)
      {
        // NaN fails
        const bool holds = std::abs(value - claim.reference) <= claim.allowed;
        ++n_claims;
        n_failed += !holds;
        out << "  " << (holds ? "holds " : "FAILS ") << std::left
            << std::setw(46) << claim.what << std::right << std::setw(13)
            << brief(value) << std::setw(13)
            << (claim.reference == 0. ? "at most" : brief(claim.reference))
            << (claim.reference == 0. ? " " : " +- ") << std::left
            << std::setw(9) << brief(claim.allowed) << "  " << claim.source
            << '\n';
      }

      void
      end(const double seconds)
      {
        out << "  in " << brief(seconds) << " s\n" << std::flush;
      }

      /** A scene that did not come to its end fails as a whole. */
      void
      fail(const std::string &problem)
      {
        ++n_claims;
        ++n_failed;
        out << "  FAILS " << problem << '\n';
      }

      unsigned int n_claims = 0, n_failed = 0;

    private:
      std::ostream &out;
    };

    void
    run_case(const VerificationCase &one,
             const bool              full,
             const MPI_Comm          communicator,
             Table                  &table)
    {
      ParameterFile file =
        ParameterFile::from_text(verification_scenes().at(one.scene),
                                 one.scene + ".prm");
      for (const std::string &setting : one.settings)
        file.set(setting);
      if (!full)
        for (const std::string &setting : one.short_settings)
          file.set(setting);
      table.begin(one.scene);
      const dealii::Timer timer;
      try
        {
          const LedgerColumns history = file.value("Dimension", "") == "2"
                                          ? history_of<2>(file, communicator)
                                          : history_of<3>(file, communicator);
          for (const Claim &claim : one.claims)
            table.add(claim, claim.value(history));
          if (full)
            for (const Claim &claim : one.full_claims)
              table.add(claim, claim.value(history));
        }
      catch (const ExcRun &error) // of all ranks
        {
          table.fail(message_of(error));
        }
      table.end(timer.wall_time());
    }
  } // namespace

  bool
  verify(const bool full, const MPI_Comm communicator)
  {
    std::ostream nowhere(nullptr);
    const bool   is_first =
      dealii::Utilities::MPI::this_mpi_process(communicator) == 0;
    std::ostream &out = is_first ? std::cout : nowhere;
    Table         table(out);
    out << "emmy " EMMY_VERSION " against the paper, exact solutions and "
        << "others' results, in " << (full ? "full" : "short") << '\n';
    for (const VerificationCase &one : verification_cases())
      if (full || one.is_short)
        run_case(one, full, communicator, table);
    out << '\n'
        << (table.n_failed == 0 ? "all "
                                : std::to_string(table.n_failed) + " of ")
        << table.n_claims
        << (table.n_failed == 0 ? " claims hold" : " claims FAIL") << '\n';
    return table.n_failed == 0;
  }
} // namespace emmy
