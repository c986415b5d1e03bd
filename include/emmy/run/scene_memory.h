#ifndef emmy_run_scene_memory_h
#define emmy_run_scene_memory_h

#include <emmy/run/scene.h>

#include <iosfwd>
#include <string>
#include <vector>

namespace emmy
{
  /** What a run will take at its peak, B. */
  struct SceneMemory
  {
    /** Something that has a part of it, of all ranks together. */
    struct Part
    {
      std::string name;  ///< in words
      double      bytes; ///< of all ranks
    };

    std::vector<Part> parts;        ///< that stand together at the peak
    double            total   = 0.; ///< of all ranks
    double            largest = 0.; ///< of the rank with most
  };

  /**
   * What the process takes now, once what is free in it has been given back,
   * and what a step adds: each array by its length and the size of what it
   * holds, in the parts of a step that take most. Lengths are those of the
   * particles as they stand; boxes of GIMP as they lie when the body has moved
   * by a part of a cell. Collective. Cost: stencils and a numbering of nodes.
   *
   * Not known before a run are: what bodies reach when they have spread, nodes
   * in contact, iterations of GMRES beyond some twenty, and LU where GMRES
   * fails. What LU fills in is guessed.
   *
   * @param n_matrices that steps have at the same time, see SceneCard
   *
   * @pre the scene is at its start, and its balance is not used after this
   *   without being classified anew, as a step does
   */
  template <int dim>
  SceneMemory
  predict_memory(const Scene<dim>           &scene,
                 const SceneParameters<dim> &parameters,
                 const unsigned int          n_matrices);

  /** As a line of `emmy --check`. */
  void
  print_memory(const SceneMemory &memory, std::ostream &out);
} // namespace emmy

#endif
