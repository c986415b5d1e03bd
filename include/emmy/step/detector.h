#ifndef emmy_step_detector_h
#define emmy_step_detector_h

#include <emmy/effects/step_report.h>
#include <emmy/particles/field_layout.h>
#include <emmy/particles/point_arrays.h>
#include <emmy/step/run_state.h>
#include <emmy/system/active_grid.h>

#include <string>

namespace emmy
{
  /**
   * By how much the fullest node holds more than its place: the largest over
   * the nodes of
   * @f$ \sum_p V_p S_{Ap} / \int N_A - 1 @f$, V_p = V0 det F the volume of a
   * particle now, m^dim; at a side of the grid the integral is that inside.
   * Zero where the particles tile a body, below zero if no node is full.
   * Cost: one pass over the values of the stencils. Collective.
   *
   * @param points     states at t
   * @param points_new states at t + dt; for stencils of the middle of the step
   *   the volume is the mean of both, for those of the start not used
   */
  template <int dim>
  double
  overfill(const Stencils<dim>       &stencils,
           const PointArrays<dim>    &points,
           const PointArrays<dim>    &points_new,
           const FieldLayout         &layout,
           const ActiveGrid<dim>     &active,
           const BackgroundGrid<dim> &grid);

  /** Which remedies a scene has already, or has no use for. */
  struct RemediesInUse
  {
    bool gimp;           ///< Shape functions = GIMP
    bool middle;         ///< Geometry = middle, or explicit steps
    bool followers;      ///< Starved nodes = follow, or they may not
    bool is_dissipative; ///< Mapping = PIC or blend
  };

  /**
   * Watches each step for what a balance cannot show: motion and matter that
   * the grid does not see. In compressed bodies modes of the size of a cell can
   * grow while every balance stays exact. Two signs:
   * - the hidden share: hidden_kinetic_energy over the largest kinetic energy
   *   so far (so that a body that comes to rest does not look noisy), or over
   *   1e-4 of the largest stored energy, if that is more;
   * - overfill(), less that of the initial state if that is above zero.
   *
   * Says so once in a run, with what the scene could use and does not, when in
   * ten steps on end
   * - the share is above 3e-3 and the overfill above 0.015, in scenes whose
   *   stored energy has reached half of their kinetic energy: noise feeds on
   *   it. Where it has not, hidden motion is what impacts leave;
   * - or the share is above 1/4;
   * - or the overfill is above 1/2.
   *
   * The bounds lie between what healthy scenes with GIMP have, an overfill of
   * at most 0.008 where energy is stored, and what columns have whose
   * settlement is 1 to 2 % wrong. All ranks call it with the same numbers.
   * Owned by the integrator; what it has seen is
   * part of RunState. Cost: none.
   */
  class Detector
  {
  public:
    /** Borrows both. */
    Detector(const RemediesInUse &in_use, DetectorState &state, Told &told);

    /** Add the columns to the report of the initial state. */
    void
    begin(const double overfill, StepReport &initial);

    /**
     * Add the columns of a step, and perhaps the note.
     * @param hidden   kinetic energy that the grid does not see at t, J
     * @param overfill of the step
     * @param where    the step in words
     * @param report   has the totals and all energies of the step
     */
    void
    look(const double       hidden,
         const double       overfill,
         const std::string &where,
         StepReport        &report);

  private:
    /** What is beyond its bound, in words; empty: nothing, or not for long. */
    std::string
    finding(const double hidden, const double share, const double overfill);
    std::string
    remedy() const;

    const RemediesInUse in_use;
    DetectorState      &state;
    Told               &told;
  };
} // namespace emmy

#endif
