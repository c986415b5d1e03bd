#ifndef emmy_effects_point_batch_h
#define emmy_effects_point_batch_h

#include <emmy/material/material.h>
#include <emmy/particles/stencils.h>

#include <algorithm>

namespace emmy
{
  /**
   * Points of one body that follow each other, at most max_batch_points, of a
   * part of a group or of several small ones: what is done for all points
   * alike is done for a batch. Goes through the points of stencils:
   *
   *   for (PointBatch<dim> points(stencils); points.next();)
   */
  template <int dim>
  class PointBatch
  {
  public:
    using Group = typename Stencils<dim>::Group; ///< of a step

    /** Points of one group. */
    struct Part
    {
      const Group *group;    ///< whose they are
      unsigned int first;    ///< point of the group
      unsigned int n_points; ///< from there
      unsigned int at;       ///< where they stand in the batch
    };

    /** Before the first points; borrows. */
    explicit PointBatch(const Stencils<dim> &stencils)
      : stencils(stencils)
      , group(stencils.groups.begin())
    {}

    /** The next points. @return whether there are any */
    bool
    next()
    {
      first_point += n_points;
      n_points = 0;
      parts.clear();
      if (group == stencils.groups.end())
        return false;
      body = group->body;
      while (n_points < max_batch_points && group != stencils.groups.end() &&
             group->body == body)
        {
          const unsigned int n =
            std::min(max_batch_points - n_points, group->n_points - done);
          parts.push_back({&*group, done, n, n_points});
          n_points += n;
          done += n;
          if (done == group->n_points)
            {
              ++group;
              done = 0;
            }
        }
      return true;
    }

    const Stencils<dim> &stencils;        ///< of all points
    std::vector<Part>    parts;           ///< the points by groups
    std::size_t          first_point = 0; ///< of all
    unsigned int         n_points    = 0; ///< of the batch
    unsigned int         body        = 0; ///< of all of them

  private:
    typename std::vector<Group>::const_iterator group;
    unsigned int                                done = 0; ///< of that group
  };
} // namespace emmy

#endif
