#ifndef emmy_step_small_cuts_h
#define emmy_step_small_cuts_h

#include <emmy/base/section.h>
#include <emmy/solve/condition.h>
#include <emmy/step/balance.h>

#include <string>
#include <vector>

namespace emmy
{
  /** Section `Diagnosis`. */
  class DiagnosisParameters : public Section
  {
  public:
    bool   small_cuts   = false; ///< whether matrices are examined
    double report_above = 1e8;   ///< condition numbers above

    /** Declares the entries of the section. */
    explicit DiagnosisParameters(const std::string &path = "Diagnosis");

    /** What the diagnosis costs. */
    EffectCard
    card() const;
  };

  /**
   * condition_estimate() of a matrix on the active grid, from a start vector
   * that depends on the nodes' positions, not on the partition. Collective.
   */
  template <int dim>
  ConditionEstimate
  condition_estimate(const Matrix &matrix, const ActiveGrid<dim> &active);

  /**
   * The mass matrix that a diagnosis is about: M~, or, if nodes follow others,
   * C^T M~ C with the damping of linear solvers, 1e-13, which does not show
   * in a condition number far below 1e13.
   */
  template <int dim>
  Matrix
  examined_mass(const GridStart<dim> &start);

  /**
   * The derivative of r(u) where the equation was evaluated last, without the
   * damping of the mass that is in StepEquation::jacobian(), unless
   * examined_mass() has it too. Nobody may have
   * added to that since. Collective.
   */
  template <int dim>
  Matrix
  undamped_jacobian(StepEquation<dim>    &equation,
                    const GridStart<dim> &start,
                    const double          time_step);

  /** A node that a matrix hardly sees, and what it gets its mass from. */
  template <int dim>
  struct WeakNode
  {
    /** A particle that reaches a weak node. */
    struct Feeder
    {
      std::uint64_t      id;       ///< its number over all ranks
      dealii::Point<dim> position; ///< m
      double             value;    ///< S of the node at the particle
      double             mass;     ///< m_p S, kg
    };

    dealii::Point<dim>              position; ///< m
    double                          weakness; ///< 1: none is weaker
    std::vector<dealii::Point<dim>> cells; ///< centres of its active cells, m
    std::uint64_t                   n_particles = 0; ///< that reach it, S > 0
    std::vector<Feeder>             feeders; ///< the heaviest, at most three
  };

  /** What was found in one matrix; the same on all ranks. */
  template <int dim>
  struct Diagnosis
  {
    double condition   = 0.;    ///< of the matrix scaled with its diagonal
    bool   is_singular = false; ///< to round-off
    /** The weakest first, at most three, none stronger than half of it. */
    std::vector<WeakNode<dim>> nodes;
    /** By local node: how far the weakest vector goes there, 0 to 1. */
    std::vector<double> weakness;

    /**
     * One line: the condition of this matrix, the weakest places, the
     * particles that feed them.
     */
    std::string
    text(const std::string &name) const;

    /** Whether the condition number is above a limit, or is no number. */
    bool
    is_above(const double limit) const;

    /** text() above the limit; else that no small cut is to blame. */
    std::string
    verdict(const std::string &name, const double limit) const;
  };

  /**
   * Examine a matrix on the active grid: its condition and its weakest places.
   * Collective. Cost: that of condition_estimate(), and a pass over the
   * particles.
   */
  template <int dim>
  Diagnosis<dim>
  diagnose(const Matrix           &matrix,
           const Stencils<dim>    &stencils,
           const PointArrays<dim> &points,
           const FieldLayout      &layout,
           const ActiveGrid<dim>  &active);

  /** Both matrices of a step. */
  template <int dim>
  struct StepDiagnosis
  {
    /** Of the two matrices. */
    Diagnosis<dim> mass, jacobian;
  };

  /** Whether a small cut is to blame for a failure, and what helps. */
  struct CutVerdict
  {
    /** For an error; may be empty. */
    std::string text, remedy;
    std::string weakest; ///< Diagnosis::text() whatever the limit
  };

  /**
   * What helps against small cuts, beyond what the scene has already: a
   * sentence for an error's remedy.
   */
  template <int dim>
  std::string
  small_cut_remedy(const Balance<dim> &balance, const PointMapping &mapping);
} // namespace emmy

#endif
