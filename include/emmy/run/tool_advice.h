#ifndef emmy_run_tool_advice_h
#define emmy_run_tool_advice_h

#include <emmy/run/scene.h>

#include <iosfwd>

namespace emmy
{
  /**
   * Say which tools touch no particle in the whole run, and which are outside
   * of the grid from some time on, as far as that can be known beforehand: of
   * tools whose motion is given, and of bodies that stand where they do at the
   * start or move by no more than their velocity and gravity let them. Of a
   * tool that a force pushes nothing is said, and of one that rests nothing if
   * something else may move bodies. Collective. Cost: see ToolPath.
   */
  template <int dim>
  void
  tell_tools(const Scene<dim>           &scene,
             const SceneParameters<dim> &parameters,
             std::ostream               &out);
} // namespace emmy

#endif
