#ifndef emmy_system_rank_one_h
#define emmy_system_rank_one_h

#include <emmy/base/linear_algebra.h>

#include <vector>

namespace emmy
{
  /**
   * A part column row^T of a derivative dr/du that has no place in a sparse
   * matrix: that of an unknown which many nodes meet and which its effect
   * eliminates. Zero on constrained unknowns.
   */
  struct RankOne
  {
    /** The matrix is column times row. */
    Vector column, row;
  };

  /** What an effect is, too, if its derivative has such parts. */
  class RankOneSource
  {
  public:
    virtual ~RankOneSource() = default;

    /** Those of the last derivative, with the constraints worked in. */
    virtual const std::vector<RankOne> &
    rank_ones() const = 0;
  };
} // namespace emmy

#endif
