#ifndef emmy_material_conserving_stress_h
#define emmy_material_conserving_stress_h

#include <emmy/material/material.h>

namespace emmy
{
  /** One step of a batch of points of one material: state, motion, answer. */
  template <int dim>
  struct StressBatch
  {
    template <typename T>
    using PerPoint = std::array<T, max_batch_points>;

    // in
    unsigned int n_points     = 0;
    bool         with_tangent = true;
    /** Displacement gradient of the step, with respect to positions at t. */
    PerPoint<dealii::Tensor<2, dim>> displacement_gradient;
    /** State at t: b, tau (Pa) and psi (J/m^3, reference volume). */
    PerPoint<MandelVector<dim>> left_cauchy_green_old;
    PerPoint<MandelVector<dim>> kirchhoff_stress_old;
    PerPoint<double>            stored_energy_old;

    // out
    /** State at t + dt: material.left_cauchy_green, .kirchhoff_stress, ... */
    MaterialBatch<dim> material;
    /** Nominal stress P at mid-step, relative to positions at t, Pa. */
    PerPoint<dealii::Tensor<2, dim>> nominal_stress;
    /** dP_iJ / dH_mL at row i*dim+J, column m*dim+L. Only if with_tangent. */
    PerPoint<dealii::Tensor<2, dim * dim>> tangent;
  };

  /**
   * The stress that makes the mid-point rule conserve energy and momenta
   * (Gonzalez 2000; Pretti et al. 2023, eqs 47-52), for any material, and its
   * exact tangent, which is not symmetric. With the configuration at t as the
   * reference of the step, A = Delta F^T Delta F - I,
   * @f[ \bar S = \tfrac12(\tau_t + \Delta F^{-1}\tau\Delta F^{-T}),\quad
   *     B = b_t A b_t,\quad
   *     S = \bar S + B\,\frac{2\Delta\psi - \bar S : A}{A : B},\quad
   *     P = \tfrac12 (I + \Delta F) S, @f]
   * so that P : H equals the change of psi to round-off. Where the change of
   * C is below 1e-8 of C the correction is left out: the energy it would
   * carry is below the round-off of psi.
   *
   * @return index of the first point with det(I + H) <= 0, where the batch
   *   was left unfinished; n_points if there is none.
   */
  template <int dim>
  unsigned int
  conserving_stress(const Material<dim> &material, StressBatch<dim> &batch);
} // namespace emmy

#endif
