#ifndef emmy_effects_tool_path_h
#define emmy_effects_tool_path_h

#include <emmy/effects/tool_motion.h>
#include <emmy/effects/tool_shapes.h>

#include <optional>

namespace emmy
{
  /**
   * Where a tool whose motion is given goes in a run: it is looked at in some
   * instants, and between them it is as far as it may come. So what is said
   * holds, while a tool that comes very near to touch may not be noticed.
   *
   * Borrows the shape and the motion. Cost: a distance for each point and
   * instant, but for those in which the tool cannot come nearer than before.
   */
  template <int dim>
  class ToolPath
  {
  public:
    /** @param end_time of the run, s */
    ToolPath(const ToolShape<dim>  &shape,
             const ToolMotion<dim> &motion,
             const double           end_time);

    /** Whether it moves or turns. */
    bool
    moves() const;

    /**
     * How near it comes at least to points that rest, m; 0 if it may touch
     * one. The largest number if there is none.
     */
    double
    least_gap(const std::vector<dealii::Point<dim>> &points) const;

    /** Since when no point of a box is in the tool, until the end, s; empty: at
     * the end there may be some. */
    std::optional<double>
    outside_since(const dealii::Point<dim> &lower,
                  const dealii::Point<dim> &upper) const;

  private:
    /** Where it is in an instant. */
    struct Instant
    {
      double                 time; ///< s
      dealii::Point<dim>     place;
      dealii::Tensor<2, dim> to_frame;
    };
    double
    distance(const Instant &instant, const dealii::Point<dim> &point) const;
    /** The largest way, m, of what is that far from the reference point. */
    static double
    way(const Instant &from, const Instant &to, const double reach);
    bool
    is_outside(const Instant                         &instant,
               const std::vector<dealii::Point<dim>> &lattice,
               const double                           spacing) const;

    const ToolShape<dim> &shape;
    std::vector<Instant>  instants;
  };
} // namespace emmy

#endif
