// An effect of our own needs one header. The scene and the ledger are for the
// test, the program for everything else.
#include <emmy/effects/effect.h>
#include <emmy/output/ledger.h>
#include <emmy/run/scene.h>
#include <emmy/study/program.h>

#include <cmath>
#include <iostream>

using namespace emmy;

// The force of a stream. A `ForceTerm` is an effect that is a force on the
// unknown of a step, the displacement u, and no more. There is one for both
// dimensions.
template <int dim>
class Stream : public ForceTerm<dim>
{
public:
  Stream(const double rate, const dealii::Tensor<1, dim> &velocity)
    : rate(rate)
    , velocity(velocity)
  {}

  // The force and its derivative. `step` holds what is fixed while the step is
  // solved, `iterate` what Newton tries. The derivative has the constraints
  // worked in, the force has none: `add_mass_to` adds the mass with constraints
  // (and 1e-13 of the lumped mass, for the factorisation).
  std::string
  add(const StepData<dim> &step,
      const Iterate<dim>  &iterate,
      Vector              &force,
      Matrix              *jacobian) const override
  {
    force.add(rate / step.time_step, lag(step, iterate.displacement));
    if (jacobian)
      step.start.add_mass_to(*jacobian, rate / step.time_step);
    return ""; // nothing is wrong on this rank
  }

  // What it does to the energy in an accepted step, this rank's share. The
  // force takes f.u from the body. Of that, alpha (u - w dt).M (u - w dt) / dt
  // is dissipated; the rest is what the stream puts in. Each gets a column.
  std::vector<EnergyEntry>
  energies(const StepData<dim> &step,
           const Vector        &displacement,
           const PointArrays<dim> &) const override
  {
    const Vector momentum = lag(step, displacement);
    Vector       flow     = step.start.active->make_vector();
    set_flow(step, flow);
    auto entries = energy_entries();
    for (const auto i : step.start.active->dofs()) // those of this rank
      {
        const double given = step.time_step * flow(i);
        entries[0].change +=
          rate / step.time_step * momentum(i) * (displacement(i) - given);
        entries[1].change -= rate / step.time_step * momentum(i) * given;
      }
    return entries;
  }

  // The same names in the same order, with no change: the header of the
  // ledger. A kind says on which side of the balance an entry stands.
  std::vector<EnergyEntry>
  energy_entries() const override
  {
    return {{"stream_loss", EnergyEntry::Kind::dissipated, 0.},
            {"stream_work", EnergyEntry::Kind::work, 0.}};
  }

private:
  // The stream's velocity at all nodes: unknowns are ordered node by node, and
  // within a node by component.
  void
  set_flow(const StepData<dim> &step, Vector &flow) const
  {
    for (const auto i : step.start.active->dofs())
      flow(i) = velocity[i % dim];
  }

  // M (u - w dt), with the mass of the point-to-grid map.
  Vector
  lag(const StepData<dim> &step, const Vector &displacement) const
  {
    Vector difference = step.start.active->make_vector();
    set_flow(step, difference);
    difference.sadd(-step.time_step, 1., displacement);
    Vector result = step.start.active->make_vector();
    step.start.mass.vmult(result, difference);
    return result;
  }

  const double                 rate;     // alpha, 1/s
  const dealii::Tensor<1, dim> velocity; // w, m/s
};

// The section `Effects/Stream`. Names, units and patterns are what a user
// sees; a physical constant has no default. `add_to` is called only if the
// scene names the effect. An effect that needs a field on the particles would
// ask the layout for it here, and nobody else would pay.
template <int dim>
class StreamParameters : public EffectParameters<dim>
{
public:
  StreamParameters(const std::string &section)
    : EffectParameters<dim>(section)
  {
    this->add_parameter("Rate",
                        rate,
                        "alpha. Unit: 1/s. Required, positive.",
                        this->prm,
                        dealii::Patterns::Double());
    this->add_parameter("Velocity", velocity, "w. Unit: m/s. Required.");
  }

  void
  add_to(Effects<dim> &effects, FieldLayout &) const override
  {
    AssertThrow(rate > 0.,
                ExcParameter(this->path(),
                             "Rate",
                             shortest(rate),
                             "it is required and must be positive (1/s). A "
                             "velocity halves in about 0.7/rate."));
    AssertThrow(velocity.size() == dim,
                ExcParameter(this->path(),
                             "Velocity",
                             dealii::Patterns::Tools::to_string(velocity),
                             "it is required, one number per direction."));
    dealii::Tensor<1, dim> w;
    for (unsigned int d = 0; d < dim; ++d)
      w[d] = velocity[d];
    effects.terms.push_back(std::make_unique<Stream<dim>>(rate, w));
  }

private:
  double              rate = 0.;
  std::vector<double> velocity;
};

// The line of the library: name, words, maker, and the card, from which
// `--check` says where the effect enters and which columns it brings.
template <int dim>
void
add_line()
{
  EffectCard card;
  card.enters         = "Newton: mass times velocity";
  card.ledger_columns = {"stream_loss", "stream_work"};
  effect_library<dim>().add({"stream",
                             "a stream that drags bodies along",
                             [](const std::string &section) {
                               return std::make_unique<StreamParameters<dim>>(
                                 section);
                             },
                             card});
}

// The test states what must hold. The momentum that the body lacks shrinks in
// each step by (1 - alpha dt/2)/(1 + alpha dt/2), whatever else it does; and
// what is booked closes the balance of energy.
bool
test(const std::string &filename)
{
  const SceneParameters<2> parameters{ParameterFile(filename)};
  Scene<2>                 scene(parameters, MPI_COMM_WORLD);
  const StepReport         initial = scene.initial_report();
  Ledger                   ledger(initial, 2);
  const auto               lack = [&] {
    return initial.totals.mass * 1. - ledger["linear_momentum_x"];
  };
  const double at_start = lack(), energy = ledger.total_energy();
  for (unsigned int i = 0; i < 16; ++i)
    ledger.add(scene.advance());
  const double momentum = lack() / at_start / std::pow(31. / 33., 16) - 1.;
  const double balance =
    (ledger.total_energy() + ledger["stream_loss"] - ledger["stream_work"]) /
      energy -
    1.;
  std::cout << "of what the stream put in, "
            << std::round(1e4 * ledger["stream_loss"] / ledger["stream_work"]) /
                 100.
            << " % is lost\nmomentum as in closed form: "
            << (std::abs(momentum) < 1e-12)
            << "\nbalance of energy: " << (std::abs(balance) < 1e-12) << '\n';
  return std::abs(momentum) < 1e-12 && std::abs(balance) < 1e-12;
}

int
main(int argc, char *argv[])
{
  add_line<2>();
  add_line<3>();
  if (argc == 3 && std::string(argv[1]) == "--test")
    {
      dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
      return test(argv[2]) ? 0 : 1;
    }
  return run_program(argc, argv);
}
