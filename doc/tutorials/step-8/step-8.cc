// The program is started twice, perhaps on different numbers of ranks:
//   mpirun -np 3 step-8 begin step-8.prm
//   mpirun -np 2 step-8 go-on step-8.prm
#include <emmy/output/ledger.h>
#include <emmy/run/checkpoints.h>
#include <emmy/run/saved_run.h>
#include <emmy/run/scene.h>

#include <deal.II/base/conditional_ostream.h>

#include <filesystem>
#include <iomanip>
#include <iostream>

using namespace emmy;

// Output of several ranks is deal.II's affair: one of them speaks.
dealii::ConditionalOStream
screen(const MPI_Comm communicator)
{
  return {std::cout,
          dealii::Utilities::MPI::this_mpi_process(communicator) == 0};
}

// Who has what. The cells of the grid, which exist only near the bodies, are
// distributed over the ranks; particles travel with their cells.
void
print_shares(const Scene<3> &scene)
{
  const MPI_Comm communicator = scene.grid.communicator();
  const auto     out          = screen(communicator);
  const auto     shares =
    dealii::Utilities::MPI::gather(communicator,
                                   scene.particles.n_locally_owned_particles());
  dealii::types::particle_index all = 0;
  for (const auto share : shares)
    all += share;
  const bool is_spread =
    std::all_of(shares.begin(), shares.end(), [](const auto share) {
      return share > 0;
    });
  out << all << " particles on " << shares.size()
      << " ranks, each has some: " << is_spread << std::endl;
}

// Some steps; the energies after them. `advance` is collective: all ranks call
// it, and all get the same report.
void
advance_to(const unsigned int n_steps, Scene<3> &scene, Ledger &ledger)
{
  while (scene.state.step < n_steps)
    ledger.add(scene.advance());
  const auto out = screen(scene.grid.communicator());
  out << "step " << scene.state.step << std::fixed << std::setprecision(4)
      << ": kinetic energy " << ledger["kinetic_energy"] << " J, strain energy "
      << ledger["strain_energy"] << " J" << std::endl;
}

// The first half. A checkpoint has all that the next step needs: the particles
// with their fields, what effects and measurements remember, the sums of the
// ledger, and the parameters. Each rank writes its own part; the folder is
// renamed when all is on the disk, so it is whole or not there.
void
begin(const SceneParameters<3> &parameters, const std::string &folder)
{
  Scene<3> scene(parameters, MPI_COMM_WORLD);
  Ledger   ledger(scene.initial_report(), 3, &scene.state.ledger);
  print_shares(scene);
  advance_to(6, scene, ledger);
  const std::string problem = save(scene,
                                   text_of(parameters),
                                   CheckpointFolder(folder, MPI_COMM_WORLD),
                                   /*n_kept=*/1);
  AssertThrow(problem.empty(), dealii::ExcMessage(problem));
}

// The second half, in another program. The scene is built as ever and tells its
// initial report; then it recalls the state. Particles find their ranks,
// however many there are. At the end all is run again without a break, to
// compare.
bool
go_on(const SceneParameters<3> &parameters, const std::string &folder)
{
  const SavedRun saved = read_saved_run(folder, MPI_COMM_WORLD, "step-8");
  double         kinetic_energy, strain_energy, balance_error;
  {
    Scene<3> scene(parameters, MPI_COMM_WORLD);
    Ledger   ledger(scene.initial_report(), 3, &scene.state.ledger);
    recall(saved, scene);
    print_shares(scene);
    advance_to(12, scene, ledger);
    kinetic_energy = ledger["kinetic_energy"];
    strain_energy  = ledger["strain_energy"];
    balance_error  = ledger["balance_error"];
  }
  Scene<3> scene(parameters, MPI_COMM_WORLD);
  Ledger   ledger(scene.initial_report(), 3, &scene.state.ledger);
  advance_to(12, scene, ledger);

  // On as many ranks as before, all digits are the same. On others sums have
  // another order, and the last digits differ.
  const double scale = ledger.largest_energy();
  const double difference =
    std::abs(kinetic_energy - ledger["kinetic_energy"]) +
    std::abs(strain_energy - ledger["strain_energy"]);
  const bool same     = difference < 1e-10 * scale;
  const bool balances = std::abs(balance_error) < 1e-11 * scale;
  const auto out      = screen(MPI_COMM_WORLD);
  out << "with and without the break the same: " << same
      << "\nand energy balances: " << balances << std::endl;
  return same && balances;
}

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  try
    {
      const std::string        task = argc > 1 ? argv[1] : "begin";
      const SceneParameters<3> parameters{
        ParameterFile(argc > 2 ? argv[2] : "step-8.prm")};
      const std::string folder = parameters.output.directory;
      if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
        std::filesystem::create_directories(folder);
      MPI_Barrier(MPI_COMM_WORLD);
      if (task == "go-on")
        return go_on(parameters, folder) ? 0 : 1;
      begin(parameters, folder);
      return 0;
    }
  catch (const std::exception &error)
    {
      std::cerr << error.what() << std::endl;
      return 1;
    }
}
