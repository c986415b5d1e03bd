// Facts about mass damping: a rigid translation slows down as in closed form,
// what is lost is in the ledger, and Newton has the exact derivative.
// Usage: test_mass_damping damped-block.prm
#include <emmy/output/ledger.h>
#include <emmy/run/scene.h>
#include <emmy/solve/newton.h>
#include <emmy/step/step_equation.h>
#include <emmy/step/velocity_map.h>

#include <cmath>
#include <iostream>

#include "mass_damping.h"

using namespace emmy;

namespace
{
  constexpr double rate = 0.5, dt = 0.125; // as in the scene
  bool             all_is_well = true;

  /** Print a number that must be small; NaN is not. */
  void
  at_most(const double limit, const double value, const std::string &what)
  {
    const bool is_small = std::abs(value) <= limit;
    std::cout << what << ": " << value << " (at most " << limit << ")"
              << (is_small ? "\n" : "  FAILED\n");
    all_is_well = all_is_well && is_small;
  }

  /** The largest change of the energies that should add to a constant. */
  double
  run(Scene<2> &scene, Ledger &ledger, const unsigned int n_steps)
  {
    const auto energy = [&ledger] {
      return ledger.total_energy() + ledger["damping_loss"];
    };
    const double initial = energy();
    double       largest = 0.;
    for (unsigned int i = 0; i < n_steps; ++i)
      {
        ledger.add(scene.stepper->advance());
        largest = std::max(largest, std::abs(energy() / initial - 1.));
      }
    return largest;
  }

  void
  check_rigid_translation(ParameterFile file)
  {
    file.set("Bodies/block/Initial velocity = 0.2; -0.1");
    const SceneParameters<2> parameters(file);
    Scene<2>                 scene(parameters, MPI_COMM_WORLD);
    Ledger                   ledger(scene.stepper->initial_report(), 2);
    at_most(1e-12, run(scene, ledger, 8), "translation, change of energy");

    const double factor = (1. - rate * dt / 2.) / (1. + rate * dt / 2.);
    const dealii::Tensor<1, 2> expected =
      std::pow(factor, 8) * dealii::Point<2>(0.2, -0.1);
    double             error = 0.;
    const unsigned int v     = scene.layout["velocity"];
    for (const auto &particle : scene.particles)
      for (unsigned int d = 0; d < 2; ++d)
        error =
          std::max(error,
                   std::abs(particle.get_properties()[v + d] - expected[d]));
    at_most(1e-13,
            error,
            "translation, error of velocities after 8 steps, m/s");
  }

  void
  check_deforming_block(const ParameterFile &file)
  {
    const SceneParameters<2> parameters(file);
    Scene<2>                 scene(parameters, MPI_COMM_WORLD);
    Ledger                   ledger(scene.stepper->initial_report(), 2);
    const double             momentum = ledger["linear_momentum_x"];
    at_most(1e-12, run(scene, ledger, 16), "block, change of energy");
    at_most(1e-12,
            ledger["linear_momentum_x"] / momentum / std::pow(31. / 33., 16) -
              1.,
            "block, error of linear momentum");
    std::cout << "damping_loss " << ledger["damping_loss"]
              << " J, strain energy " << ledger["strain_energy"] << " J\n";
  }

  /** |r| of one Newton iteration is at most |r|^2 of the one before. */
  void
  check_newton(const ParameterFile &file)
  {
    const SceneParameters<2> parameters(file);
    Scene<2>                 scene(parameters, MPI_COMM_WORLD);
    const auto               stencils =
      scene.shape_functions->evaluate(scene.particles, scene.grid);
    const auto         points = gather(stencils, scene.layout);
    ParticlesToGrid<2> map(scene.grid,
                           scene.boundary_conditions,
                           scene.layout,
                           scene.mapping);
    GridStart<2>      &start = map(stencils, points);
    const auto         solver =
      make_linear_solver(parameters.solver, start.active->n_dofs(), 2);
    const StepData<2> step{stencils, points, start, 0., dt};
    map_velocity(scene.balance, step, *solver, start);

    const auto equation = scene.balance.over(step);
    Vector     u        = start.mean_velocity;
    u *= dt;
    const auto r = Newton(parameters.solver, *solver, scene.phases)
                     .solve(*equation, u)
                     .residual_history;
    unsigned int n_quadratic = 0;
    for (unsigned int k = 1; k + 1 < r.size(); ++k)
      if (const double old = r[k] / equation->system().scale,
          now              = r[k + 1] / equation->system().scale;
          old < 1e-2 && now > 1e-14) // until round-off takes over
        {
          ++n_quadratic;
          at_most(old * old, now, "Newton's next residual");
        }
    all_is_well = all_is_well && n_quadratic > 0;
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  add_mass_damping();
  const ParameterFile file(argv[1]);
  check_rigid_translation(file);
  check_deforming_block(file);
  check_newton(file);
  std::cout << (all_is_well ? "all is well\n" : "FAILED\n");
  return all_is_well ? 0 : 1;
}
