#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/effects/initial_states.h>
#include <emmy/effects/mean_dilatation.h>
#include <emmy/effects/scaled_boxes.h>
#include <emmy/effects/starved_nodes.h>
#include <emmy/effects/table_states.h>
#include <emmy/particles/particle_count.h>
#include <emmy/run/scene.h>
#include <emmy/run/scene_card.h>
#include <emmy/run/scene_effects.h>
#include <emmy/step/explicit_stepper.h>
#include <emmy/step/static_stepper.h>
#include <emmy/step/stepper.h>

#include <algorithm>

namespace emmy
{
  namespace
  {
    /** Ledger column of scenes that begin with a stress: in row 0. */
    constexpr const char *initial_imbalance = "initial_imbalance";
    /** Of the forces: what level ground should not begin with. */
    constexpr double far_from_balance = 0.01;

    template <int dim>
    std::vector<std::unique_ptr<Material<dim>>>
    make_materials(const SceneParameters<dim> &parameters)
    {
      AssertThrow(!parameters.materials.empty(),
                  ExcParameter("Materials",
                               "Names",
                               "",
                               "at least one material is required."));
      std::vector<std::unique_ptr<Material<dim>>> materials;
      for (const auto &material : parameters.materials)
        materials.push_back(material->make_graded());
      return materials;
    }

    template <int dim>
    std::vector<HeldPart<dim>>
    make_held_parts(const SceneParameters<dim> &parameters)
    {
      std::vector<HeldPart<dim>> parts;
      for (const auto &part : parameters.held_parts)
        parts.push_back(part->make());
      return parts;
    }

    template <int dim>
    std::vector<Body<dim>>
    make_bodies(const SceneParameters<dim>                        &parameters,
                const std::vector<std::unique_ptr<Material<dim>>> &materials)
    {
      AssertThrow(
        !parameters.bodies.empty(),
        ExcParameter("Bodies", "Names", "", "at least one body is required."));
      const auto            &names = parameters.material_names.names;
      std::vector<Body<dim>> bodies;
      for (unsigned int b = 0; b < parameters.bodies.size(); ++b)
        {
          const auto &body = *parameters.bodies[b];
          const auto  position =
            std::find(names.begin(), names.end(), body.material);
          const std::string nearest = nearest_name(body.material, names);
          AssertThrow(position != names.end(),
                      ExcParameter(body.path(),
                                   "Material",
                                   body.material,
                                   (nearest.empty()
                                      ? std::string()
                                      : "did you mean <" + nearest + ">? ") +
                                     "It must be one of Materials/Names: " +
                                     join(names) + "."));
          const unsigned int material = position - names.begin();
          bodies.push_back(make_body<dim>(parameters.body_names.names[b],
                                          body,
                                          material,
                                          materials[material]->density()));
        }
      return bodies;
    }

    template <int dim>
    std::vector<const Material<dim> *>
    materials_of(const std::vector<Body<dim>>                      &bodies,
                 const std::vector<std::unique_ptr<Material<dim>>> &materials)
    {
      std::vector<const Material<dim> *> result;
      for (const Body<dim> &body : bodies)
        result.push_back(materials[body.material].get());
      return result;
    }

    template <int dim>
    std::unique_ptr<ShapeFunctions<dim>>
    make_shape_functions(const MethodParameters &method, FieldLayout &layout)
    {
      layout.set_effect(method.shape_functions);
      return shape_function_library<dim>()
        .find(method.shape_functions, method.path(), "Shape functions")
        .make(layout);
    }

    template <int dim>
    std::unique_ptr<DomainUpdate<dim>>
    make_updates(const MethodParameters       &method,
                 const std::vector<Body<dim>> &bodies,
                 const BackgroundGrid<dim>    &grid,
                 FieldLayout                  &layout)
    {
      if (!layout.has("half_length"))
        return nullptr; // particles are points
      for (const Body<dim> &body : bodies)
        AssertThrow(!body.initial_stress || (method.domain_update != "detF" &&
                                             method.domain_update != "corners"),
                    ExcParameter(method.path(),
                                 "Domain update",
                                 method.domain_update,
                                 "it takes the volume of boxes from the strain "
                                 "of the stress, and boxes have theirs when a "
                                 "body with Initial stress begins. Use "
                                 "stretch, diagF or none."));
      layout.set_effect(domain_update_effect);
      auto update =
        make_domain_update(method.domain_update, bodies, grid, layout);
      if (!layout.has(own_volume_field))
        return update;
      return with_mean_dilatation(std::move(update),
                                  method.domain_update,
                                  layout);
    }

