// Each part of a scene is a class that knows only what its constructor is
// given. The headers below are the parts in the order of their layers; none
// reads a file.
#include <emmy/effects/gravity.h>
#include <emmy/effects/inertia.h>
#include <emmy/effects/internal_force.h>
#include <emmy/effects/starved_nodes.h>
#include <emmy/material/hencky.h>
#include <emmy/output/ledger.h>
#include <emmy/particles/basic_shapes.h>
#include <emmy/particles/gimp.h>
#include <emmy/run/scene.h>
#include <emmy/step/stepper.h>

#include <iomanip>
#include <iostream>

using namespace emmy;

// Parameters are structs with defaults; here we set them, where a file would.
// First the grid with 16 x 12 cells.
struct GridOfBlock : public GridParameters<2>
{
  GridOfBlock()
  {
    lower_corner = dealii::Point<2>(0., 0.);
    upper_corner = dealii::Point<2>(4., 3.);
    cells        = {16, 12};
  }
};

// Its lower side is a smooth floor.
struct Floor : public BoundaryParameters
{
  Floor()
  {
    roller = {"y-min"};
  }
};

struct Times : public TimeParameters
{
  Times()
  {
    end_time  = 1.;
    step_rule = "fixed";
    step_size = 0.0125;
  }
};

// The material. Of the elastic constants one pair is given, `completed` finds
// the others and refuses what cannot be.
Hencky<2>
rubber()
{
  ElasticConstants constants;
  constants.density       = 1000.;
  constants.young_modulus = 1e5;
  constants.poisson_ratio = 0.3;
  return Hencky<2>(constants.completed("rubber"));
}

// The body: a shape, and how many particles a cell gets in each direction.
std::vector<Body<2>>
block(const Material<2> &material)
{
  std::vector<Body<2>> bodies(1);
  bodies[0].name                 = "block";
  bodies[0].material             = 0;
  bodies[0].density              = material.density();
  bodies[0].points_per_direction = 2;
  bodies[0].shape =
    make_box(dealii::Point<2>(1.5, 1.25), dealii::Point<2>(2.5, 2.25));
  bodies[0].initial_velocity =
    std::make_unique<dealii::FunctionParser<2>>("0; 0");
  return bodies;
}

// What acts, in the order of a step. Effects ask the layout for the fields that
// they need on the particles, so the layout is complete only behind them.
Effects<2>
effects(const Material<2> &material, FieldLayout &layout)
{
  Effects<2> result;
  result.material_of_body = {&material};
  result.terms.push_back(std::make_unique<Inertia<2>>(layout["mass"]));
  result.terms.push_back(
    std::make_unique<InternalForce<2>>(result.material_of_body, layout));
  result.terms.push_back(std::make_unique<StarvedNodes<2>>(
    Aggregation<2>(0.02, layout["mass"], layout["reference_volume"])));
  dealii::Tensor<1, 2> g;
  g[1] = -9.81;
  result.terms.push_back(std::make_unique<Gravity<2>>(g, layout["mass"]));
  result.name_new("our own"); // in tables of times
  return result;
}

// The class holds the parts in the order in which one needs the other. Members
// are made in the order of their declaration, so the list below is the program.
class FallingBlock
{
public:
  FallingBlock()
    : phases(MPI_COMM_WORLD)
    , grid(GridOfBlock(), MPI_COMM_WORLD, BackgroundGrid<2>::Cells::none)
    , boundary_conditions(Floor(), grid)
    , material(rubber())
    , bodies(block(material))
    , layout(basic_fields(2))
    , balance(effects(material, layout))
    , shape_functions(layout)
    , domain_update(make_domain_update("stretch", bodies, grid, layout))
    , middle(layout)
    , step_rule(make_step_rule<2>(times, grid, {&material}, layout))
    , travel_limit(times.maximum_travel, grid, boundary_conditions)
    , stepper({grid,
               boundary_conditions,
               layout,
               {shape_functions,
                domain_update.get(),
                mapping,
                *step_rule,
                &travel_limit,
                balance,
                diagnosis,
                &middle,
                1e-8},
               times,
               phases},
              solver,
              state)
  {
    // Cells exist only where they are needed. The bodies choose them; then
    // particles have a place to live in.
    grid.set_fields(balance.velocity_fields());
    grid.cover(occupied_cells(bodies, grid));
    state.particles.initialize(grid.triangulation(),
                               grid.mapping(),
                               layout.n_components());
    fill(bodies, grid, layout, state.particles);
    balance.mark(grid, state.particles);
    middle.begin(layout, state.particles);
  }

  // All steps, and the ledger of them.
  std::vector<Ledger::Row>
  run()
  {
    Ledger ledger(stepper.initial_report(), 2);
    while (ledger["time"] < times.end_time * (1. - 1e-12))
      ledger.add(stepper.advance());
    std::cout << "by hand:     " << ledger.rows().size() - 1
              << " steps, kinetic energy " << std::setprecision(6)
              << ledger["kinetic_energy"] << " J\n";
    return ledger.rows();
  }

private:
  Phases                           phases;
  BackgroundGrid<2>                grid;
  BoundaryConditions<2>            boundary_conditions;
  Hencky<2>                        material;
  std::vector<Body<2>>             bodies;
  FieldLayout                      layout;
  Balance<2>                       balance;
  GimpShapeFunctions<2>            shape_functions;
  std::unique_ptr<DomainUpdate<2>> domain_update;
  MiddlePlaces<2>                  middle;
  PointMapping                     mapping;
  Times                            times;
  std::unique_ptr<StepRule<2>>     step_rule;
  TravelLimit<2>                   travel_limit;
  DiagnosisParameters              diagnosis;
  SolverParameters                 solver;
  RunState<2>                      state;
  Stepper<2>                       stepper;
};

// The same from the file of step-1. It must be the same to the last bit.
std::vector<Ledger::Row>
run_file(const std::string &name)
{
  const SceneParameters<2> parameters{ParameterFile(name)};
  Scene<2>                 scene(parameters, MPI_COMM_WORLD);
  Ledger                   ledger(scene.initial_report(), 2);
  while (ledger["time"] < parameters.time.end_time * (1. - 1e-12))
    ledger.add(scene.advance());
  std::cout << "from a file: " << ledger.rows().size() - 1
            << " steps, kinetic energy " << std::setprecision(6)
            << ledger["kinetic_energy"] << " J\n";
  return ledger.rows();
}

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  try
    {
      const auto from_file =
        run_file(argc > 1 ? argv[1] : "../step-1/step-1.prm");
      const auto by_hand = FallingBlock().run();
      std::cout << "the ledgers are the same to the last bit: "
                << (from_file == by_hand) << '\n';
      return from_file == by_hand ? 0 : 1;
    }
  catch (const std::exception &error)
    {
      std::cerr << error.what() << std::endl;
      return 1;
    }
}
