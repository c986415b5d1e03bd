#include <emmy/effects/contact_parameters.h>
#include <emmy/effects/ghost_stabilisation.h>
#include <emmy/effects/gravity.h>
#include <emmy/effects/manufactured_solution.h>
#include <emmy/effects/mass_damping.h>
#include <emmy/effects/point_load.h>
#include <emmy/effects/surface_loads.h>
#include <emmy/effects/tool_parameters.h>
#include <emmy/effects/viscous_sides.h>

namespace emmy
{
  template <int dim>
  Library<EffectParameters<dim>> &
  effect_library()
  {
    static Library<EffectParameters<dim>> library = [] {
      Library<EffectParameters<dim>> effects;
      effects.add({"gravity",
                   "a constant acceleration on all particles",
                   [](const std::string &section) {
                     return std::make_unique<GravityParameters<dim>>(section);
                   },
                   GravityParameters<dim>::card()});
      effects.add({"point load",
                   "a force that chosen particles hold and carry along",
                   [](const std::string &section) {
                     return std::make_unique<PointLoadParameters<dim>>(section);
                   },
                   PointLoadParameters<dim>::card()});
      effects.add({"surface loads",
                   "tractions and pressures on surfaces of bodies",
                   [](const std::string &section) {
                     return std::make_unique<SurfaceLoadsParameters<dim>>(
                       section);
                   },
                   SurfaceLoadsParameters<dim>::card()});
      effects.add({"mass damping",
                   "a force against the velocity of all particles",
                   [](const std::string &section) {
                     return std::make_unique<MassDampingParameters<dim>>(
                       section);
                   },
                   MassDampingParameters<dim>::card()});
      effects.add({"viscous sides",
                   "sides of the grid that take up waves",
                   [](const std::string &section) {
                     return std::make_unique<ViscousSidesParameters<dim>>(
                       section);
                   },
                   ViscousSidesParameters<dim>::card()});
      effects.add({"contact",
                   "groups of bodies that push one another, and rub",
                   [](const std::string &section) {
                     return std::make_unique<ContactParameters<dim>>(section);
                   },
                   ContactParameters<dim>::card()});
      effects.add({"tools",
                   "rigid bodies that move as they are told, push, and rub",
                   [](const std::string &section) {
                     return std::make_unique<ToolsParameters<dim>>(section);
                   },
                   ToolsParameters<dim>::card()});
      effects.add({ghost_effect,
                   "penalties on faces at the body's boundary, for small cuts",
                   [](const std::string &section) {
                     return std::make_unique<GhostParameters<dim>>(section);
                   },
                   GhostParameters<dim>::card()});
      effects.add(
        {"manufactured solution",
         "the body force of a motion in closed form, and the distance from it",
         [](const std::string &section) {
           return std::make_unique<ManufacturedSolutionParameters<dim>>(
             section);
         },
         ManufacturedSolutionParameters<dim>::card()});
      return effects;
    }();
    return library;
  }

  template Library<EffectParameters<2>> &
  effect_library<2>();
  template Library<EffectParameters<3>> &
  effect_library<3>();
} // namespace emmy
