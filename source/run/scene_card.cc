#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/effects/inertia.h>
#include <emmy/effects/internal_force.h>
#include <emmy/effects/mean_dilatation.h>
#include <emmy/effects/starved_nodes.h>
#include <emmy/run/scene_card.h>
#include <emmy/run/scene_effects.h>
#include <emmy/step/explicit_stepper.h>
#include <emmy/step/static_stepper.h>

#include <algorithm>
#include <iomanip>
#include <numeric>
#include <ostream>

namespace emmy
{
  namespace
  {
    bool
    contains(const std::vector<std::string> &names, const std::string &name)
    {
      return std::find(names.begin(), names.end(), name) != names.end();
    }

    /** Collects the effects of a scene and counts what they cost. */
    template <int dim>
    class Counter
    {
    public:
      Counter(const Scene<dim>           &scene,
              const SceneParameters<dim> &parameters,
              const bool                  with_absent)
        : scene(scene)
        , parameters(parameters)
        , with_absent(with_absent)
        , stencils(scene.shape_functions->evaluate(scene.particles, scene.grid))
        , points(gather(stencils, scene.layout))
        , named(parameters.effect_names.names)
      {
        card.nonzeros =
          scene.stepper->grid_start().active->graph().n_nonzeros();
        // the tangent; the mass has a number for a pair of nodes
        card.n_matrices = scene.explicit_force ? 0 : 1;
        card.n_points = dealii::Utilities::MPI::sum(static_cast<std::uint64_t>(
                                                      points.n_points()),
                                                    scene.grid.communicator());
        card.point_bytes = dealii::Utilities::MPI::sum(
          static_cast<std::uint64_t>(
            sizeof(double) *
            (stencils.values.size() + stencils.gradients.size() +
             2 * points.n_points() * (scene.layout.n_components() + dim))),
          scene.grid.communicator());
        // position twice, in the real and the reference cell, and the id
        card.common_bytes =
          sizeof(double) * 2 * dim + sizeof(dealii::types::particle_index);
        const FieldLayout common = basic_fields(dim);
        for (const Field &field : common.fields())
          {
            card.common_fields.push_back(field.name);
            card.common_bytes += sizeof(double) * field.n_components;
          }
      }

      SceneCard
      count()
      {
        const bool is_explicit = scene.explicit_force != nullptr;
        const bool is_static   = parameters.time.is_static();
        if (!is_explicit && !is_static)
          add(Inertia<dim>::card());
        add(is_explicit ? ExplicitForce<dim>::card()
                        : InternalForce<dim>::card());
        add_materials();
        add(stress_rule_card(parameters.method.stress_rule));
        add_locking_treatment();
        add(explicit_card(is_explicit));
        add(static_card(is_static));
        add_shape_functions();
        add(middle_card<dim>(scene.middle != nullptr));
        add_starved_nodes();
        for (const auto &entry : effect_library<dim>().list())
          {
            const bool is_present = contains(named, entry.name);
            EffectCard effect =
              is_present
                ? parameters.effects.at(entry.name)->card_in_scene(entry.card)
                : entry.card;
            effect.name       = entry.name;
            effect.setting    = "Effects/Names = " + entry.name;
            effect.is_present = is_present;
            if (!effect.couples.empty() && (effect.is_present || with_absent))
              add(effect, nonzeros_of_effect(effect));
            else
              add(effect);
          }
        for (const EffectCard &effect : account_cards(scene.mapping))
          add(effect);
        for (const EffectCard &effect :
             wall_cards(parameters, scene.boundary_conditions, scene.balance))
          add(effect);
        add(parameters.diagnosis.card());
        add(displacement_card(scene.layout.has(start_position_field)));
        for (const auto &measurement : scene.measurements)
          add(measurement->card());
        std::stable_sort(card.effects.begin(),
                         card.effects.end(),
                         [](const auto &a, const auto &b) {
                           return a.card.is_present > b.card.is_present;
                         });
        return std::move(card);
      }

    private:
      void
      add(const EffectCard                 &effect,
          const std::optional<std::int64_t> nonzeros = 0)
      {
        CountedEffect counted{effect, {}, 0, nonzeros};
        if (effect.is_present)
          card.n_matrices += effect.n_matrices;
        // an absent effect brings what it names, if that is not there yet
        FieldLayout layout = scene.layout;
        if (!effect.is_present)
          {
            layout.set_effect(effect.name);
            for (const Field &field : effect.fields)
              layout.add(field);
          }
        for (const Field &field : layout.fields())
          if (field.asked_by == effect.name)
            {
              counted.fields.push_back(field.written_name());
              counted.n_numbers += field.n_components;
            }
        card.effects.push_back(counted);
      }

