#ifndef emmy_effects_tool_push_h
#define emmy_effects_tool_push_h

#include <emmy/effects/corner_forces.h>
#include <emmy/effects/tool_motion.h>
#include <emmy/system/rank_one.h>

#include <functional>
#include <optional>

namespace emmy
{
  /** A force that pushes a tool with a mass along a direction. */
  template <int dim>
  struct ToolPush
  {
    dealii::Tensor<1, dim> direction;     ///< e
    double                 mass;          ///< kg; in plane strain per m
    double                 initial_speed; ///< m/s
    std::string            section;       ///< of the tool, for messages
    std::unique_ptr<dealii::FunctionParser<1>> formula; ///< P(t), N

    /** P. Throws ExcRun, on all ranks, if it is not finite. */
    double
    force(const double time) const;
  };

  /** Where a tool that is pushed is, at the start of a step. */
  struct PushState
  {
    double travel = 0.; ///< along e, m
    double speed  = 0.; ///< m/s
  };

  /** The entries of a tool's section that say what pushes it. */
  template <int dim>
  struct ToolPushParameters
  {
    std::vector<double> direction; ///< of the force
    std::string         force;     ///< formula of t, N
    /** kg and m/s. */
    double mass = 0., initial_speed = 0.;

    /** Adds its entries to a section. */
    void
    declare(Section &section);
    /** Whether a force moves the tool. */
    bool
    is_given() const
    {
      return !direction.empty();
    }
    /** Empty if it is not pushed. Throws ExcParameter. */
    std::optional<ToolPush<dim>>
    make(const Section &section) const;
  };

  /** What bodies do to a tool along e, at a way D of it. */
  struct PushResistance
  {
    double force      = 0.; ///< sum of e.f, with f on the bodies, N
    double stiffness  = 0.; ///< its derivative by D, N/m
    double magnitudes = 0.; ///< sum of |e.f|, N
  };

  /** How a tool moves in a step. */
  struct PushMotion
  {
    double      way       = 0.; ///< D, m
    double      stiffness = 0.; ///< d rho / dD, N/m
    std::string problem;        ///< if none was found, on all ranks
  };

  /**
   * Solve the mid-point rule of a tool that is pushed,
   * @f[ \rho = m \tfrac{2}{\Delta t} (D/\Delta t - v) - P(t + \tfrac12 \Delta
   * t)
   *            + \sum e \cdot f(D) = 0, \quad v_1 = 2 D/\Delta t - v , @f]
   * to round-off, so that its kinetic energy gains exactly (P - sum e.f) D. By
   * Newton's method between bounds: what resists grows with D.
   *
   * @param resistance at a way, summed over the ranks. Collective.
   */
  template <int dim>
  PushMotion
  pushed_motion(const ToolPush<dim>                               &push,
                const PushState                                   &state,
                const double                                       time,
                const double                                       time_step,
                const std::function<PushResistance(const double)> &resistance);

  /**
   * The way D of a tool is eliminated from Newton's equation: with r of the
   * nodes, D follows u by dD = -(c.du + shift)/(d rho/dD), where c = d rho/du.
   * This sums b = dr/dD and c over the particles that it touches, and gives
   * the rank-one part -b c^T/(d rho/dD) of dr/du. Where places follow the
   * nodes, D follows them too, and the rest goes to the share of places.
   *
   * Made for an evaluation with a derivative. Cost: per touched particle that
   * of its weights.
   */
  template <int dim>
  class PushCoupling
  {
  public:
    /** Particles of one body in one cell. */
    using Group = typename Stencils<dim>::Group;

    /** Borrows all. */
    PushCoupling(const StepData<dim>          &step,
                 const std::vector<double>    &local_displacement,
                 const dealii::Tensor<1, dim> &direction);

    /**
     * A corner of the particle that is looked at.
     * @param derivative of the force on it by its way, N/m
     */
    void
    add(const CornerMotion<dim>      &particle,
        const dealii::Tensor<1, dim> &arm,
        const dealii::Tensor<2, dim> &derivative);
    /** Hand what was added to the nodes. */
    void
    finish(const Group &group, const unsigned int q);
    /** Append the part of the derivative, if anything is touched. Collective.
     */
    void
    finish(const double stiffness, std::vector<RankOne> &terms) const;

  private:
    const StepData<dim>         &step;
    const std::vector<double>   &displacement;
    const dealii::Tensor<1, dim> direction;
    std::vector<double>          by_way, by_nodes; ///< b, c
    double                       shift = 0.;       ///< of rho, N
    bool                         acts = false, touches = false;
    // of the particle: of (f, f (x) a) by D; of e.f by (S u, L)
    PointMotion<dim> forces_by_way{}, force_by_motion{};
  };
} // namespace emmy

#endif
