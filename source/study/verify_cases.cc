#include <emmy/study/verify.h>

#include <algorithm>
#include <cmath>

namespace emmy
{
  namespace
  {
    using Column = std::vector<double>;

    const std::string paper = "Pretti et al. 2023, ";
    const std::string law   = "conservation law";

    double
    largest(const Column &values)
    {
      double result = 0.;
      for (const double value : values)
        if (!(std::abs(value) <= result)) // NaN too
          result = std::abs(value);
      return result;
    }

    /** The largest kinetic plus stored energy, J, or what was put in. */
    double
    scale(const LedgerColumns &ledger)
    {
      double result = largest(ledger.at("kinetic_energy"));
      for (const char *const name : {"strain_energy", "load_work"})
        if (const auto found = ledger.find(name); found != ledger.end())
          result = std::max(result, largest(found->second));
      return result;
    }

    Claim
    balance(const double allowed)
    {
      return {"balance error / energy", 0., allowed, law, [](const auto &run) {
                return largest(run.at("balance_error")) / scale(run);
              }};
    }

    /** How far a column goes from where it began, over a scale. */
    Claim
    stays(const std::string &what,
          const std::string &name,
          const double       over,
          const double       allowed)
    {
      return {what, 0., allowed, law, [name, over](const auto &run) {
                Column values = run.at(name);
                for (double &value : values)
                  value -= run.at(name)[0];
                return largest(values) / over;
              }};
    }

    std::size_t
    place_of_least(const Column &values)
    {
      return std::min_element(values.begin(), values.end()) - values.begin();
    }

    std::size_t
    place_of_most(const Column &values)
    {
      return std::max_element(values.begin(), values.end()) - values.begin();
    }

    /** The number of a row that is larger than both beside it. */
    std::size_t
    maximum(const Column &values, std::size_t first, unsigned int which)
    {
      for (; first + 1 < values.size(); ++first)
        if (values[first] > values[first - 1] &&
            values[first] > values[first + 1] && which-- == 0)
          return first;
      return 0;
    }

    Claim
    time_of_least_kinetic_energy(const double       time,
                                 const double       allowed,
                                 const std::string &source)
    {
      return {"least kinetic energy at t, s",
              time,
              allowed,
              source,
              [](const auto &run) {
                return run.at("time")[place_of_least(run.at("kinetic_energy"))];
              }};
    }

    Claim
    time_of_most_strain_energy(const double       time,
                               const double       allowed,
                               const std::string &source)
    {
      return {"largest strain energy at t, s",
              time,
              allowed,
              source,
              [](const auto &run) {
                return run.at("time")[place_of_most(run.at("strain_energy"))];
              }};
    }

    Claim
    largest_step(const double       step,
                 const double       allowed,
                 const std::string &source)
    {
      return {"largest time step, s",
              step,
              allowed,
              source,
              [](const auto &run) { return largest(run.at("time_step")); }};
    }

    Claim
    last_value(const std::string &what,
               const std::string &column,
               const double       reference,
               const double       allowed,
               const std::string &source)
    {
      return {what, reference, allowed, source, [column](const auto &run) {
                return run.at(column).back();
              }};
    }

    /** Energy after the load is gone stays; it is what the load put in. */
    Claim
    energy_after_load(const double allowed)
    {
      return {"energy once the load is gone, its drift",
              0.,
              allowed,
              law,
              [](const auto &run) {
                double drift = 0.;
                for (std::size_t i = 0; i < run.at("time").size(); ++i)
                  if (run.at("time")[i] > 26.)
                    drift = std::max(drift,
                                     std::abs((run.at("kinetic_energy")[i] +
                                               run.at("strain_energy")[i]) /
                                                run.at("load_work").back() -
                                              1.));
                return drift;
              }};
    }

    Claim
    phase_mark(const std::string &what,
               const std::string &column,
               const unsigned int which,
               const double       time)
    {
      return {what + " at t, s",
              time,
              0.63,
              paper + "7.1A, to one step",
              [column, which](const auto &run) {
                return run.at("time")[maximum(run.at(column), 40, which)];
              }};
    }

    std::vector<VerificationCase>
    beams()
    {
      return {
        {"paper/7.1a",
         {},
         {"Time/End time=60"},
         {largest_step(0.6264, 5e-5, paper + "7.1A"),
          phase_mark("largest strain energy", "strain_energy", 0, 29.44),
          phase_mark("largest kinetic energy", "kinetic_energy", 0, 42.59),
          phase_mark("largest strain energy again", "strain_energy", 1, 55.12),
          energy_after_load(1e-8),
          balance(1e-11)},
         {},
         true},
        {"paper/7.1b",
         {},
         {"Time/End time=32"},
         {largest_step(0.2914, 5e-5, "15 times eq. 57 of the paper"),
          energy_after_load(1e-6),
          balance(1e-11)},
         {},
         true}};
    }