    /** What particles carry whatever acts. */
    template <int dim>
    FieldLayout
    make_layout(const SceneParameters<dim> &parameters)
    {
      FieldLayout layout = basic_fields(dim);
      if (parameters.wants_displacement())
        add_start_position(layout);
      return layout;
    }

    /** Null where the grid is undeformed at the start of a step. */
    template <int dim>
    std::unique_ptr<MiddlePlaces<dim>>
    make_middle(const SceneParameters<dim> &parameters, FieldLayout &layout)
    {
      if (!parameters.method.is_at_middle(parameters.time))
        return nullptr;
      layout.set_effect(middle_effect);
      return std::make_unique<MiddlePlaces<dim>>(layout);
    }
  } // namespace

  template <int dim>
  Scene<dim>::Scene(const SceneParameters<dim> &parameters,
                    const MPI_Comm              communicator)
    : phases(communicator)
    , grid(parameters.grid, communicator, BackgroundGrid<dim>::Cells::none)
    , boundary_conditions(parameters.boundary_conditions,
                          grid,
                          make_held_parts(parameters))
    , materials(make_materials(parameters))
    , bodies(make_bodies(parameters, materials))
    , material_of_body(materials_of(bodies, materials))
    , layout(make_layout(parameters))
    , explicit_force(
        make_explicit_force(parameters, bodies, material_of_body, layout))
    , balance(make_effects(parameters,
                           bodies,
                           material_of_body,
                           boundary_conditions,
                           grid,
                           layout))
    , shape_functions(make_shape_functions<dim>(parameters.method, layout))
    , domain_update(make_updates(parameters.method, bodies, grid, layout))
    , middle(make_middle<dim>(parameters, layout))
    , mapping(make_mapping(parameters, boundary_conditions, balance))
    , step_rule(make_step_rule(parameters.time, grid, material_of_body, layout))
    , travel_limit(parameters.time.maximum_travel > 0.
                     ? std::make_unique<const TravelLimit<dim>>(
                         parameters.time.maximum_travel,
                         grid,
                         boundary_conditions)
                     : nullptr)
    , stepper(make_stepper(parameters))
    , rank_balance(parameters.ranks, parameters.time, grid, phases)
    , parameters(parameters)
  {
    const auto scope = phases.scope("setup");
    grid.set_fields(balance.velocity_fields());
    fill_with_particles();
    for (const std::string &note : balance.mark(grid, particles))
      notes.push_back(note);
    if (middle)
      middle->begin(layout, particles);
    if (layout.has(start_position_field))
      set_start_position<dim>(layout, particles);
    // names that are not there are refused before the run
    written_fields =
      ParticleFields<dim>(layout).find(parameters.output.particle_fields,
                                       "Output",
                                       "Particle fields");
    drawn_number =
      ParticleFields<dim>(layout).number(parameters.output.picture_field,
                                         "Output",
                                         "Picture field");
    for (const auto &measurement : parameters.measurements)
      measurements.push_back(
        measurement->make({bodies, grid, layout, particles}));
    state.told.crossed_cells = parameters.method.shape_functions != "linear";
    if (!state.told.crossed_cells)
      state.occupancy_at_start = occupancy();
  }

  template <int dim>
  void
  Scene<dim>::fill_with_particles()
  {
    if (!parameters.start.from.empty())
      {
        started = start_from(parameters.start,
                             bodies,
                             parameters.effect_names.names,
                             layout,
                             grid,
                             particles);
        notes   = started.notes;
        if (started.lacks_cell_states)
          set_cell_states(material_of_body, layout, particles);
        return;
      }
    refuse_too_many(bodies, grid, layout);
    grid.cover(occupied_cells(bodies, grid));
    particles.initialize(grid.triangulation(),
                         grid.mapping(),
                         layout.n_components());
    const FilledRows filled = fill(bodies, grid, layout, particles);
    set_initial_states(
      bodies, material_of_body, layout, grid.communicator(), particles);
    notes = set_table_states(
      bodies, material_of_body, layout, filled, grid.communicator(), particles);
  }

  template <int dim>
  StepReport
  Scene<dim>::initial_report()
  {
    StepReport report = stepper->initial_report();
    for (EnergyEntry &entry : report.energies)
      if (const auto energy = started.stored.find(entry.name);
          energy != started.stored.end() &&
          entry.kind == EnergyEntry::Kind::stored)
        {
          entry.change = energy->second;
          state.detector.stored_energy += entry.change;
          state.detector.largest_stored += entry.change;
        }
    add_initial_stress(report);
    measure(report);
    return report;
  }

  template <int dim>
  bool
  Scene<dim>::has_initial_stress() const
  {
    // a run that starts from another one has that run's stress
    return parameters.start.from.empty() &&
           std::any_of(bodies.begin(), bodies.end(), [](const auto &body) {
             return body.initial_stress != nullptr || has_table_state(body);
           });
  }

