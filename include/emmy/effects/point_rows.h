#ifndef emmy_effects_point_rows_h
#define emmy_effects_point_rows_h

namespace emmy
{
  /**
   * The force of a point on the nodes of its group, as its place moves: plain
   * numbers of the point, and rows of numbers over the nodes, each n_padded
   * long, aligned, behind the nodes zeros. For MovingPlaces.
   *
   * The force at a node is S_A (w + lumped u_A) + T grad S_A, with the motion
   * Su in w and L in T. Rows with l = 0 are of S, with l = 1 + d of dS/dx_d.
   *
   * Cost for n nodes, with q = n_used, multiplications and additions:
   * q dim (2 dim + 3) n and dim^2 (dim + 1) (dim + q) n.
   */
  template <int dim>
  struct PointRows
  {
    static constexpr int nq = 2 * dim, n_weights = dim + 1;

    unsigned int n_padded;
    unsigned int n_used; ///< unknowns k of the place

    const double *u;            ///< [c]
    const double *weights;      ///< [l]
    const double *weights_by_q; ///< [k n_weights + l]
    double       *force_by_q;   ///< [k dim + i]
    double       *by_motion;    ///< [(i n_weights + l) dim + j]

    double w[dim], lumped;
    double consistent; ///< dw/d(Su)
    double w_by_q[nq][dim], T[dim][dim], T_by_q[nq][dim][dim];
    double tangent[dim * dim][dim * dim]; ///< dT/dL
    /** dq_k/d(Su)_j with l = 0, dq_k/dL_jd. */
    double by_motion_of_q[nq][dim][n_weights];

    /** How the force depends on the place. */
    void
    find_force_by_q() const;

    /**
     * How it depends on (Su)_j and L_jd, with the place that follows them.
     * @pre find_force_by_q()
     */
    void
    find_by_motion() const;
  };

  /**
   * Add by_motion times weights of some points, sum over l, to their matrix
   * over the nodes, [((i dim + j) n_padded + a) n_padded + b].
   */
  template <int dim>
  void
  add_products(const unsigned int n_points,
               const unsigned int n_padded,
               const double      *by_motion,
               const double      *weights,
               double            *sum);
} // namespace emmy

#endif