    std::vector<VerificationCase>
    cylinders()
    {
      constexpr double momentum = 5. * 0.75 * 4. * 3.141592653589793; // kg m/s
      return {
        {"paper/7.2",
         {},
         {},
         {{"kinetic energy at the start, J",
           35.26530612244896,
           1e-13,
           paper + "7.2",
           [](const auto &run) { return run.at("kinetic_energy")[0]; }},
          time_of_least_kinetic_energy(2.7, 0.06, paper + "7.2, to one step"),
          {"kinetic energy is back at t, s",
           4.9,
           0.35,
           paper + "7.2, read from a figure",
           [](const auto &run) {
             const auto &energy = run.at("kinetic_energy");
             const auto  least  = place_of_least(energy);
             return run.at(
               "time")[std::max_element(energy.begin() + least, energy.end()) -
                       energy.begin()];
           }},
          {"kinetic + strain energy, drift",
           0.,
           1e-11,
           law,
           [](const auto &run) {
             double drift = 0.;
             for (std::size_t i = 0; i < run.at("time").size(); ++i)
               drift = std::max(drift,
                                std::abs((run.at("kinetic_energy")[i] +
                                          run.at("strain_energy")[i]) /
                                           run.at("kinetic_energy")[0] -
                                         1.));
             return drift;
           }},
          balance(1e-12),
          stays(
            "linear momentum x / (m v)", "linear_momentum_x", momentum, 1e-13),
          stays(
            "linear momentum y / (m v)", "linear_momentum_y", momentum, 1e-13),
          stays("angular momentum / (m v r)",
                "angular_momentum_z",
                2. * momentum,
                1e-12)},
         {},
         true},
        {"paper/7.3a",
         {},
         {"Time/End time=5"},
         {largest_step(0.0666, 5e-5, paper + "7.3A"),
          time_of_most_strain_energy(2.93, 0.06, paper + "7.3A, to one step"),
          {"least gain of plastic dissipation in a step, J",
           0.,
           0.,
           "second law",
           [](const auto &run) {
             const auto &sum  = run.at("plastic_dissipation");
             double      loss = 0.;
             for (std::size_t i = 1; i < sum.size(); ++i)
               loss = std::max(loss, sum[i - 1] - sum[i]);
             return loss;
           }},
          balance(1e-11),
          stays(
            "linear momentum x / (m v)", "linear_momentum_x", momentum, 1e-13)},
         {},
         true},
        {"paper/7.3b",
         {},
         {"Time/End time=4.2"},
         {largest_step(0.06023, 1e-5, "the rule of the paper, eq. 61"),
          time_of_most_strain_energy(3.73, 0.06, "emmy's own, to one step"),
          balance(1e-11),
          stays(
            "linear momentum x / (m v)", "linear_momentum_x", momentum, 1e-13)},
         {},
         true}};
    }

    /** A quantity of each row between the rows around a time. */
    double
    at_time(const LedgerColumns                              &run,
            const double                                      time,
            const std::function<double(const std::size_t i)> &quantity)
    {
      const auto &times = run.at("time");
      std::size_t i     = 1;
      while (i + 1 < times.size() && times[i] < time)
        ++i;
      const double part = (time - times[i - 1]) / (times[i] - times[i - 1]);
      return quantity(i - 1) + part * (quantity(i) - quantity(i - 1));
    }

    /** From the outward path of outer particles, as doc/taylor-bar.md has it.
     */
    Claim
    foot_radius(const double time, const double reference)
    {
      return {"radius of the foot at t = " + std::to_string(int(1e6 * time)) +
                " us, mm",
              reference,
              0.05 * reference,
              "Foulk et al. 2021, 0.19 mm; 5 % on this grid",
              [time](const auto &run) {
                return at_time(run, time, [&](const std::size_t i) {
                  double most = 0.;
                  for (const std::string place : {"edge", "diagonal"})
                    {
                      const auto &x = run.at(place + "_x"),
                                 &z = run.at(place + "_z");
                      most          = std::max(most,
                                      std::hypot(x[i], z[i]) -
                                        std::hypot(x[0], z[0]));
                    }
                  return 3.2 + 1e3 * most;
                });
              }};
    }

