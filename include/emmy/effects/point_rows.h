#ifndef emmy_effects_point_rows_h
#define emmy_effects_point_rows_h

#include <emmy/effects/node_lanes.h>

namespace emmy
{
  /**
   * The force of a point on the nodes of its neighbourhood, as its place moves:
   * plain numbers of the point, and rows of numbers over the nodes, each
   * n_padded long, aligned. Only those registers of nodes are touched that the
   * point reaches; weights of other nodes in them are zero. For MovingPlaces.
   *
   * The force at a node is S_A (w + lumped u_A) + T grad S_A, with the motion
   * Su in w and L in T. Numbers with l = 0 are of S and Su, with l = 1 + d of
   * dS/dx_d and column d of L.
   *
   * Cost for n nodes, with q = n_used, multiplications and additions:
   * q dim (3 dim + 5) n and dim^2 (dim + 1) (dim + q) n; of q = dim, where a
   * point is in one cell, the last q counts for l = 0 alone.
   */
  template <int dim>
  struct PointRows
  {
    /** Coordinates of a particle's place, and rows of weights. */
    static constexpr int nq = 2 * dim, n_weights = dim + 1;

    unsigned int  n_padded;  ///< nodes, rounded up to whole registers
    std::uint64_t registers; ///< a bit for each that the point reaches
    /** The coordinates of the place that count; first those of the position. */
    unsigned int n_used, used[nq]; ///< coordinates that move, and which

    const double *u;            ///< [c]
    const double *weights;      ///< [l]
    const double *weights_by_q; ///< [k n_weights + l], all coordinates
    /** The force by (Su)_j and L_jd: [(i n_weights + l) dim + j]. */
    double *by_motion;
    double *share;    ///< the change of the force with shift is added, [i]
    double *diagonal; ///< what stands on the diagonal alone is added

    double Su[dim];                         ///< sum over nodes of S u, m
    double motion_by_q[nq][n_weights][dim]; ///< of used k; l; component

    /** Factors of the weights' derivatives. */
    double w[dim], lumped;
    double consistent;                    ///< dw/d(Su)
    double T[dim][dim];                   ///< stress times volume
    double tangent[dim * dim][dim * dim]; ///< dT/dL
    /** Times S_A, and the least of all nodes. */
    double on_diagonal, least;
    /** Of used k: the way to the place, and dq_k/d(Su)_j, dq_k/dL_jd. */
    double shift[nq], by_motion_of_q[nq][dim][n_weights];

    /** Su, and how the motion depends on the place. */
    void
    find_motion();

    /**
     * The rows of by_motion, with the place that follows the motion, share
     * and diagonal.
     */
    void
    find_rows() const;
  };

  /**
   * Add by_motion times weights of some points, sum over l, to their matrix
   * over the nodes, [((i dim + j) n_padded + a) n_padded + b].
   * @param is_first whether the matrix is to begin with these points
   */
  template <int dim>
  void
  add_products(const Reach       &reach,
               const unsigned int n_nodes,
               const bool         is_first,
               const double      *by_motion,
               const double      *weights,
               double            *sum);
} // namespace emmy

#endif
