#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/effects/held_parts.h>
#include <emmy/effects/inertia.h>
#include <emmy/effects/internal_force.h>
#include <emmy/effects/mean_dilatation.h>
#include <emmy/effects/starved_nodes.h>
#include <emmy/effects/wall_mapping.h>
#include <emmy/material/static_stress.h>
#include <emmy/run/scene.h>
#include <emmy/run/scene_effects.h>

#include <algorithm>

namespace emmy
{
  namespace
  {
    template <int dim>
    std::vector<std::string>
    names_of_materials(const SceneParameters<dim>   &parameters,
                       const std::vector<Body<dim>> &bodies)
    {
      std::vector<std::string> names;
      for (const Body<dim> &body : bodies)
        names.push_back(
          material_effect(parameters.material_names.names[body.material]));
      return names;
    }

    /** Throws ExcParameter for another stress rule. */
    template <int dim>
    std::unique_ptr<MeanDilatation<dim>>
    make_mean_dilatation(
      const SceneParameters<dim>               &parameters,
      const std::vector<Body<dim>>             &bodies,
      const std::vector<const Material<dim> *> &material_of_body,
      FieldLayout                              &layout)
    {
      const MethodParameters &method    = parameters.method;
      const bool              is_static = parameters.time.is_static();
      AssertThrow(is_static || method.stress_rule == "conserving",
                  ExcParameter(method.path(),
                               "Locking treatment",
                               method.locking_treatment,
                               "it has the conserving stress only. Remove "
                               "Stress rule = " +
                                 method.stress_rule +
                                 ", or set Locking treatment = none."));
      using Kind = typename MeanDilatationStress<dim>::Kind;
      return std::make_unique<MeanDilatation<dim>>(
        material_of_body,
        layout,
        is_static ? Kind::at_rest : Kind::conserving,
        names_of_materials(parameters, bodies),
        parameters.are_treated(bodies));
    }

    template <int dim>
    void
    add_inertia_and_stress(const SceneParameters<dim>   &parameters,
                           const std::vector<Body<dim>> &bodies,
                           FieldLayout                  &layout,
                           Effects<dim>                 &effects)
    {
      if (!parameters.time.is_static())
        {
          effects.terms.push_back(
            std::make_unique<Inertia<dim>>(layout["mass"]));
          effects.name_new(Inertia<dim>::card().name);
        }
      layout.set_effect(internal_force_effect);
      if (!parameters.locking_materials.empty())
        {
          effects.terms.push_back(make_mean_dilatation(
            parameters, bodies, effects.material_of_body, layout));
          return effects.name_new(internal_force_effect);
        }
      effects.terms.push_back(std::make_unique<InternalForce<dim>>(
        effects.material_of_body,
        layout,
        parameters.time.is_static()
          ? static_stress_rule<dim>()
          : stress_rule<dim>(parameters.method.stress_rule),
        names_of_materials(parameters, bodies)));
      effects.name_new(internal_force_effect);
    }

    /** Without walls there is no choice of what the map does at them. */
    template <int dim>
    bool
    has_wall_mapping(const SceneParameters<dim>    &parameters,
                     const BoundaryConditions<dim> &boundary_conditions)
    {
      return parameters.method.wall_mapping != "constrained" &&
             boundary_conditions.has_walls();
    }

    /** Their motion, and their own map. */
    template <int dim>
    void
    add_walls(const SceneParameters<dim>    &parameters,
              const BoundaryConditions<dim> &boundary_conditions,
              const BackgroundGrid<dim>     &grid,
              Effects<dim>                  &effects)
    {
      if (parameters.moving_walls.are_present())
        {
          auto walls =
            std::make_unique<MovingWalls<dim>>(parameters.moving_walls,
                                               boundary_conditions,
                                               grid);
          walls->check_run(parameters.time.latest_end());
          effects.terms.push_back(std::move(walls));
          effects.name_new(MovingWalls<dim>::card(true).name);
        }
      if (!boundary_conditions.held_parts().empty())
        {
          effects.terms.push_back(
            std::make_unique<HeldParts<dim>>(boundary_conditions));
          effects.name_new(HeldParts<dim>::card(nullptr).name);
        }
      if (parameters.reactions.are_present)
        {
          AssertThrow(boundary_conditions.has_walls(),
                      ExcParameter(parameters.reactions.path(),
                                   "Reactions",
                                   "true",
                                   "no side holds anything. Name one in "
                                   "<Fixed> or <Roller>, or set it to false."));
          effects.terms.push_back(
            std::make_unique<Reactions<dim>>(boundary_conditions));
          effects.name_new(Reactions<dim>::card(nullptr).name);
        }
      if (has_wall_mapping(parameters, boundary_conditions) &&
          !parameters.time.is_explicit())
        {
          const std::string &kind = parameters.method.wall_mapping;
          effects.terms.push_back(std::make_unique<WallMapping<dim>>(kind));
          effects.name_new(WallMapping<dim>::name(kind));
        }
    }

