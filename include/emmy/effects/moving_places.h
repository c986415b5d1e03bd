#ifndef emmy_effects_moving_places_h
#define emmy_effects_moving_places_h

#include <deal.II/base/aligned_vector.h>

#include <emmy/effects/cell_matrix.h>
#include <emmy/effects/effect.h>
#include <emmy/effects/point_rows.h>
#include <emmy/material/middle_step.h>
#include <emmy/transfer/domain_update.h>

namespace emmy
{
  /** What decides how places of particles follow the nodes; borrowed. */
  template <int dim>
  struct PlaceRules
  {
    const ShapeFunctions<dim> &shape_functions; ///< of the scene
    const DomainUpdate<dim>   *domain_update;   ///< null: boxes stay
    const BackgroundGrid<dim> &grid;            ///< of the scene
    const FieldLayout         &layout;          ///< of the scene
    const PointMapping        &mapping;         ///< from particles to grid
  };

  /**
   * The places of the particles in the middle of a step, positions x and
   * half-lengths l of boxes, as unknowns beside the nodes' displacements u.
   * They shall satisfy
   * @f[ q = Q(u, q) = \bigl(x_t + \tfrac12 \textstyle\sum_A S_A(q) u_A,\;
   *     l(Z F_t)\bigr), \qquad Z = (I - \tfrac12 L)^{-1}, @f]
   * and Newton eliminates them particle by particle: with
   * @f$ \delta q = (I - Q_q)^{-1} (Q_u \delta u + Q - q) @f$ the matrix of the
   * nodes becomes @f$ J + r_q (I - Q_q)^{-1} Q_u @f$ and the residual
   * @f$ r + r_q (I - Q_q)^{-1} (Q - q) @f$. A particle knows of the nodes only
   * its own motion, sum S_B u_B and L: so its share of J and of the rest is
   * one matrix of few columns times S_B and grad S_B, and the pattern of the
   * matrix stays. Derived in doc/method.md.
   *
   * Made for each iteration; the internal force calls add() for its batches.
   * Cost in an evaluation: about that of the stiffness of the points.
   */
  template <int dim>
  class MovingPlaces
  {
  public:
    /** Points, and what the internal force found there. */
    struct Points
    {
      const StepData<dim>        &step;   ///< at the latest places
      const NeighbourPoints<dim> &here;   ///< of one neighbourhood
      const StressBatch<dim>     &batch;  ///< S-hat and dS-hat/dL of the middle
      const MiddleStep<dim>      &middle; ///< from t to the middle
      const double *volumes; ///< reference volumes of the batch, m^3
      /** By what the boxes are scaled beyond what Z says; null: by nothing. */
      const double *box_scales = nullptr;
    };

    /** Coordinates of a particle: position and half-lengths. */
    static constexpr auto nq = PlaceDerivatives<dim>::n;

    /** How the place of a point answers to its motion. */
    struct Response
    {
      dealii::Tensor<1, nq> shift; ///< (I - Q_q)^-1 (Q - q), m
      /** dq_k/d(Su)_j, and behind it dq_k/dL_jd: [k][j]. */
      std::array<std::array<dealii::Tensor<1, dim + 1>, dim>, nq> by_motion;
    };

    /** @param places in the order of the particle handler; borrowed */
    MovingPlaces(const PlaceRules<dim> &rules, const Places<dim> &places);

    /** Before an evaluation: the forces that loads put on the points. */
    void
    begin(const StepData<dim> &step, std::vector<double> point_forces);

    /** Before the points of a neighbourhood, of @p u at the local nodes, m. */
    void
    begin_neighbourhood(const Neighbourhood<dim>  &around,
                        const std::vector<double> &u);

    /**
     * Add the derivative of the points' inertia and stress with respect to
     * the nodes, J + r_q (I - Q_q)^-1 Q_u, to the matrix of their
     * neighbourhood.
     */
    void
    add(const Points &points);

    /** That matrix, after the last of its points; until the next begins. */
    ComponentBlocks
    finish_neighbourhood(const Neighbourhood<dim> &around);

