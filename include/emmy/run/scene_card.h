#ifndef emmy_run_scene_card_h
#define emmy_run_scene_card_h

#include <emmy/run/scene.h>

#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace emmy
{
  /** An effect of the scene card, with what was counted. */
  struct CountedEffect
  {
    EffectCard card; ///< what the effect says of itself
    /** Fields that it adds to each particle, and how many numbers they are. */
    std::vector<std::string> fields;
    unsigned int             n_numbers = 0; ///< of a particle
    /**
     * How many entries more a matrix has with it than without it, all else
     * being the same. None: it cannot be built, as the file does not give what
     * it requires.
     */
    std::optional<std::int64_t> nonzeros = 0;
  };

  /** What a scene is made of and what each part costs; same on all ranks. */
  struct SceneCard
  {
    std::vector<CountedEffect> effects;       ///< those present first
    std::vector<std::string>   common_fields; ///< that every particle carries
    unsigned int  common_bytes = 0; ///< of a particle without any effect
    std::uint64_t n_points     = 0; ///< over all ranks
    std::uint64_t point_bytes  = 0; ///< of the points of a step, all ranks
    std::int64_t  nonzeros     = 0; ///< of each matrix
    unsigned int  n_matrices   = 0; ///< at the same time

    /** Of a particle. */
    unsigned int
    particle_bytes() const;

    /**
     * A table: the effects that are present; those absent too if they were
     * counted, else their names.
     */
    void
    print(std::ostream &out, const bool with_absent) const;
  };

  /**
   * Count what the effects of a scene cost that is at its start. Collective.
   *
   * An effect that couples nodes is counted by a second numbering of the nodes
   * without it (or with it, if it is absent): the time and memory of a sparsity
   * pattern each, for the present ones only, unless @p with_absent. Then shape
   * functions that need fields are given particles that have them.
   */
  template <int dim>
  SceneCard
  make_card(const Scene<dim>           &scene,
            const SceneParameters<dim> &parameters,
            const bool                  with_absent);
} // namespace emmy

#endif
