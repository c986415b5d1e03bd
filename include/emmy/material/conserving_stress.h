#ifndef emmy_material_conserving_stress_h
#define emmy_material_conserving_stress_h

#include <emmy/material/stress_rules.h>

namespace emmy
{
  /**
   * The conserving rule, see StressRule. Points stand side by side, four at a
   * time; results do not depend on the instruction set, and on which they are
   * only in last digits: a batch with a small step has its changes of energy
   * from the material, others by subtraction.
   *
   * With M = Fm Delta F^-1 and the material's spatial tangent c, the derivative
   * of P = Fm S is
   * @f[ dP = \tfrac12 M\, c[\mathrm{sym}(dH\,\Delta F^{-1})]\,\Delta F^{-T}
   *     + 2 F_m B\,(\Delta F\, g : dH)
   *     + \beta\, F_m b\,(\Delta F^T dH + dH^T \Delta F)\, b
   *     + \tfrac12 dH\, S , @f]
   * where S = S-bar + beta B and g = d beta / d(Delta C) of the correction:
   * no tangent is turned, and only c is a tensor of fourth order.
   *
   * Cost: in space some 1600 multiplications and additions a point with
   * tangent, some 200 without.
   *
   * @return as StressRule::evaluate
   */
  template <int dim>
  unsigned int
  conserving_stress(const Material<dim> &material, StressBatch<dim> &batch);

  /**
   * Fill in the changes of energy that the material was not asked for, or
   * cannot give, as differences.
   * @param is_given whether the material gives that of hardening
   */
  template <int dim>
  void
  subtract_energies(const bool is_given, StressBatch<dim> &batch);

  /**
   * 2 (Delta psi + Delta D) - work of point @p p, J/m^3; a difference that is
   * round-off is zero. The point's energies at t + dt become those at t plus
   * their changes.
   *
   * @param work twice what the mean stress works, S : A
   */
  template <int dim>
  double
  missing_energy(StressBatch<dim>  &batch,
                 const unsigned int p,
                 const double       work);
} // namespace emmy

#endif
