#ifndef emmy_run_effect_advice_h
#define emmy_run_effect_advice_h

#include <emmy/run/scene.h>

#include <iosfwd>

namespace emmy
{
  /** The uniform acceleration that acts on all bodies alike, m/s^2. */
  template <int dim>
  dealii::Tensor<1, dim>
  common_acceleration(const SceneParameters<dim> &parameters);

  /** What effects have to say of the scene, see Adviser. Collective. */
  template <int dim>
  void
  tell_effect_advice(const Scene<dim>           &scene,
                     const SceneParameters<dim> &parameters,
                     std::ostream               &out);
} // namespace emmy

#endif
