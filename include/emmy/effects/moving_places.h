#ifndef emmy_effects_moving_places_h
#define emmy_effects_moving_places_h

#include <deal.II/lac/full_matrix.h>

#include <emmy/effects/effect.h>
#include <emmy/material/stress_rules.h>
#include <emmy/transfer/domain_update.h>

namespace emmy
{
  /** What decides how places of particles follow the nodes; borrowed. */
  template <int dim>
  struct PlaceRules
  {
    const ShapeFunctions<dim> &shape_functions;
    const DomainUpdate<dim>   *domain_update; ///< null: boxes stay
    const BackgroundGrid<dim> &grid;
    const FieldLayout         &layout;
    const PointMapping        &mapping;
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
   * @f$ r + r_q (I - Q_q)^{-1} (Q - q) @f$. Both are of rank 2 dim for each
   * particle, so the pattern of the matrix stays. Derived in doc/method.md.
   *
   * Made for each iteration; the internal force calls add() for its batches.
   * Cost in an evaluation: that of the stiffness of the points once or twice.
   */
  template <int dim>
  class MovingPlaces
  {
  public:
    /** @param places in the order of the particle handler; borrowed */
    MovingPlaces(const PlaceRules<dim> &rules, const Places<dim> &places);

    /** Before an evaluation: the forces that loads put on the points. */
    void
    begin(const StepData<dim> &step, std::vector<double> point_forces);

    /**
     * Add what the points of a batch do as their places follow.
     *
     * @param first      first point of the batch in its group
     * @param batch      with L, S-hat and dS-hat/dL of the middle
     * @param from_start Z of point q of the batch
     * @param volumes    reference volumes of the batch, m^3
     * @param stiffness  of the group, gets r_q (I - Q_q)^-1 Q_u
     */
    void
    add(const StepData<dim>                 &step,
        const std::vector<double>           &local_displacement,
        const typename Stencils<dim>::Group &group,
        const unsigned int                   first,
        const StressBatch<dim>              &batch,
        const dealii::Tensor<2, dim>        *from_start,
        const double                        *volumes,
        dealii::FullMatrix<double>          &stiffness);

    /** r_q (I - Q_q)^-1 (Q - q) at the local nodes, [dim * node + c], N. */
    const std::vector<double> &
    residual_share() const;

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
    using Group              = typename Stencils<dim>::Group;
    using Vector             = dealii::Tensor<1, dim>;
    static constexpr auto nq = PlaceDerivatives<dim>::n;

    /** How the place of a point answers to the nodes. */
    struct Response
    {
      dealii::Tensor<2, nq> inverse; ///< (I - Q_q)^-1
      dealii::Tensor<1, nq> defect;  ///< Q - q, m
      MiddleBox<dim>        box;
    };

    /** Work arrays of one point. */
    struct Work
    {
      PlaceDerivatives<dim> derivatives;
      std::vector<Vector>   force_by_q; ///< r_A,k: [a * nq + k]
      std::vector<double>   q_by_u; ///< dq_k/du_bj: [(k * n_nodes + b) dim + j]
    };

    void
    add_point(const StepData<dim>          &step,
              const std::vector<double>    &u,
              const Group                  &group,
              const unsigned int            q,
              const StressBatch<dim>       &batch,
              const unsigned int            in_batch,
              const dealii::Tensor<2, dim> &Z,
              const double                  volume,
              dealii::FullMatrix<double>   &stiffness);

    /** Q - q, and (I - Q_q)^-1 from the changes N,k of Su and L,k of L. */
    void
    respond(const StepData<dim>                          &step,
            const Group                                  &group,
            const std::size_t                             p,
            const Vector                                 &Su,
            const std::array<Vector, nq>                 &Su_by_q,
            const std::array<dealii::Tensor<2, dim>, nq> &L_by_q,
            const dealii::Tensor<2, dim>                 &Z);

    void
    add_to_matrix(const Stencils<dim>        &stencils,
                  const Group                &group,
                  const unsigned int          q,
                  const Response             &response,
                  dealii::FullMatrix<double> &stiffness);

    const PlaceRules<dim> rules;
    const Places<dim>    &places;
    const unsigned int    mass, velocity;
    std::vector<double>   point_forces; ///< [dim * p + c], or empty
    std::vector<Response> responses;    ///< by point
    std::vector<double>   share;
    double                defect = 0.;
    Work                  work;
  };
} // namespace emmy

#endif
