#ifndef emmy_effects_step_memory_h
#define emmy_effects_step_memory_h

#include <vector>

namespace emmy
{
  /** What an effect hands from one of its steps to the next: with it a run can
   * go on. See Effect::memory(). */
  class StepMemory
  {
  public:
    virtual ~StepMemory() = default;

    /** This rank's share. */
    virtual std::vector<double>
    contents() const = 0;

    /**
     * Go on from what contents() gave, perhaps on other ranks, and on more or
     * fewer.
     * @param parts first that of rank 0, on all ranks; then those of some
     *   ranks, each of which comes to one rank
     */
    virtual void
    recall(const std::vector<std::vector<double>> &parts) = 0;
  };
} // namespace emmy

#endif