  template <int dim>
  void
  Scene<dim>::add_initial_stress(StepReport &report)
  {
    const auto &time = parameters.time;
    if (time.is_static() && time.raised_loads.empty() &&
        !parameters.effect_names.names.empty() &&
        (has_initial_stress() || !parameters.start.from.empty()))
      notes.push_back(
        "bodies begin with a stress, and all loads are raised from zero, those "
        "too that it balances. Remedy: Time/Raised loads = those that are new, "
        "or none");
    if (!has_initial_stress())
      return;
    const double imbalance = stepper->imbalance();
    double       stored    = 0.;
    for (EnergyEntry &entry : report.energies)
      if (entry.name == "strain_energy" || entry.name == "hardening_energy")
        {
          entry.change = total_energy(entry.name + "_density",
                                      layout,
                                      grid.communicator(),
                                      particles);
          stored += entry.change;
          state.detector.stored_energy += entry.change;
          state.detector.largest_stored += entry.change;
        }
    report.measures.push_back({initial_imbalance, imbalance});
    notes.push_back("initial stress: " + brief(stored) +
                    " J stored; out of balance with loads and sides by " +
                    brief(imbalance) + " of the forces");
    if (imbalance > far_from_balance)
      notes.push_back(
        "so ground that should be at rest begins to move. Is its Unit weight, "
        "in N/m^3, its Density times the acceleration that acts at the start, and "
        "do sides hold it? Ground that is not level comes to rest in static "
        "steps");
  }

  template <int dim>
  StepReport
  Scene<dim>::advance()
  {
    const std::string handed_over = rank_balance.before_step(state);
    StepReport        report      = stepper->advance();
    if (!handed_over.empty())
      report.findings.insert(report.findings.begin(), handed_over);
    if (!state.told.crossed_cells && occupancy() != state.occupancy_at_start)
      {
        state.told.crossed_cells = true;
        report.notes.push_back(
          step_name(report.step, report.time - report.time_step) +
          ": particles have crossed cells. Linear functions jump there: "
          "strained bodies get errors that finer grids and more steps make "
          "larger. Remedy: Method/Shape functions = GIMP");
      }
    if (report.step == 1 && parameters.method.least_threshold > 0. &&
        !balance.has(starved_nodes_effect))
      report.notes.push_back(
        "nodes that few particles reach are free, and bodies are pushed at "
        "their edges: these may fold or tear off, and Newton may find no end. "
        "Remedy: Method/Starved nodes = follow");
    if (has_initial_stress())
      report.measures.push_back({initial_imbalance, 0.});
    measure(report);
    return report;
  }

  template <int dim>
  std::uint64_t
  Scene<dim>::occupancy() const
  {
    std::uint64_t sum = 0;
    for (auto particle = particles.begin(); particle != particles.end();)
      {
        const auto    cell  = particle->get_surrounding_cell();
        std::uint64_t place = 0;
        for (const auto i : grid.key_of(cell))
          place = place * 0x9e3779b97f4a7c15 + i + 1;
        for (; particle != particles.end() &&
               particle->get_surrounding_cell() == cell;
             ++particle)
          sum += (particle->get_id() + 1) * place;
      }
    return dealii::Utilities::MPI::sum(sum, grid.communicator());
  }

  template <int dim>
  void
  Scene<dim>::measure(StepReport &report)
  {
    if (measurements.empty())
      return;
    const auto timed = phases.scope("measurements");
    for (const auto &measurement : measurements)
      {
        const auto timed = phases.effect(measurement->card().name);
        for (const StepMeasure &value : measurement->measure(particles))
          report.measures.push_back(value);
      }
  }

  template <int dim>
  std::unique_ptr<TimeIntegrator<dim>>
  Scene<dim>::make_stepper(const SceneParameters<dim> &parameters)
  {
    const StepMethod<dim>  method{*shape_functions,
                                 domain_update.get(),
                                 mapping,
                                 *step_rule,
                                 travel_limit.get(),
                                 balance,
                                 parameters.diagnosis,
                                 middle.get(),
                                 parameters.method.geometry_tolerance};
    const StepSetting<dim> setting{
      grid, boundary_conditions, layout, method, parameters.time, phases};
    if (explicit_force)
      return std::make_unique<ExplicitStepper<dim>>(setting,
                                                    *explicit_force,
                                                    state);
    if (parameters.time.is_static())
      return std::make_unique<StaticStepper<dim>>(setting,
                                                  parameters.solver,
                                                  state);
    return std::make_unique<Stepper<dim>>(setting, parameters.solver, state);
  }

  template class Scene<2>;
  template class Scene<3>;
} // namespace emmy