      void
      add_materials()
      {
        std::vector<std::string> used;
        for (unsigned int m = 0; m < scene.materials.size(); ++m)
          {
            const auto is_of = [m](const Body<dim> &body) {
              return body.material == m;
            };
            if (std::none_of(scene.bodies.begin(), scene.bodies.end(), is_of))
              continue; // costs nothing
            const std::string &model = parameters.materials[m]->model_name();
            const auto        &entry =
              material_library<dim>().find(model, "Materials", "Model");
            used.push_back(model);
            EffectCard effect = entry.card;
            effect.fields     = scene.materials[m]->history();
            effect            = StressStates<dim>::with_history(effect);
            for (const Field &field : scene.materials[m]->parameters())
              effect.fields.push_back(field);
            effect.name = material_effect(parameters.material_names.names[m]);
            effect.enters =
              (scene.explicit_force ? "motion and stress: "
                                    : "Newton, internal force: ") +
              model;
            effect.is_present = true;
            add(effect);
          }
        for (const auto &entry : material_library<dim>().list())
          if (!contains(used, entry.name))
            {
              EffectCard effect = StressStates<dim>::with_history(entry.card);
              effect.name       = entry.name;
              effect.setting    = "Materials/NAME/Model = " + entry.name;
              effect.enters     = "Newton, internal force";
              add(effect);
            }
      }

      void
      add_shape_functions()
      {
        EffectCard update = domain_update_card<dim>(scene.domain_update.get());
        for (const auto &entry : shape_function_library<dim>().list())
          {
            EffectCard effect = entry.card;
            effect.name       = entry.name;
            effect.setting    = "Method/Shape functions = " + entry.name;
            effect.is_present = entry.name == parameters.method.shape_functions;

            FieldLayout layout     = scene.layout;
            const auto  n_fields   = layout.fields().size();
            const auto  new_fields = [&] {
              return std::vector<Field>(layout.fields().begin() + n_fields,
                                        layout.fields().end());
            };
            std::optional<std::int64_t> nonzeros = 0;
            if (!effect.is_present)
              {
                const auto functions = entry.make(layout);
                effect.fields        = new_fields();
                if (with_absent)
                  nonzeros = nonzeros_with(*functions, layout) - card.nonzeros;
                const auto n_before = layout.fields().size();
                if (layout.has("half_length") && !update.is_present)
                  {
                    make_domain_update(parameters.method.domain_update,
                                       scene.bodies,
                                       scene.grid,
                                       layout);
                    update.fields = {layout.fields().begin() + n_before,
                                     layout.fields().end()};
                  }
              }
            else if (!effect.couples.empty())
              nonzeros =
                card.nonzeros -
                nonzeros_with(LinearShapeFunctions<dim>(scene.layout["body"]),
                              scene.layout);
            add(effect, nonzeros);
          }
        add(update);
      }

      void
      add_starved_nodes()
      {
        const bool                  is_present = follows();
        std::optional<std::int64_t> n          = 0;
        if (is_present)
          n = card.nonzeros -
              nonzeros(stencils, points, named, false, treats_locking());
        else if (with_absent)
          n = nonzeros(stencils, points, named, true, treats_locking()) -
              card.nonzeros;
        add(StarvedNodes<dim>::card(is_present), n);
      }

      bool
      treats_locking() const
      {
        return !parameters.locking_materials.empty();
      }

      void
      add_locking_treatment()
      {
        std::optional<std::int64_t> n = 0;
        if (treats_locking() || (with_absent && !scene.explicit_force))
          n = nonzeros(stencils, points, named, follows(), true) -
              nonzeros(stencils, points, named, follows(), false);
        add(MeanDilatation<dim>::card(treats_locking()), n);
      }

      bool
      follows() const
      {
        return scene.balance.has(starved_nodes_effect);
      }

      std::optional<std::int64_t>
      nonzeros_of_effect(const EffectCard &effect) const
      {
        std::vector<std::string> others = named;
        if (!effect.is_present)
          others.push_back(effect.name);
        else
          others.erase(std::find(others.begin(), others.end(), effect.name));
        try
          {
            const std::int64_t n =
              nonzeros(stencils, points, others, follows(), treats_locking());
            return effect.is_present ? card.nonzeros - n : n - card.nonzeros;
          }
        catch (const ExcParameter &) // of all ranks: from the parameter file
          {
            return {};
          }
      }

      /** With other shape functions, and the layout that they asked for. */
      std::int64_t
      nonzeros_with(const ShapeFunctions<dim> &functions,
                    const FieldLayout         &layout) const
      {
        dealii::Particles::ParticleHandler<dim> filled;
        const bool                              needs_fields =
          layout.n_components() > scene.layout.n_components();
        if (needs_fields)
          {
            filled.initialize(scene.grid.triangulation(),
                              scene.grid.mapping(),
                              layout.n_components());
            fill(scene.bodies, scene.grid, layout, filled);
          }
        const auto others =
          functions.evaluate(needs_fields ? filled : scene.particles,
                             scene.grid);
        return nonzeros(
          others, gather(others, layout), named, follows(), treats_locking());
      }