    /** r_q (I - Q_q)^-1 (Q - q) at the local nodes, [dim * node + c], N. */
    const std::vector<double> &
    residual_share() const;

    /**
     * For other forces on few points, after add() for all: how the place of a
     * point answers, and how its weights change with it; and their part of
     * residual_share(), [dim * node + c], N.
     */
    const Response &
    response_of(const std::size_t p) const
    {
      return responses[p];
    }
    /** Derivatives of particle q's share with respect to its place. */
    void
    differentiate(const StepData<dim>                 &step,
                  const typename Stencils<dim>::Group &group,
                  const unsigned int                   q,
                  PlaceDerivatives<dim>               &result) const
    {
      rules.shape_functions.differentiate(
        places,
        step.stencils.order[group.first_point + q],
        group,
        rules.grid,
        result);
    }
    /** Unknowns of a place: its position, with boxes their half-lengths. */
    unsigned int
    n_place_unknowns() const
    {
      return has_boxes ? nq : dim;
    }
    /** Into the rows of the nodes of the cell. */
    void
    add_to_share(const std::vector<double> &local);

    /** For largest_defect() after an evaluation without a derivative. */
    void
    find_defect(const StepData<dim>       &step,
                const std::vector<double> &local_displacement);

    /** The largest x - Q of a position on this rank, in cells. */
    double
    largest_defect() const;

    /**
     * The places after an increment of the displacement; in the grid.
     * @param increment at the local nodes, m
     */
    Places<dim>
    moved(const StepData<dim>       &step,
          const std::vector<double> &increment) const;

  private:
    using Group  = typename Stencils<dim>::Group;
    using Vector = dealii::Tensor<1, dim>;

    /** Rows of numbers by node of a group, behind them zeros to full lanes. */
    using Rows = dealii::AlignedVector<double>;

    /** Work arrays: of a neighbourhood, of some points of it, and of one. */
    struct Work
    {
      unsigned int n_nodes = 0, n_padded = 0;
      bool         is_empty = true; ///< no points of it yet
      Reach        reach;           ///< of some points
      Rows         u;               ///< by component
      Rows         sum;             ///< [((a dim + i) n_padded + b) dim + j]
      Rows         share, diagonal; ///< see PointRows

      /** S, grad S, [q (dim + 1) + l]. */
      Rows weights;
      /**
       * The force by the motion of the point, (Su)_j and L_jd, as its place
       * follows: [((q dim + i) (dim + 1) + l) dim + j].
       */
      Rows by_motion;

      PlaceDerivatives<dim> derivatives;
      Rows                  weights_by_q; ///< the same for all the nodes
    };

    /**
     * How all points of a group move, Su and the columns of L after it:
     * [(l dim + component) n_points + q], m and 1.
     * @param u at the local nodes, m
     */
    void
    find_motions(const StepData<dim>       &step,
                 const Group               &group,
                 const std::vector<double> &u,
                 const bool                 with_gradients,
                 std::vector<double>       &motion) const;

    /** Weights of the points, node by node, and whom they reach. */
    void
    set_weights(const NeighbourPoints<dim> &here);

    /** How the weights of a point change with its place, node by node. */
    void
    set_weights_by_place(const NeighbourPoints<dim> &here,
                         const unsigned int          at);

    /** @param at its index among the points */
    void
    add_point(const Points &points, const unsigned int at);

    /** @pre point.find_motion() */
    Response
    response(const Points         &points,
             const unsigned int    at,
             const PointRows<dim> &point);

    /** What the force of a point at the nodes is made of. */
    void
    set_force(const Points      &points,
              const unsigned int at,
              PointRows<dim>    &point) const;

    const PlaceRules<dim> rules;
    const Places<dim>    &places;
    const unsigned int    mass, velocity;
    std::vector<double>   point_forces; ///< [dim * p + c], or empty
    std::vector<Response> responses;    ///< by point
    std::vector<double>   share;
    double                defect = 0.;
    /** Whether boxes follow too: places have nq unknowns, not dim. */
    const bool has_boxes;
    Work       work;
  };
} // namespace emmy

#endif
