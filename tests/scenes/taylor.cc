// The Taylor bar, example 7.4 of Pretti et al. (2023), and finer grids, against
// the literature: radius of the foot, length, energies.
//   test_taylor [--set ENTRY=VALUE ...] FILE.prm ...
// runs each file to its end with these entries changed, and prints a row of
// the table in doc/taylor-bar.md and the history. It checks what each run must
// keep: energies, dissipation and ghost losses add up; radius and length are
// those of the literature, within bounds that double where h > 0.81 mm.

#include <chrono>

#include "../scene.h"

using namespace emmy;

namespace
{
  using test::check;
  using test::largest;

  constexpr double initial_radius = 3.2e-3, initial_length = 32.4e-3; // m

  /**
   * Radius and length, mm, over time, s, of the finest mesh of composite
   * tetrahedra in the benchmark data that go with Foulk et al. (2021).
   */
  struct Reference
  {
    double time, radius, length;
  };
  constexpr Reference history[] = {{10e-6, 5.23, 30.14},
                                   {20e-6, 6.21, 28.07},
                                   {30e-6, 6.82, 26.19},
                                   {40e-6, 7.147, 24.56},
                                   {50e-6, 7.237, 23.22},
                                   {60e-6, 7.234, 22.21},
                                   {70e-6, 7.234, 21.59},
                                   {80e-6, 7.233, 21.43}};

  /** Radius of the foot and length, mm, from the largest displacements. */
  struct Measures
  {
    double radius, length;
  };

  class Bar
  {
  public:
    Bar(const SceneParameters<3> &parameters)
      : run(parameters)
      , end_time(parameters.time.end_time)
    {
      std::map<dealii::types::particle_index, dealii::Point<3>> mine;
      for (const auto &particle : run.scene.particles)
        mine[particle.get_id()] = particle.get_location();
      for (const auto &of_rank :
           dealii::Utilities::MPI::all_gather(MPI_COMM_WORLD, mine))
        initial.insert(of_rank.begin(), of_rank.end());
    }

    Measures
    measures() const
    {
      double widest = 0., deepest = 0.;
      for (const auto &particle : run.scene.particles)
        {
          const auto &x = particle.get_location();
          const auto &X = initial.at(particle.get_id());
          widest =
            std::max(widest, std::hypot(x[0], x[2]) - std::hypot(X[0], X[2]));
          deepest = std::max(deepest, X[1] - x[1]);
        }
      widest  = dealii::Utilities::MPI::max(widest, MPI_COMM_WORLD);
      deepest = dealii::Utilities::MPI::max(deepest, MPI_COMM_WORLD);
      return {1e3 * (initial_radius + widest),
              1e3 * (initial_length - deepest)};
    }

    double
    largest_plastic_strain() const
    {
      const unsigned int field  = run.scene.layout["equivalent_plastic_strain"];
      double             result = 0.;
      for (const auto &particle : run.scene.particles)
        result = std::max(result, particle.get_properties()[field]);
      return dealii::Utilities::MPI::max(result, MPI_COMM_WORLD);
    }

    /** @return measures at the times of the reference's history */
    std::vector<Measures>
    advance_to_end()
    {
      std::vector<Measures> result;
      for (const Reference &reference : history)
        if (reference.time <= end_time * (1. + 1e-12))
          {
            Measures before = measures();
            double   time   = run.ledger["time"];
            while (run.ledger["time"] < reference.time * (1. - 1e-12))
              {
                before = measures();
                time   = run.ledger["time"];
                run.advance(1);
              }
            const Measures after = measures();
            const double   part =
              (reference.time - time) / (run.ledger["time"] - time);
            result.push_back(
              {before.radius + part * (after.radius - before.radius),
               before.length + part * (after.length - before.length)});
          }
      return result;
    }

    test::RunningScene<3> run;

  private:
    std::map<dealii::types::particle_index, dealii::Point<3>> initial;
    const double                                              end_time;
  };

