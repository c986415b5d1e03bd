#ifndef emmy_step_step_rule_h
#define emmy_step_step_rule_h

#include <emmy/base/section.h>
#include <emmy/material/material.h>
#include <emmy/transfer/particles_to_grid.h>

#include <optional>

#include <memory>
#include <string>
#include <vector>

namespace emmy
{
  /** Section `Time`. */
  class TimeParameters : public Section
  {
  public:
    double end_time = 0.; ///< s, required
    /** `implicit`, `explicit` or `static`. */
    std::string integrator    = "implicit";
    std::string stress_update = "modified"; ///< of explicit steps
    /** `normalised`, `wave` or `fixed`. */
    std::string  step_rule        = "normalised";
    double       step_size        = 0.;  ///< s, required by the rule `fixed`
    double       factor           = 1.;  ///< of the normalised step
    unsigned int maximum_steps    = 0;   ///< 0: no limit
    unsigned int maximum_halvings = 8;   ///< of one step
    double       maximum_travel   = 0.5; ///< cells
    /** So that the run ends at its end time. */
    bool                     shorten_last_step = true;
    unsigned int             increments        = 10; ///< of static steps
    std::vector<std::string> raised_loads;           ///< effects; empty: all

    /** Declares the entries of the section. */
    explicit TimeParameters(const std::string &path = "Time");

    /** Throws ExcParameter. */
    void
    validate() const;

    /**
     * The latest time that the run can reach, s; 0: it is not known, because
     * the number of steps is limited, and their sizes follow from the states.
     */
    double
    latest_end() const;

    /** By its integrator. */
    bool
    is_explicit() const
    {
      return integrator == "explicit";
    }

    /** By its integrator. */
    bool
    is_static() const
    {
      return integrator == "static";
    }
  };

  /** Chooses the size of a step from the state at its start. */
  template <int dim>
  class StepRule
  {
  public:
    virtual ~StepRule() = default;

    /** The step, s. Collective. */
    virtual double
    operator()(const Stencils<dim>    &stencils,
               const PointArrays<dim> &points,
               const ActiveGrid<dim>  &active) const = 0;

    /** The step if it is the same for all particles and nodes; else empty. */
    virtual std::optional<double>
    constant() const
    {
      return {};
    }
  };

  /**
   * The rule that the parameters name:
   * - fixed: Step size;
   * - wave: Factor h sqrt(rho/M), the smallest over the materials (eq. 57);
   * - paper: Factor h min_A sqrt(m_A/(V_A M_A)) with M_A = sum S_Ap M_p as
   *   printed (eq. 61), which shrinks with the number of points per cell;
   * - normalised: the same with M_A divided by sum S_Ap.
   *
   * @param material_of_body borrowed; one per body
   */
  template <int dim>
  std::unique_ptr<StepRule<dim>>
  make_step_rule(const TimeParameters                     &parameters,
                 const BackgroundGrid<dim>                &grid,
                 const std::vector<const Material<dim> *> &material_of_body,
                 const FieldLayout                        &layout);
} // namespace emmy

#endif
