// A measurement adds columns to the ledger. Then there is the ledger, with
// which we work afterwards, and what all pictures of emmy share.
#include <emmy/output/gnuplot.h>
#include <emmy/output/ledger.h>
#include <emmy/output/measurement.h>
#include <emmy/run/scene.h>

#include <fstream>
#include <iomanip>
#include <iostream>

using namespace emmy;

// The measurement. It sees the particles as they are at the end of a step, and
// returns numbers with their columns. It may not change anything. In plane
// strain the angular momentum about the centre, and the moment of inertia, are
// numbers.
class PartsOfKineticEnergy : public Measurement<2>
{
public:
  PartsOfKineticEnergy(const unsigned int body,
                       const FieldLayout &layout,
                       const MPI_Comm     communicator,
                       const EffectCard  &card)
    : body(body)
    , body_component(layout["body"])
    , mass_component(layout["mass"])
    , velocity_component(layout["velocity"])
    , communicator(communicator)
    , own_card(card)
  {}

  // One pass over the particles of this rank, one sum over the ranks. With
  // sums of m, m x, m v, m x.x, m v.v and m x cross v all else follows.
  std::vector<StepMeasure>
  measure(const dealii::Particles::ParticleHandler<2> &particles) const override
  {
    std::vector<double> sums(8);
    for (const auto &particle : particles)
      {
        const auto values = particle.get_properties();
        if (values[body_component] != body)
          continue;
        const double           m = values[mass_component];
        const dealii::Point<2> x = particle.get_location();
        const dealii::Point<2> v(values[velocity_component],
                                 values[velocity_component + 1]);
        const double           of_particle[8] = {m,
                                                 m * x[0],
                                                 m * x[1],
                                                 m * v[0],
                                                 m * v[1],
                                                 m * x.square(),
                                                 m * v.square(),
                                                 m * (x[0] * v[1] - x[1] * v[0])};
        for (unsigned int i = 0; i < 8; ++i)
          sums[i] += of_particle[i];
      }
    dealii::Utilities::MPI::sum(sums, communicator, sums);
    const auto [m, mx, my, px, py, xx, vv, l] = std::array<double, 8>{
      {sums[0], sums[1], sums[2], sums[3], sums[4], sums[5], sums[6], sums[7]}};

    // König: the energy of the centre, of the rotation about it, and the rest.
    const double flight  = 0.5 * (px * px + py * py) / m;
    const double inertia = xx - (mx * mx + my * my) / m;
    const double spin    = l - (mx * py - my * px) / m;
    const double turning = 0.5 * spin * spin / inertia;
    return {{own_card.ledger_columns[0], flight},
            {own_card.ledger_columns[1], turning},
            {own_card.ledger_columns[2], 0.5 * vv - flight - turning}};
  }

  const EffectCard &
  card() const override
  {
    return own_card;
  }

private:
  const unsigned int body, body_component, mass_component, velocity_component;
  const MPI_Comm     communicator;
  const EffectCard   own_card;
};

// Its section in the parameter file. `Type` and `Body` are there already. Where
// nothing else is asked for, only `make` is missing.
class PartsParameters : public MeasurementParameters<2>
{
public:
  using MeasurementParameters<2>::MeasurementParameters;

  std::unique_ptr<Measurement<2>>
  make(const FilledBodies<2> &filled) const override
  {
    return std::make_unique<PartsOfKineticEnergy>(
      body_index(filled.bodies),
      filled.layout,
      filled.grid.communicator(),
      make_card("the parts of the kinetic energy",
                {"flight", "turning", "stretching"}));
  }
};

// All values of a column.
std::vector<double>
column(const Ledger &ledger, const std::string &name)
{
  const auto &names = ledger.columns();
  const auto  i = std::find(names.begin(), names.end(), name) - names.begin();
  std::vector<double> values;
  for (const auto &row : ledger.rows())
    values.push_back(row[i]);
  return values;
}

// When the strain energy passes its mean upwards, on straight lines between
// steps; the mean time from one such passage to the next.
double
period(const std::vector<double> &times, const std::vector<double> &energies)
{
  double mean = 0.;
  for (const double energy : energies)
    mean += energy / energies.size();
  std::vector<double> passages;
  for (unsigned int i = 1; i < times.size(); ++i)
    if (energies[i - 1] < mean && energies[i] >= mean)
      passages.push_back(times[i - 1] + (times[i] - times[i - 1]) *
                                          (mean - energies[i - 1]) /
                                          (energies[i] - energies[i - 1]));
  return (passages.back() - passages.front()) / (passages.size() - 1);
}

// The picture: a gnuplot script that has its data in it.
void
draw(const Ledger &ledger)
{
  std::ofstream script("step-5.gp");
  gnuplot::write_preamble(script, "step-5", {1200., 750., 24.});
  script << "set xlabel 't, s'\nset ylabel 'J'\nset key outside\n$d << EOD\n";
  const auto t = column(ledger, "time");
  for (unsigned int i = 0; i < t.size(); ++i)
    {
      script << t[i];
      for (const char *name : {"flight", "turning", "stretching"})
        script << ' ' << column(ledger, std::string("motion_") + name)[i];
      script << ' ' << column(ledger, "strain_energy")[i] << '\n';
    }
  script << "EOD\nplot for [i=2:5] $d using 1:i with lines lw 3 title "
            "word('flight turning stretching strain', i-1)\n";
  script.close();
  gnuplot::run(".", "step-5");
}

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  try
    {
      measurement_library<2>().add(
        {"parts of kinetic energy",
         "energy of flight, of rotation, and the rest",
         [](const std::string &section) {
           return std::make_unique<PartsParameters>(section);
         }});
      const SceneParameters<2> parameters{
        ParameterFile(argc > 1 ? argv[1] : "step-5.prm")};
      Scene<2> scene(parameters, MPI_COMM_WORLD);
      Ledger   ledger(scene.initial_report(), 2);
      for (unsigned int i = 0; i < 80; ++i)
        ledger.add(scene.advance());

      double worst = 0., drift = 0.;
      for (const auto &parts : {column(ledger, "motion_flight")})
        for (const double flight : parts)
          drift = std::max(drift, std::abs(flight / parts[0] - 1.));
      worst = std::abs(ledger["motion_flight"] + ledger["motion_turning"] +
                       ledger["motion_stretching"] - ledger["kinetic_energy"]);
      std::cout << std::fixed << std::setprecision(3)
                << "period of the strain energy: "
                << period(column(ledger, "time"),
                          column(ledger, "strain_energy"))
                << " s\nat the end: flight " << ledger["motion_flight"]
                << " J, turning " << ledger["motion_turning"]
                << " J, stretching " << ledger["motion_stretching"]
                << " J\nthe flight keeps its energy: " << (drift < 1e-10)
                << "\nthe parts add up: " << (worst < 1e-12) << '\n';
      draw(ledger);
      return drift < 1e-10 && worst < 1e-12 ? 0 : 1;
    }
  catch (const std::exception &error)
    {
      std::cerr << error.what() << std::endl;
      return 1;
    }
}
