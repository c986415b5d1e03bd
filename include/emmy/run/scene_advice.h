#ifndef emmy_run_scene_advice_h
#define emmy_run_scene_advice_h

#include <emmy/run/scene.h>

#include <iosfwd>

namespace emmy
{
  /**
   * What `emmy --check` says of a scene beyond its card: the shortest waves
   * that steps and grid resolve, and those that loads send; numbers that look
   * as if they were not in SI units; how many nodes starve, and where; walls
   * that touch nothing; bodies whose boxes overlap; particles on faces of
   * cells; what the effects advise, see Adviser; and what would make the run
   * cheaper, at which price. Collective. Cost: a loop over the particles and
   * the other bodies, and some ten thousand evaluations of each amplitude.
   */
  template <int dim>
  void
  advise(const Scene<dim>           &scene,
         const SceneParameters<dim> &parameters,
         const StepReport           &initial,
         std::ostream               &out);

  /**
   * Make the first step, and say what the run will take by it: seconds, and
   * memory. The scene is not used any more. Collective. Throws ExcRun where
   * the step fails, as a run would.
   */
  template <int dim>
  void
  calibrate(Scene<dim>                 &scene,
            const SceneParameters<dim> &parameters,
            std::ostream               &out);
} // namespace emmy

#endif
