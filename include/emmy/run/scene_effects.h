#ifndef emmy_run_scene_effects_h
#define emmy_run_scene_effects_h

#include <emmy/effects/explicit_force.h>
#include <emmy/run/scene_parameters.h>
#include <emmy/step/balance.h>

#include <memory>
#include <vector>

namespace emmy
{
  /** The stress of explicit steps; null with implicit ones. */
  template <int dim>
  std::unique_ptr<ExplicitForce<dim>>
  make_explicit_force(
    const SceneParameters<dim>               &parameters,
    const std::vector<Body<dim>>             &bodies,
    const std::vector<const Material<dim> *> &material_of_body,
    FieldLayout                              &layout);

  /**
   * What acts in a scene: with implicit steps inertia and internal force, then
   * what the boundary conditions and the method bring, and the effects that the
   * file names. Throws ExcParameter.
   */
  template <int dim>
  Effects<dim>
  make_effects(const SceneParameters<dim>               &parameters,
               const std::vector<Body<dim>>             &bodies,
               const std::vector<const Material<dim> *> &material_of_body,
               const BoundaryConditions<dim>            &boundary_conditions,
               const BackgroundGrid<dim>                &grid,
               FieldLayout                              &layout);

  /** Check how particles and grid are mapped. Throws ExcParameter. */
  template <int dim>
  PointMapping
  make_mapping(const SceneParameters<dim>    &parameters,
               const BoundaryConditions<dim> &boundary_conditions,
               const Balance<dim>            &balance);

  /** What the effects of walls cost, present or not. */
  template <int dim>
  std::vector<EffectCard>
  wall_cards(const SceneParameters<dim>    &parameters,
             const BoundaryConditions<dim> &boundary_conditions,
             const Balance<dim>            &balance);
} // namespace emmy

#endif