    /** Explicit steps take loads, and nothing that Newton would need. */
    template <int dim>
    void
    require_explicit(const std::string  &effect,
                     const std::string  &entry,
                     const Effects<dim> &effects)
    {
      AssertThrow(std::none_of(effects.terms.begin(),
                               effects.terms.end(),
                               [](const auto &term) {
                                 return term->is_force() || term->coupling();
                               }),
                  ExcParameter("Time",
                               "Integrator",
                               "explicit",
                               "explicit steps have no place for the effect <" +
                                 effect + ">. Remove it from " + entry +
                                 ", or set Integrator = implicit."));
    }

    /** Static steps take loads: other forces know of steps in time. */
    template <int dim>
    void
    require_static(const std::string  &effect,
                   const std::string  &entry,
                   const Effects<dim> &effects)
    {
      AssertThrow(
        std::none_of(effects.terms.begin(),
                     effects.terms.end(),
                     [](const auto &term) {
                       return term->is_force() &&
                              !dynamic_cast<InternalForce<dim> *>(term.get()) &&
                              !dynamic_cast<MeanDilatation<dim> *>(term.get());
                     }),
        ExcParameter("Time",
                     "Integrator",
                     "static",
                     "static steps have no place for the effect <" + effect +
                       ">. Remove it from " + entry +
                       ", or set "
                       "Integrator = implicit."));
    }

    /** Names whose loads are raised must be there. Throws ExcParameter. */
    template <int dim>
    void
    require_raised_loads(const SceneParameters<dim> &parameters)
    {
      const auto &names  = parameters.effect_names.names;
      const auto &raised = parameters.time.raised_loads;
      if (raised == std::vector<std::string>{"none"})
        return; // no effect has that name
      for (const std::string &name : raised)
        {
          const std::string nearest = nearest_name(name, names);
          AssertThrow(std::count(names.begin(), names.end(), name) > 0,
                      ExcParameter("Time",
                                   "Raised loads",
                                   name,
                                   (nearest.empty()
                                      ? std::string()
                                      : "did you mean <" + nearest + ">? ") +
                                     "It must be none, or one of "
                                     "Effects/Names: " +
                                     join(names) + "."));
        }
    }

    /** Explicit steps have a lumped mass and a stress rule of their own. */
    template <int dim>
    void
    make_explicit(const SceneParameters<dim> &parameters,
                  const bool                  maps_walls,
                  PointMapping               &mapping)
    {
      const MethodParameters &method  = parameters.method;
      const auto              require = [](const bool         condition,
                              const std::string &section,
                              const std::string &entry,
                              const std::string &value,
                              const std::string &advice) {
        AssertThrow(condition,
                    ExcParameter(section,
                                 entry,
                                 value,
                                 "with Time/Integrator = explicit " + advice));
      };
      require(mapping.lumping == 0. || mapping.lumping == 1.,
              method.path(),
              "Lumping",
              shortest(mapping.lumping),
              "the mass is always lumped. Remove it, or set it to 1.");
      require(method.stress_rule == "conserving",
              method.path(),
              "Stress rule",
              method.stress_rule,
              "the stress at the start of the step acts, whatever the rule. "
              "Remove it.");
      require(method.locking_treatment == "none",
              method.path(),
              "Locking treatment",
              method.locking_treatment,
              "the stress of a particle is its own. Remove it, or set it to "
              "none.");
      require(method.starved_nodes == "free",
              method.path(),
              "Starved nodes",
              method.starved_nodes,
              "there is no equation that nodes could follow in. Remove it, or "
              "set it to free.");
      require(!maps_walls,
              method.path(),
              "Wall mapping",
              method.wall_mapping,
              "it must be <constrained>.");
      require(!parameters.diagnosis.small_cuts,
              parameters.diagnosis.path(),
              "Small cuts",
              "true",
              "there is no matrix to diagnose. Set it to false.");
      mapping.lumping = 1.;
    }
  } // namespace

  template <int dim>
  std::unique_ptr<ExplicitForce<dim>>
  make_explicit_force(
    const SceneParameters<dim>               &parameters,
    const std::vector<Body<dim>>             &bodies,
    const std::vector<const Material<dim> *> &material_of_body,
    FieldLayout                              &layout)
  {
    if (!parameters.time.is_explicit())
      return nullptr;
    layout.set_effect(internal_force_effect);
    return std::make_unique<ExplicitForce<dim>>(
      material_of_body, layout, names_of_materials(parameters, bodies));
  }

