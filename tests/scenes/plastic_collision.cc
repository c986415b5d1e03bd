// Example 7.3A of Pretti et al. (2023) against the numbers of the paper: the
// collision of two elasto-plastic cylinders, to the end. On several ranks: the
// ledger equals that of one rank.

#include "../scene.h"

using namespace emmy;

namespace
{
  using test::at_most;
  using test::check;
  using test::check_close;
  using test::largest;

  void
  check_paper(const test::RunningScene<2> &run)
  {
    const auto kinetic = run.column("kinetic_energy"),
               strain = run.column("strain_energy"), time = run.column("time"),
               dt          = run.column("time_step"),
               dissipation = run.column("plastic_dissipation");
    const double initial   = kinetic[0];

    const auto smallest_dt = *std::min_element(dt.begin() + 1, dt.end()),
               largest_dt  = *std::max_element(dt.begin() + 1, dt.end());
    std::cout << std::setprecision(6) << "time steps " << smallest_dt << " to "
              << largest_dt << " s\n";
    check_close(smallest_dt, 0.0571, 5e-5, "smallest time step, s");
    check_close(largest_dt, 0.0666, 5e-5, "largest time step, s");

    const auto most =
      std::max_element(strain.begin(), strain.end()) - strain.begin();
    std::cout << "largest strain energy " << strain[most] << " J at step "
              << most << ", t = " << time[most] << " s\n";
    check(most == 49, "largest strain energy at step 49");
    check_close(time[most], 2.93, 0.005, "time of largest strain energy, s");

    const auto least =
      std::min_element(kinetic.begin(), kinetic.end()) - kinetic.begin();
    std::cout << "least kinetic energy " << kinetic[least] << " J at step "
              << least << ", t = " << time[least] << " s\n";
    check(least == 51, "least kinetic energy at step 51");
    check_close(kinetic[least], 1.187, 5e-4, "least kinetic energy, J");

    // flow ends, and begins again
    std::vector<double> flow(dissipation.size());
    for (unsigned int row = 1; row < flow.size(); ++row)
      flow[row] = dissipation[row] - dissipation[row - 1];
    const auto pause = std::find(flow.begin() + most, flow.end(), 0.);
    const auto again =
      std::find_if(pause,
                   flow.end(),
                   [](const double joule) { return joule > 0.; }) -
      flow.begin();
    check(again < static_cast<int>(flow.size()), "the cylinders yield again");
    std::cout << "flow again in the step from t = " << time[again - 1]
              << " s\ndissipated " << dissipation.back() << " J\n";
    check_close(time[again - 1], 4.35, 0.005, "time of second yielding, s");
    check(*std::min_element(flow.begin(), flow.end()) >= 0.,
          "dissipation is never negative");

    std::vector<double> drift;
    for (unsigned int row = 0; row < kinetic.size(); ++row)
      drift.push_back(
        (kinetic[row] + strain[row] + dissipation[row] - initial) / initial);
    at_most("|balance error| / initial energy",
            largest(run.column("balance_error")) / initial,
            1e-11);
    at_most("drift of kinetic + strain energy + dissipation",
            largest(drift),
            1e-11);
    at_most("hardening energy / initial energy",
            largest(run.column("hardening_energy")) / initial,
            0.);
    auto         spin         = run.column("angular_momentum_z");
    const double initial_spin = spin[0];
    for (double &value : spin)
      value -= initial_spin;
    at_most("drift of angular momentum",
            largest(spin) / std::abs(initial_spin),
            1e-12);
    at_most("most Newton iterations",
            largest(run.column("newton_iterations")),
            8);
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const auto n_ranks = dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD);

  const SceneParameters<2> parameters{ParameterFile(argv[1])};
  test::RunningScene<2>    one_rank(parameters, MPI_COMM_SELF);
  one_rank.advance_to(parameters.time.end_time);
  if (n_ranks == 1)
    {
      check_paper(one_rank);
      return test::report();
    }

  test::RunningScene<2> all_ranks(parameters, MPI_COMM_WORLD);
  all_ranks.advance_to(parameters.time.end_time);
  test::check_same_ledgers(one_rank,
                           all_ranks,
                           {"time",
                            "time_step",
                            "kinetic_energy",
                            "kinetic_energy_grid_new",
                            "strain_energy",
                            "plastic_dissipation",
                            "angular_momentum_z"});
  return test::report();
}