      /** Of a matrix with these stencils and effects. Collective. */
      std::int64_t
      nonzeros(const Stencils<dim>            &stencils,
               const PointArrays<dim>         &points,
               const std::vector<std::string> &names,
               const bool                      follows,
               const bool                      treats_locking) const
      {
        Effects<dim> effects;
        effects.material_of_body = scene.material_of_body;
        for (const Body<dim> &body : scene.bodies)
          {
            effects.half_length_of_body.push_back(
              initial_half_length(body, scene.grid));
            effects.body_names.push_back(body.name);
          }
        FieldLayout layout = scene.layout;
        if (follows)
          effects.terms.push_back(
            parameters.method.template make_starved_nodes<dim>(layout));
        if (treats_locking)
          effects.terms.push_back(std::make_unique<MeanDilatation<dim>>(
            scene.material_of_body,
            layout,
            MeanDilatation<dim>::Kind::conserving,
            std::vector<std::string>(),
            this->treats_locking() ? parameters.are_treated(scene.bodies)
                                   : std::vector<bool>()));
        for (const std::string &name : names)
          parameters.effects.at(name)->add_to(effects, layout);
        const Balance<dim> balance(std::move(effects));
        balance.classify(stencils, points, scene.grid, nullptr);
        return ActiveGrid<dim>(stencils,
                               balance.couplings(stencils,
                                                 scene.grid,
                                                 scene.boundary_conditions,
                                                 nullptr),
                               scene.grid,
                               scene.boundary_conditions,
                               scene.explicit_force
                                 ? ActiveGrid<dim>::Matrices::none
                                 : ActiveGrid<dim>::Matrices::wanted)
          .graph()
          .n_nonzeros();
      }

      const Scene<dim>               &scene;
      const SceneParameters<dim>     &parameters;
      const bool                      with_absent;
      const Stencils<dim>             stencils;
      const PointArrays<dim>          points;
      const std::vector<std::string> &named;
      SceneCard                       card;
    };

    /** Lines of the table. */
    constexpr int name_width = 24, bytes_width = 7, nonzeros_width = 12;

    void
    print_line(std::ostream      &out,
               const std::string &name,
               const std::string &bytes,
               const std::string &nonzeros,
               const std::string &words)
    {
      out << "  " << std::left << std::setw(name_width) << name << std::right
          << std::setw(bytes_width) << bytes << std::setw(nonzeros_width)
          << nonzeros << "  " << words << '\n';
    }

    void
    print_effect(std::ostream &out, const CountedEffect &effect)
    {
      const EffectCard  &card = effect.card;
      const std::int64_t n    = effect.nonzeros.value_or(0);
      const std::string  count =
        effect.nonzeros ? (n > 0 ? "+" : "") + std::to_string(n) : "?";
      print_line(out,
                 "  " + card.name,
                 std::to_string(sizeof(double) * effect.n_numbers),
                 count,
                 card.enters.empty() ? "it does not say" : card.enters);
      const auto detail = [&](const std::string &what,
                              const std::string &words) {
        if (!words.empty())
          print_line(out, "", "", "", what + " " + words);
      };
      if (!card.is_present)
        detail("set", card.setting);
      detail("fields", join(effect.fields));
      detail("couples", card.couples);
      detail("ledger", join(card.ledger_columns));
      detail("grid.pvd", join(card.grid_output));
    }
  } // namespace

  unsigned int
  SceneCard::particle_bytes() const
  {
    unsigned int bytes = common_bytes;
    for (const CountedEffect &effect : effects)
      if (effect.card.is_present)
        bytes += sizeof(double) * effect.n_numbers;
    return bytes;
  }

  void
  SceneCard::print(std::ostream &out, const bool with_absent) const
  {
    print_line(out, "present", "bytes", "nonzeros", "where it enters the step");
    print_line(out,
               "  every particle",
               std::to_string(common_bytes),
               "",
               "position, id, " + join(common_fields));
    std::vector<std::string> absent;
    for (const CountedEffect &effect : effects)
      if (effect.card.is_present)
        print_effect(out, effect);
      else
        absent.push_back(effect.card.name);
    print_line(out,
               "  all",
               std::to_string(particle_bytes()),
               std::to_string(nonzeros),
               n_matrices == 1
                 ? "in the matrix"
                 : "in each of " + std::to_string(n_matrices) + " matrices");
    if (!with_absent)
      {
        out << "  absent                " << join(absent) << '\n';
        return;
      }
    print_line(out, "absent", "bytes", "nonzeros", "what it would add");
    for (const CountedEffect &effect : effects)
      if (!effect.card.is_present)
        print_effect(out, effect);
  }

  template <int dim>
  SceneCard
  make_card(const Scene<dim>           &scene,
            const SceneParameters<dim> &parameters,
            const bool                  with_absent)
  {
    return Counter<dim>(scene, parameters, with_absent).count();
  }

  template SceneCard
  make_card<2>(const Scene<2> &, const SceneParameters<2> &, const bool);
  template SceneCard
  make_card<3>(const Scene<3> &, const SceneParameters<3> &, const bool);
} // namespace emmy
