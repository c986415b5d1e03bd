#include <emmy/base/text.h>
#include <emmy/run/closing_lines.h>

#include <algorithm>
#include <cmath>
#include <ostream>

namespace emmy
{
  namespace
  {
    /**
     * The work that solves left, J: its sum, and a line if that may matter.
     * The magnitudes of all steps are added, so that none hides another: a
     * step may leave a rest that does not matter alone.
     */
    void
    tell_of_residuals(std::ostream &out,
                      const Ledger &ledger,
                      const double  energy)
    {
      constexpr double matters = 1e-8; // of the energy
      const auto      &names   = ledger.columns();
      const auto       column =
        std::find(names.begin(), names.end(), "residual_work") - names.begin();
      double all = 0.;
      for (unsigned int row = 1; row < ledger.rows().size(); ++row)
        all +=
          std::abs(ledger.rows()[row][column] - ledger.rows()[row - 1][column]);
      out << "work of residuals " << ledger["residual_work"]
          << " J, of all steps without their signs " << all << " J\n";
      if (!(all <= matters * energy))
        out << "note: that is "
            << (energy > 0. ? brief(all / energy) + " of the largest energy"
                            : "all energy that there was")
            << ", more than " << matters
            << ": what the solves left may matter. Lower Solver/Newton "
               "tolerance and Linear tolerance, or shorten the steps that "
               "run.log names\n";
    }
  } // namespace

  void
  tell_of_overshoot(const TimeParameters &limits,
                    const double          time,
                    std::ostream         &out)
  {
    if (time > limits.end_time * (1. + 1e-9))
      out << "note: the run ended at t = " << time << " s, "
          << time - limits.end_time
          << " s after End time, as Time/Shorten last step is false\n";
  }

  void
  summarise(std::ostream    &out,
            const Ledger    &ledger,
            const double     largest_energy,
            const Struggles &struggles)
  {
    double smallest = 0., largest = 0.;
    for (unsigned int row = 1; row < ledger.rows().size(); ++row)
      {
        const double dt = ledger.rows()[row][2];
        smallest        = row == 1 ? dt : std::min(smallest, dt);
        largest         = std::max(largest, dt);
      }
    out << "steps " << ledger["step"] << ", t = " << ledger["time"]
        << " s, time step " << smallest << " to " << largest << " s\n"
        << "kinetic + stored energy " << ledger.total_energy()
        << " J, at the start " << ledger.energy_at_start() << " J\n";
    tell_of_residuals(out, ledger, largest_energy);
    out << "balance error " << ledger["balance_error"] << " J";
    if (largest_energy > 0.)
      out << ", " << std::abs(ledger["balance_error"]) / largest_energy
          << " of the largest energy";
    out << '\n';
    const auto &names = ledger.columns();
    for (const auto &[column, matrix] :
         {std::make_pair("mass_condition", "mass matrix"),
          std::make_pair("jacobian_condition", "Jacobian")})
      {
        const auto name =
          std::find(names.begin(), names.end(), column) - names.begin();
        if (name == static_cast<std::ptrdiff_t>(names.size()))
          continue;
        const auto &worst =
          *std::max_element(ledger.rows().begin(),
                            ledger.rows().end(),
                            [name](const auto &a, const auto &b) {
                              return a[name] < b[name];
                            });
        out << "largest condition of the scaled " << matrix << ' '
            << worst[name] << ", at step " << worst[0] << '\n';
      }
    if (struggles.halvings > 0)
      out << "times a step was halved: " << struggles.halvings
          << " (named in run.log)\n";
    if (struggles.damped > 0)
      out << "steps that needed a damped Newton matrix: " << struggles.damped
          << " (named in run.log)\n";
  }
} // namespace emmy