  template <int dim>
  Effects<dim>
  make_effects(const SceneParameters<dim>               &parameters,
               const std::vector<Body<dim>>             &bodies,
               const std::vector<const Material<dim> *> &material_of_body,
               const BoundaryConditions<dim>            &boundary_conditions,
               const BackgroundGrid<dim>                &grid,
               FieldLayout                              &layout)
  {
    const bool   is_explicit = parameters.time.is_explicit();
    Effects<dim> effects;
    effects.material_of_body = material_of_body;
    for (const Body<dim> &body : bodies)
      {
        effects.half_length_of_body.push_back(initial_half_length(body, grid));
        effects.body_names.push_back(body.name);
      }
    if (!is_explicit)
      add_inertia_and_stress(parameters, bodies, layout, effects);
    add_walls(parameters, boundary_conditions, grid, effects);
    if (parameters.method.starved_nodes == "follow" && !is_explicit)
      {
        effects.terms.push_back(
          parameters.method.template make_starved_nodes<dim>(layout));
        effects.name_new(starved_nodes_effect);
      }
    const auto require_steps = [&](const std::string &name,
                                   const std::string &entry) {
      if (is_explicit)
        require_explicit(name, entry, effects);
      if (parameters.time.is_static())
        require_static(name, entry, effects);
    };
    if (parameters.contact_sides.are_present())
      {
        parameters.contact_sides.add_to(grid,
                                        boundary_conditions,
                                        effects,
                                        layout);
        require_steps(contact_sides_effect, "Boundary conditions/Contact");
      }
    for (const std::string &name : parameters.effect_names.names)
      {
        layout.set_effect(name);
        parameters.effects.at(name)->add_to(effects, layout);
        effects.name_new(name);
        require_steps(name, "Effects/Names");
      }
    require_raised_loads(parameters);
    return effects;
  }

  template <int dim>
  PointMapping
  make_mapping(const SceneParameters<dim>    &parameters,
               const BoundaryConditions<dim> &boundary_conditions,
               const Balance<dim>            &balance)
  {
    const MethodParameters &method  = parameters.method;
    PointMapping            mapping = method.make_mapping();
    const bool maps_walls = has_wall_mapping(parameters, boundary_conditions);
    if (parameters.time.is_explicit())
      make_explicit(parameters, maps_walls, mapping);
    AssertThrow(!balance.has(starved_nodes_effect) || !maps_walls,
                ExcParameter(method.path(),
                             "Wall mapping",
                             method.wall_mapping,
                             "with Starved nodes = follow it must be "
                             "<constrained>: the map without walls would "
                             "need followers of its own. Set Starved nodes "
                             "= free, or remove the entry."));
    return mapping;
  }

  template <int dim>
  std::vector<EffectCard>
  wall_cards(const SceneParameters<dim>    &parameters,
             const BoundaryConditions<dim> &boundary_conditions,
             const Balance<dim>            &balance)
  {
    std::vector<EffectCard> cards;
    for (const char *kind : {"inelastic", "unconstrained"})
      cards.push_back(
        WallMapping<dim>::card(kind,
                               balance.has(WallMapping<dim>::name(kind))));
    cards.push_back(
      MovingWalls<dim>::card(balance.has(MovingWalls<dim>::card(true).name)));
    cards.push_back(HeldParts<dim>::card(
      balance.has(HeldParts<dim>::card(nullptr).name) ? &boundary_conditions
                                                      : nullptr));
    cards.push_back(Reactions<dim>::card(
      balance.has(Reactions<dim>::card(nullptr).name) ? &boundary_conditions
                                                      : nullptr));
    cards.push_back(contact_sides_card<dim>(parameters.contact_sides));
    return cards;
  }

#define INSTANTIATE(dim)                                                         \
  template std::unique_ptr<ExplicitForce<dim>> make_explicit_force(              \
    const SceneParameters<dim> &,                                                \
    const std::vector<Body<dim>> &,                                              \
    const std::vector<const Material<dim> *> &,                                  \
    FieldLayout &);                                                              \
  template Effects<dim> make_effects(                                            \
    const SceneParameters<dim> &,                                                \
    const std::vector<Body<dim>> &,                                              \
    const std::vector<const Material<dim> *> &,                                  \
    const BoundaryConditions<dim> &,                                             \
    const BackgroundGrid<dim> &,                                                 \
    FieldLayout &);                                                              \
  template PointMapping            make_mapping(const SceneParameters<dim> &,    \
                                                const BoundaryConditions<dim> &, \
                                                const Balance<dim> &);           \
  template std::vector<EffectCard> wall_cards(const SceneParameters<dim> &,      \
                                              const BoundaryConditions<dim> &,   \
                                              const Balance<dim> &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
