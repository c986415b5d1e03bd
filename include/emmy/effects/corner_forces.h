#ifndef emmy_effects_corner_forces_h
#define emmy_effects_corner_forces_h

#include <emmy/effects/effect.h>

namespace emmy
{
  /** What the particles of a body are to a tool. */
  template <int dim>
  struct ParticleCorners
  {
    dealii::Tensor<1, dim> half_length; ///< of the box at the start, m
    double                 spacing;     ///< m
    double                 stiffness;   ///< M s^(dim-2) / 2^(dim-1), N/m

    static constexpr unsigned int n = 1u << dim; ///< corners of a box

    /** xi of a corner: its place in the undeformed box, m. */
    dealii::Tensor<1, dim>
    operator[](const unsigned int corner) const
    {
      dealii::Tensor<1, dim> result = half_length;
      for (unsigned int d = 0; d < dim; ++d)
        if (!(corner >> d & 1))
          result[d] *= -1.;
      return result;
    }
  };

  /** How a particle moves in a step, and its corners with it. */
  template <int dim>
  struct CornerMotion
  {
    std::size_t                 p;        ///< among the points
    const ParticleCorners<dim> *corners;  ///< the particle's
    dealii::Point<dim>          place;    ///< at t, m
    dealii::Tensor<1, dim>      way;      ///< S u, m
    dealii::Tensor<2, dim>      gradient; ///< L
    /** Deformation gradient at the start of the step. */
    dealii::Tensor<2, dim> F_old;
    /** Of the arms a = F xi: F_old, or that of the middle, Z F_old. */
    dealii::Tensor<2, dim> F;
    dealii::Tensor<2, dim> Z; ///< of the middle; else zero

    /** F and Z from F_old and L. */
    void
    find_arms(const bool at_middle);
    /** F at t + dt. */
    dealii::Tensor<2, dim>
    F_new() const
    {
      return F_old + gradient * F;
    }
    /** What a corner moves by, m. */
    dealii::Tensor<1, dim>
    way_of(const dealii::Tensor<1, dim> &arm) const
    {
      return way + gradient * arm;
    }
  };

  /** F of the particles, as domain updates ask for it. */
  template <int dim>
  Field
  deformation_gradient_field();

  /** Those of the scene's bodies. */
  template <int dim>
  std::vector<ParticleCorners<dim>>
  corners_of_bodies(const Effects<dim> &effects);

  /** A tensor field of a point. */
  template <int dim>
  dealii::Tensor<2, dim>
  tensor_field(const PointArrays<dim> &points,
               const unsigned int      first,
               const std::size_t       p);

  /**
   * The motion of point @p q of a group.
   * @param deformation_gradient where the points keep F
   */
  template <int dim>
  CornerMotion<dim>
  corner_motion(const StepData<dim>                 &step,
                const typename Stencils<dim>::Group &group,
                const unsigned int                   q,
                const std::vector<double>           &local_displacement,
                const ParticleCorners<dim>          &corners,
                const unsigned int                   deformation_gradient);

  /** Components of (S u, L), or of (f, f (x) a): [(dim + 1) i + l]. */
  template <int dim>
  using PointMotion = std::array<double, dim *(dim + 1)>;

  /**
   * How the motion z = (S u, L) of a point changes with that of its nodes,
   * where its place follows them: dz = by_nodes (W du) + shift, with W the
   * weights S and grad S. The unit matrix and zero where places stay.
   */
  template <int dim>
  struct FollowedMotion
  {
    /** How the corner moves with the nodes' displacements. */
    std::array<PointMotion<dim>, dim *(dim + 1)> by_nodes;
    /** How it moves with the particle's centre. */
    PointMotion<dim> shift;
  };

  /** Of point @p q of a group, in an evaluation with derivatives. */
  template <int dim>
  FollowedMotion<dim>
  followed_motion(const StepData<dim>                 &step,
                  const typename Stencils<dim>::Group &group,
                  const unsigned int                   q,
                  const std::vector<double>           &local_displacement);

  /**
   * Forces on corners, handed to the nodes: f at the arm a of a particle acts
   * as (S_A + g_A.a) f. It is summed up by particle, as f and f (x) a, with
   * its derivative by S u and L: a corner moves by dy = S u + L a, and an arm
   * of the middle by da = Z dL a/2. Where places follow the nodes, the force
   * follows them too: with W the weights S and g and their derivatives W,k,
   * G = (f, f (x) a), E = dG/dz, and dq = shift + R dz of MovingPlaces,
   * dr = -(W E (dz + z,k dq_k) + W,k G dq_k).
   *
   * Made for an evaluation. Cost: for each particle with a force that of its
   * stiffness.
   */
  template <int dim>
  class CornerForces
  {
  public:
    /** Particles of one body in one cell. */
    using Group = typename Stencils<dim>::Group;

    /** @param jacobian null: not wanted. Borrows all. */
    CornerForces(const StepData<dim>       &step,
                 const std::vector<double> &local_displacement,
                 Matrix                    *jacobian);

    /**
     * Add a force on a corner of the particle that is looked at.
     * @param derivative of the force by the way of the corner, N/m
     */
    void
    add(const CornerMotion<dim>      &particle,
        const dealii::Tensor<1, dim> &arm,
        const dealii::Tensor<1, dim> &force,
        const dealii::Tensor<2, dim> &derivative);
    /**
     * Add forces on the particle that is looked at, f and f (x) a, and how they
     * change with its motion.
     */
    void
    add(const PointMotion<dim>                             &forces,
        const std::array<PointMotion<dim>, dim *(dim + 1)> &by_motion);
    /**
     * Hand the forces on a particle to its nodes, and begin another one.
     * @param followed null: not wanted; else followed_motion() of a particle
     *   with forces, in an evaluation with derivatives whose places move
     */
    void
    finish(const Group         &group,
           const unsigned int   q,
           FollowedMotion<dim> *followed = nullptr);
    /** Hand the derivatives of a group to the matrix. */
    void
    finish(const Group &group);
    /** Subtract the forces from @p force. Collective. */
    void
    finish(Vector &force);

  private:
    static constexpr unsigned int n_motion = dim * (dim + 1);
    using Motion                           = PointMotion<dim>;

    void
    follow_places(const Group         &group,
                  const unsigned int   q,
                  FollowedMotion<dim> *followed);

    const StepData<dim>       &step;
    const std::vector<double> &displacement;
    Matrix *const              jacobian;
    std::vector<double>        nodal_force, share;
    // of the particle
    bool                         acts = false;
    Motion                       value{};
    std::array<Motion, n_motion> by_motion{};
    // of its group
    bool                       has_matrix = false;
    dealii::FullMatrix<double> matrix;
    PlaceDerivatives<dim>      by_place;
    std::vector<Motion>        along; ///< by node and component
  };
} // namespace emmy

#endif
