// A scene is described in a parameter file. This program reads one, runs it
// step by step, looks at what happens, and at the end lets emmy write all that
// the program `emmy` writes. Everything of emmy is in the namespace `emmy`; a
// header is named after what it declares.
#include <emmy/output/ledger.h>
#include <emmy/run/run.h>
#include <emmy/run/scene.h>

#include <cmath>
#include <iomanip>
#include <iostream>

using namespace emmy;

// The height of the centre of mass. Particles are deal.II's; what they carry
// besides a place and an id are fields, and the *layout* says at which property
// a field begins. Each rank has its own particles, so sums go over ranks.
double
centre_height(const Scene<2> &scene)
{
  const unsigned int m    = scene.layout["mass"];
  double             mass = 0., moment = 0.;
  for (const auto &particle : scene.particles)
    {
      const double particle_mass = particle.get_properties()[m];
      mass += particle_mass;
      moment += particle_mass * particle.get_location()[1];
    }
  const MPI_Comm communicator = scene.grid.communicator();
  return dealii::Utilities::MPI::sum(moment, communicator) /
         dealii::Utilities::MPI::sum(mass, communicator);
}

// One line of the table that we print. The ledger's columns are asked for by
// their names, those of ledger.csv.
void
print_line(const Scene<2> &scene, const Ledger &ledger)
{
  std::cout << std::fixed << std::setprecision(4) << std::setw(7)
            << ledger["time"] << std::setw(10) << centre_height(scene)
            << std::setprecision(1) << std::setw(11) << ledger["kinetic_energy"]
            << std::setw(11) << ledger["strain_energy"] << std::setw(11)
            << ledger["load_work"] << std::endl;
}

// The scene by hand. The order is always the same: the file, what it says, the
// scene, the ledger. `ParameterFile` reads text and names wrong lines;
// `SceneParameters` knows which entries there are, and refuses all others.
// `Scene` builds grid, materials, bodies and particles.
double
run_by_hand(const ParameterFile &file)
{
  const SceneParameters<2> parameters(file);
  Scene<2>                 scene(parameters, MPI_COMM_WORLD);

  // The first row of the ledger is the state before the first step.
  Ledger       ledger(scene.initial_report(), 2);
  const double start = centre_height(scene);

  std::cout << "  t, s  height, m kinetic, J  strain, J    work, J\n";
  print_line(scene, ledger);
  double largest_error = 0.;
  while (ledger["time"] < parameters.time.end_time * (1. - 1e-12))
    {
      // A step returns a report; the ledger makes a row of it.
      const StepReport report = scene.advance();
      ledger.add(report);
      if (report.step % 8 == 0)
        print_line(scene, ledger);

      // While the block falls freely, all its energy is kinetic, and the step
      // is exact for a constant acceleration: the mid-point rule integrates
      // parabolas exactly.
      if (ledger["strain_energy"] < 1e-9)
        largest_error =
          std::max(largest_error,
                   std::abs(centre_height(scene) - start +
                            0.5 * 9.81 * std::pow(ledger["time"], 2)));
    }

  // What was put in by gravity and is neither kinetic nor strain energy would
  // be lost. The ledger sums it as *balance_error*.
  const double lost = std::abs(ledger["balance_error"]) / ledger["load_work"];
  std::cout << "free fall is exact: " << (largest_error < 1e-12)
            << "\nno energy is lost: " << (lost < 1e-12) << '\n';
  return std::max(largest_error, lost);
}

// The main program. MPI is deal.II's, with one thread per rank. Errors of emmy
// are exceptions that say where, what and how to mend it; all ranks throw
// together.
int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  try
    {
      const ParameterFile file(argc > 1 ? argv[1] : "step-1.prm");
      const double        wrong = run_by_hand(file);

      // The same scene once more, now by the function that is behind the
      // program `emmy`: it writes ledger, particles, pictures and the report
      // into the folder of `Output/Directory`.
      RunOptions options;
      options.overwrite = true;
      options.is_quiet  = true;
      run<2>(file, options, MPI_COMM_WORLD);
      return wrong < 1e-12 ? 0 : 1;
    }
  catch (const std::exception &error)
    {
      std::cerr << error.what() << std::endl;
      return 1;
    }
}