  void
  run_bar(const std::string              &file,
          const std::vector<std::string> &settings,
          std::ostream                   &out)
  {
    ParameterFile text(file);
    for (const std::string &setting : settings)
      text.set(setting);
    const SceneParameters<3> parameters{text};
    const auto               start = std::chrono::steady_clock::now();
    Bar                      bar(parameters);
    const auto               measures = bar.advance_to_end();
    const Measures           at_end   = bar.measures();
    const double             seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start)
        .count();

    const auto   &run        = bar.run;
    const Ledger &ledger     = run.ledger;
    const double  initial    = run.column("kinetic_energy")[0];
    const bool    has_ghosts = std::count(ledger.columns().begin(),
                                       ledger.columns().end(),
                                       "ghost_mass_loss");
    const double  lost =
      has_ghosts ? ledger["ghost_mass_loss"] + ledger["ghost_stiffness_loss"]
                  : 0.;
    const double sum = ledger["kinetic_energy"] + ledger["strain_energy"] +
                       ledger["hardening_energy"] +
                       ledger["plastic_dissipation"] + lost;
    const auto dt = run.column("time_step");

    const std::string name = file.substr(file.find_last_of('/') + 1);
    out << std::setprecision(4) << "| " << name << " | "
        << 1e3 * run.scene.grid.cell_size()[0] << " | " << ledger["particles"]
        << " | " << ledger["step"] << " | " << at_end.radius << " | "
        << at_end.length << " | " << bar.largest_plastic_strain() << " | "
        << initial << " | " << std::setprecision(3) << 100. * lost / initial
        << " | " << largest(run.column("balance_error")) / initial << " | "
        << largest(run.column("newton_iterations")) << " | "
        << std::setprecision(4) << seconds << " |\n"
        << std::flush;
    out << "at the end, % of the initial energy:" << std::setprecision(3);
    for (const char *const column : {"kinetic_energy",
                                     "strain_energy",
                                     "hardening_energy",
                                     "plastic_dissipation"})
      out << ' ' << column << ' ' << 100. * ledger[column] / initial;
    out
      << "\n\n| time, µs | radius, mm | reference | length, mm | reference |\n"
         "|---|---|---|---|---|\n";
    for (unsigned int i = 0; i < measures.size(); ++i)
      out << "| " << std::setprecision(4) << 1e6 * history[i].time << " | "
          << measures[i].radius << " | " << history[i].radius << " | "
          << measures[i].length << " | " << history[i].length << " |\n";
    out << "time steps " << *std::min_element(dt.begin() + 1, dt.end())
        << " to " << *std::max_element(dt.begin() + 1, dt.end()) << " s\n\n";

    check(std::abs(sum - initial) <= 1e-11 * initial,
          name +
            ": energies, dissipation and losses add to the initial energy");
    check(largest(run.column("balance_error")) <= 1e-11 * initial,
          name + ": balance error");
    // the paper's grid and finer ones; coarser ones: half as good
    const double factor = run.scene.grid.cell_size()[0] > 0.81e-3 ? 2. : 1.;
    check(lost <= factor * 0.011 * initial, name + ": ghost losses, 1.1 %");
    for (unsigned int i = 0; i < measures.size(); ++i)
      {
        check(std::abs(measures[i].radius / history[i].radius - 1.) <
                factor * 0.06,
              name + ": radius at each time within 6 %");
        check(std::abs(measures[i].length / history[i].length - 1.) <
                factor * 0.01,
              name + ": length at each time within 1 %");
      }
    check(!measures.empty(), name + ": it ends at 10e-6 s or later");
    if (measures.size() == std::size(history))
      check(std::abs(at_end.radius / 7.226 - 1.) < factor * 0.05,
            name + ": radius at the end within 5 % of the literature");
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  std::ostream                             nowhere(nullptr);
  std::ostream                            &out =
    dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0 ? std::cout
                                                                                             : nowhere;
  out << "| scene | h, mm | particles | steps | radius, mm | length, mm | "
         "largest plastic strain | initial energy, J | ghost losses, % | "
         "balance error / initial energy | most Newton iterations | seconds |\n"
         "|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  std::vector<std::string> settings;
  for (int i = 1; i < argc; ++i)
    if (argv[i] == std::string("--set") && i + 1 < argc)
      settings.push_back(argv[++i]);
    else
      run_bar(argv[i], settings, out);
  return test::report();
}
