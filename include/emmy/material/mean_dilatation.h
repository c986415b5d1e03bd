#ifndef emmy_material_mean_dilatation_h
#define emmy_material_mean_dilatation_h

#include <emmy/material/stress_rules.h>

namespace emmy
{
  /**
   * What one point and its cell tell each other in a step with mean dilatation
   * (MeanDilatationStress). All is relative to the configuration at t.
   */
  template <int dim>
  struct CellPoint
  {
    /** Components of a symmetric tensor. */
    static constexpr unsigned int m = n_in_plane<dim>;

    // in
    /** V_p/V0_p at t: det F of the true motion. */
    double volume_ratio = 1.;
    /** j - 1, with j = det(I + H): see volume_change(). */
    double own_change = 0.;
    /** theta - 1: the mean of j - 1 over the cell, weighted with V_p. */
    double mean_change = 0.;

    // out of own_stress()
    /** Pi: the share of the cell's mean stress, Pa per undeformed volume. */
    double mean_stress = 0.;
    /** tr tau/3 at t + dt, Pa. */
    double mean_stress_end = 0.;
    /** S', the stress but for the mean stress of the cell, Pa. */
    dealii::Tensor<1, m> S;

    // likewise, only with tangent
    dealii::Tensor<2, m> S_by_C;                   ///< 2 dS'/dC
    dealii::Tensor<1, m> S_by_mean;                ///< dS'/d theta
    dealii::Tensor<1, m> mean_stress_by_C;         ///< 2 dPi/dC
    double               mean_stress_by_mean = 0.; ///< dPi/d theta
  };

  /** How a point and its cell depend on each other, in terms of P and H. */
  template <int dim>
  struct CellLink
  {
    /** Of the point's nominal stress P. */
    dealii::Tensor<2, dim> stress_by_mean_stress, stress_by_mean;
    /** j_H and Pi_H: what the point's H does to its own ratio and to Pi. */
    dealii::Tensor<2, dim> change_by_H, mean_stress_by_H;
  };

  /**
   * The stress of a step in which the volume of all particles of a cell
   * changes alike, as far as their material sees: low-order functions do not
   * lock then. With the mean ratio theta of the cell's particles in place of
   * each one's own ratio j, the material's trial is
   * @f[ \Delta\bar F = (\theta/j)^{1/3} \Delta F, \qquad
   *     \theta - 1 = \frac1{V_c} \sum_q V_q (j_q - 1), \quad
   *     V_c = \sum_q V_q, @f]
   * in all three directions, also in plane strain. The energy of the step
   * couples the particles of a cell, and its discrete gradient has two stages:
   * the points' energies depend on C_p and theta, and j - 1 = D : A exactly
   * with a tensor D(C). Derivation: doc/locking.md.
   *
   * conserving: with p = tr tau/3, A = Delta F^T Delta F - I and the metric
   * <X, Y> = X : b^e_t Y b^e_t, in which the flow of before has no part,
   * @f[ \bar S = \tfrac12(\mathrm{dev}\,\tau_t +
   *       \Delta F^{-1}\mathrm{dev}\,\tau\,\Delta F^{-T}),\quad
   *     \bar\Pi = \tfrac12(p_t + p/\theta),\quad
   *     \eta = 2(\Delta\psi + \Delta D) - \bar S : A - 2\bar\Pi(\theta-1), @f]
   * @f[ A_d = A - I\,\frac{\langle I,A\rangle}{\langle I,I\rangle},\quad
   *     \kappa = \tfrac49\langle I,I\rangle,\quad
   *     \nu = \langle A_d,A_d\rangle + \kappa(\theta-1)^2,\quad
   *     S' = \bar S + \tfrac\eta\nu\, b^e_t A_d b^e_t,\quad
   *     \Pi = \bar\Pi + \tfrac{\kappa\eta}{2\nu}(\theta-1), @f]
   * @f[ P_c = \frac1{V_c}\sum_q V^0_q \Pi_q,\qquad
   *     S = S' + 2\,\frac{V}{V^0}\,P_c\,D,\qquad P = \tfrac12(I+\Delta F)S, @f]
   * so that sum V0 P : H over a cell is the change of energy plus dissipation
   * to round-off. at rest: the derivative of that energy at the end of the
   * step, S' = Delta F^-1 dev tau Delta F^-T, Pi = p/theta, and j C^-1 in
   * place of 2 D; P = Delta F S.
   *
   * Used by the force of the treatment, first own_stress() for the points of
   * all cells, then whole_stress(). Cost: with tangent some 4000
   * multiplications a point in space.
   */
  template <int dim>
  class MeanDilatationStress
  {
  public:
    /** Of which the mean is taken. */
    enum class Kind
    {
      conserving,
      at_rest
    };

    /** Of one kind. */
    explicit MeanDilatationStress(const Kind kind);

    /**
     * The states of a batch at t + dt, and the points' own part of the
     * stress. Of the batch's out fields the nominal stress and its tangent are
     * left.
     * @param points in and out, one per point
     * @pre   j > 0 and theta > 0
     */
    void
    own_stress(const Material<dim> &material,
               StressBatch<dim>    &batch,
               CellPoint<dim>      *points) const;

    /**
     * P of point @p p and, with_tangent, its derivative at a given theta and
     * cell stress.
     * @param cell_stress P_c, Pa
     * @return the derivatives with respect to these; only with_tangent
     */
    CellLink<dim>
    whole_stress(const CellPoint<dim> &point,
                 const double          cell_stress,
                 const unsigned int    p,
                 StressBatch<dim>     &batch) const;

  private:
    void
    conserve(const Material<dim> &material,
             StressBatch<dim>    &batch,
             const unsigned int   p,
             CellPoint<dim>      &point) const;

    const Kind kind;
  };

  /** det(I + H) - 1, without cancellation. */
  template <int dim>
  double
  volume_change(const dealii::Tensor<2, dim> &H);
} // namespace emmy

#endif
