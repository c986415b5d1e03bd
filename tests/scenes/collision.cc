// Example 7.2 of Pretti et al. (2023) against the numbers of the paper: the
// collision of two elastic cylinders, to the end. On several ranks: the
// ledger equals that of one rank.

#include "../check.h"
#include "../scene.h"

using namespace emmy;

namespace
{
  using test::at_most;
  using test::check;
  using test::check_close;
  using test::largest;

  /** Steps between which the bodies move apart without touching. */
  template <int dim>
  void
  check_paper(const test::RunningScene<dim> &run)
  {
    const auto kinetic = run.column("kinetic_energy"),
               strain = run.column("strain_energy"), time = run.column("time"),
               dt        = run.column("time_step"),
               newton    = run.column("newton_iterations");
    const double initial = kinetic[0];
    const double momentum =
      run.scene.bodies[0].density * 0.75 * 2. * M_PI * 2. * 2.;

    check(run.ledger["particles"] == 7680, "7680 particles");
    check_close(initial,
                35.26530612244896,
                2e-15 * initial,
                "initial kinetic energy, J");
    std::cout << std::setprecision(17) << "initial kinetic energy " << initial
              << " J\n";

    const auto smallest_dt = *std::min_element(dt.begin() + 1, dt.end()),
               largest_dt  = *std::max_element(dt.begin() + 1, dt.end());
    std::cout << std::setprecision(6) << "time steps " << smallest_dt << " to "
              << largest_dt << " s\n";
    check(smallest_dt > 0.0562 && largest_dt < 0.0655,
          "time steps between 0.0562 and 0.0655 s");

    const auto least =
      std::min_element(kinetic.begin(), kinetic.end()) - kinetic.begin();
    std::cout << "least kinetic energy " << kinetic[least] << " J at step "
              << least << ", t = " << time[least] << " s\n";
    check(least == 45, "least kinetic energy at step 45");
    check_close(time[least], 2.70, 0.005, "time of least kinetic energy, s");

    // separation: the kinetic energy has come back, and stays
    const auto most = std::max_element(kinetic.begin() + least, kinetic.end()) -
                      kinetic.begin();
    std::cout << "kinetic energy regained " << kinetic[most]
              << " J at t = " << time[most] << " s\n";
    check_close(time[most], 4.9, 0.35, "separation near 4.9 s");

    std::vector<double> drift;
    for (unsigned int row = 0; row < kinetic.size(); ++row)
      drift.push_back((kinetic[row] + strain[row] - initial) / initial);
    at_most("|balance error| / initial energy",
            largest(run.column("balance_error")) / initial,
            1e-12);
    at_most("drift of kinetic + strain energy", largest(drift), 1e-11);
    at_most("linear momentum x / (m v)",
            largest(run.column("linear_momentum_x")) / momentum,
            1e-13);
    at_most("linear momentum y / (m v)",
            largest(run.column("linear_momentum_y")) / momentum,
            1e-13);
    auto         spin         = run.column("angular_momentum_z");
    const double initial_spin = spin[0];
    for (double &value : spin)
      value -= initial_spin;
    at_most("drift of angular momentum",
            largest(spin) / std::abs(initial_spin),
            1e-12);

    const auto n_slow = std::count_if(newton.begin(),
                                      newton.end(),
                                      [](const double n) { return n > 4; });
    at_most("steps with more than 4 Newton iterations", n_slow, 3);
    at_most("most Newton iterations", largest(newton), 8);
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
                            "kinetic_energy_grid_old",
                            "active_cells",
                            "active_dofs",
                            "particles",
                            "kinetic_energy",
                            "kinetic_energy_grid_new",
                            "strain_energy",
                            "angular_momentum_z"});
  return test::report();
}