    Claim
    bar_length(const double time, const double reference)
    {
      return {"length at t = " + std::to_string(int(1e6 * time)) + " us, mm",
              reference,
              0.02 * reference,
              "Foulk et al. 2021, 0.19 mm; 2 % on this grid",
              [time](const auto &run) {
                return at_time(run, time, [&](const std::size_t i) {
                  const auto &y = run.at("end_y");
                  return 32.4 + 1e3 * (y[i] - y[0]);
                });
              }};
    }

    VerificationCase
    taylor_bar()
    {
      return {"paper/7.4",
              {"Measurements/Names=edge, diagonal, end",
               "Measurements/edge/Type=particle",
               "Measurements/edge/Nearest to=3.2e-3, 0, 0",
               "Measurements/diagonal/Type=particle",
               "Measurements/diagonal/Nearest to=2.26e-3, 0, 2.26e-3",
               "Measurements/end/Type=particle",
               "Measurements/end/Nearest to=0, 32.4e-3, 0"},
              {"Time/End time=20e-6"},
              {{"kinetic energy at the start, J",
                59.95,
                0.04 * 59.95,
                "of a round section; 4 % by the boxes",
                [](const auto &run) { return run.at("kinetic_energy")[0]; }},
               foot_radius(20e-6, 6.21),
               bar_length(20e-6, 28.07),
               balance(1e-11)},
              {foot_radius(80e-6, 7.233), bar_length(80e-6, 21.43)},
              true};
    }

    std::vector<VerificationCase>
    exact_solutions()
    {
      const std::string made = "motion in closed form, ";
      return {
        {"validation/vibration",
         {},
         {},
         {last_value("displacement error, m",
                     "displacement_error",
                     0.,
                     2e-4,
                     made + "amplitude 0.1 m"),
          balance(1e-11)},
         {},
         true},
        {"validation/vortex",
         {},
         {},
         {last_value("displacement error, m",
                     "displacement_error",
                     0.,
                     4e-3,
                     made + "amplitude 0.2 m"),
          balance(1e-11)},
         {},
         true},
        {"validation/steel-bar",
         {},
         {"Time/End time=5e-4"},
         {{"first quarter of a period, s",
           1. / 4. / 1266.,
           0.01 / 4. / 1266.,
           "wave equation, c/(4 L) = 1266 Hz",
           // all energy is strain energy then: between steps by a parabola
           [](const auto &run) {
             const auto &e = run.at("kinetic_energy"), &t = run.at("time");
             const std::size_t i =
               place_of_least(Column(e.begin(), e.begin() + e.size() * 2 / 3));
             const double curve = e[i - 1] - 2. * e[i] + e[i + 1];
             return t[i] +
                    0.5 * (t[i + 1] - t[i]) * (e[i - 1] - e[i + 1]) / curve;
           }},
          balance(1e-12)},
         {},
         true},
        {"field/slope",
         {},
         {"Time/End time=0.5"},
         {{"momentum x / (m g sin(30) t)",
           1.,
           1e-11,
           "sliding without friction",
           [](const auto &run) {
             return run.at("linear_momentum_x").back() /
                    (1000. * 4.905 * run.at("time").back());
           }}},
         {},
         true},
        {"ground/column",
         {},
         {},
         {{"settlement of the top, m",
           1.013,
           0.01 * 1.013,
           "M ln(l) = -rho g (H - X) l, integrated",
           [](const auto &run) {
             return run.at("top_y").front() - run.at("top_y").back();
           }}},
         {},
         true},
        {"ground/biaxial",
         {},
         {},
         {last_value("vertical stress, Pa",
                     "block_cauchy_stress_yy",
                     -34.5e3,
                     0.01 * 34.5e3,
                     "2 c cos(phi)/(1 - sin(phi))")},
         {},
         true},
        {"field/hanging-bar",
         {},
         {},
         {{"largest drop of the tip, m",
           0.191,
           0.02 * 0.191,
           "1D finite elements, 200 cells",
           [](const auto &run) {
             const auto &tip = run.at("tip_y");
             return tip[0] - *std::min_element(tip.begin(), tip.end());
           }}},
         {},
         true},
        {"validation/two-balls",
         {},
         {"Time/End time=1"},
         {balance(1e-12)},
         {},
         true}};
    }
  } // namespace

  std::vector<VerificationCase>
  verification_cases()
  {
    std::vector<VerificationCase> cases = beams();
    for (const auto &more : {cylinders(),
                             std::vector<VerificationCase>{taylor_bar()},
                             exact_solutions()})
      cases.insert(cases.end(), more.begin(), more.end());
    return cases;
  }
} // namespace emmy
