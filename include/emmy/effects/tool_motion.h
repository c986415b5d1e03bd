#ifndef emmy_effects_tool_motion_h
#define emmy_effects_tool_motion_h

#include <deal.II/base/function_parser.h>
#include <deal.II/base/point.h>
#include <deal.II/base/tensor.h>

#include <emmy/base/section.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace emmy
{
  /**
   * The rigid motion of a tool over a step. With d from the tool's reference
   * point, each in the middle of the step, a point of the tool moves by
   * D + Omega x d; of this, and of how a particle's corner moves, w in the
   * tool's own frame is what the frame sees: with the turn Q of the frame and
   * half a step's turn, h about the axis n,
   * @f[ w = Q_1^T d_1 - Q_0^T d_0 = R^T (d_1 - d_0 - \Omega \times d), \quad
   *     R = (n n^T + \cos\tfrac h2 (I - n n^T)) Q_{1/2}, \quad
   *     \Omega = 2 n \tan\tfrac h2 . @f]
   * So a force R f does the work f.w on what the frame sees, and on the tool
   * that of a force at d: all that is stored, lost or put in adds up exactly.
   */
  template <int dim>
  struct ToolStep
  {
    dealii::Point<dim>     place;        ///< of the reference point at t, m
    dealii::Tensor<1, dim> displacement; ///< D, m
    dealii::Tensor<2, dim> to_frame;     ///< Q_0^T
    dealii::Tensor<2, dim> to_space;     ///< R
    dealii::Tensor<2, dim> spin;         ///< Omega x
    double                 turn;         ///< |h|
  };

  /**
   * A direction in the words of a parameter file, made a unit vector; throws
   * ExcParameter.
   */
  template <int dim>
  dealii::Tensor<1, dim>
  direction_of(const Section             &section,
               const std::string         &entry,
               const std::vector<double> &components);

  /** The entries of a tool's section that say where it is and how it moves. */
  template <int dim>
  struct ToolMotionParameters
  {
    /** m; in 3D the direction of the axis. */
    std::vector<double> reference_point, axis;
    /** Formulas, tables, and a formula, of t. */
    std::string displacement, displacement_table, velocity_table,
      rotation = "0";

    /** Adds its entries to a section. */
    void
    declare(Section &section);
  };

  /**
   * Where a tool is: its reference point and its turn, as functions of time.
   * They are given, not summed up: so a run that goes on knows them.
   *
   * Owned by the tool. Cost: a few formulas per step.
   */
  template <int dim>
  class ToolMotion
  {
  public:
    /** Throws ExcParameter for what cannot be read. */
    ToolMotion(const ToolMotionParameters<dim> &parameters,
               const Section                   &section);

    /** Of the reference point, m. Throws ExcRun, on all ranks. */
    dealii::Point<dim>
    place(const double time) const;

    /** What turns directions of the tool into those of space. */
    dealii::Tensor<2, dim>
    directions(const double time) const;

    /** Throws ExcRun, on all ranks, if a step turns by more than half of a
     * right angle. */
    ToolStep<dim>
    over(const double time, const double time_step) const;

    /** Of the turn, rad. */
    double
    angle(const double time) const;

    /** Whether it turns at any time. */
    bool
    is_turning() const
    {
      return turns;
    }

  private:
    using Row = std::pair<double, dealii::Tensor<1, dim>>;

    dealii::Tensor<1, dim>
    path(const double time) const;
    /** The row between which and the next one a time is; 0 before the first. */
    static std::size_t
    row_at(const std::vector<Row> &table, const double time);
    /** The integral of the table of velocities from its first time on. */
    dealii::Tensor<1, dim>
    travel(const double time) const;
    /** The turn by an angle about the axis. */
    dealii::Tensor<2, dim>
    turned(const double angle) const;
    /** n n^T + c (I - n n^T) + s (n x). */
    dealii::Tensor<2, dim>
    about_axis(const double c, const double s) const;
    double
    checked(const double value, const char *entry, const double time) const;

    std::string                                             section;
    dealii::Point<dim>                                      reference_point;
    dealii::Tensor<1, dim>                                  axis; ///< in space
    bool                                                    turns = false;
    std::vector<Row>                                        table, velocities;
    std::vector<std::unique_ptr<dealii::FunctionParser<1>>> formulas;
    std::unique_ptr<dealii::FunctionParser<1>>              rotation;
  };
} // namespace emmy

#endif
