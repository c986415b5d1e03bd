#ifndef emmy_run_cheaper_h
#define emmy_run_cheaper_h

#include <emmy/run/scene.h>

#include <iosfwd>

namespace emmy
{
  /**
   * Settings that would make the scene cheaper, each with its share of the
   * time and what it multiplies errors by, as studies of emmy measured them
   * (doc/accuracy-and-cost.md, doc/performance.md): only those that the scene
   * could take. Cost: none.
   *
   * @param in_cell particles in a cell, on average
   */
  template <int dim>
  void
  tell_cheaper_settings(const Scene<dim>           &scene,
                        const SceneParameters<dim> &parameters,
                        const StepReport           &initial,
                        const double                in_cell,
                        std::ostream               &out);
} // namespace emmy

#endif
