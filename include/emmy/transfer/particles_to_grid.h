#ifndef emmy_transfer_particles_to_grid_h
#define emmy_transfer_particles_to_grid_h

#include <emmy/base/phases.h>
#include <emmy/particles/field_layout.h>
#include <emmy/particles/point_arrays.h>
#include <emmy/system/nodal_matrix.h>

#include <memory>

namespace emmy
{
  /** The particles of this rank as the step finds them, in stencil order. */
  template <int dim>
  PointArrays<dim>
  gather(const Stencils<dim> &stencils, const FieldLayout &layout);

  /** The same into arrays, which are made anew if their size is another. */
  template <int dim>
  void
  gather(const Stencils<dim> &stencils,
         const FieldLayout   &layout,
         PointArrays<dim>    &points);

  /** The same in the order of the places. */
  template <int dim>
  PointArrays<dim>
  gather(const Places<dim> &places, const FieldLayout &layout);

  /** The points of a step and the nodes that they talk to. */
  template <int dim>
  struct Ground
  {
    Stencils<dim>    stencils; ///< at the start of the step
    PointArrays<dim> points;   ///< states at t
  };

  /** How masses and velocities go to the grid and come back. */
  struct PointMapping
  {
    /** epsilon of M~ = (1 - epsilon) M + epsilon M_lumped (eq. 18). */
    double lumping = 0.;
    /** 1: FLIP (eq. 29), 0: PIC (eq. 28), between: a blend of both. */
    double flip_fraction = 1.;
  };

  /** Names of what costs when it is chosen, as cards and prices have them. */
  constexpr const char *lumping_effect = "lumping", *pic_effect = "PIC";

  /** Damping of the mass matrix in linear solvers, relative. */
  constexpr double mass_damping = 1e-13;

  /** What the grid knows at the start of a step. */
  template <int dim>
  struct GridStart
  {
    /**
     * The active nodes; null before the first step. Shared with an equation
     * whose places move: it carries its unknowns over from the grid before.
     */
    std::shared_ptr<const ActiveGrid<dim>> active;
    /** epsilon of M~, see PointMapping. */
    double lumping = 0.;
    /** Effective mass M~, without constraints, kg. */
    NodalMatrix<dim> mass;
    /**
     * What linear solvers add on the diagonal of M~, by local node, this
     * rank's share, kg: mass_damping times the lumped mass. M~ is singular
     * wherever a new cell holds fewer particles than it adds nodes. The
     * damping does not change any result: the map is refined until M~ v = p
     * holds to round-off, and Newton's residual knows only M~. Lumped, because
     * then a rigid translation remains one.
     */
    std::vector<double> damping;
    /** Momentum p_A = sum m_p S_Ap v_p, kg m/s. */
    Vector momentum;
    /**
     * Mean velocity of the particles that reach a node, weighted with m_p S_Ap,
     * m/s; it knows no essential conditions. Newton starts from it: exact in
     * free flight, and bounded where v_t, which extrapolates from few
     * particles, is not.
     */
    Vector mean_velocity;
    /** Velocity v_t of the step, which solves M~ v = p, m/s. */
    Vector velocity;
    /** See Couplings::hand_out_mass. */
    std::function<void(const ActiveGrid<dim> &, const MassReceiver &)>
      hand_out_mass = nullptr;

    /**
     * Add the damped mass with the constraints worked in, times a factor, to a
     * matrix of the unknowns, before NodeGraph::finish().
     */
    void
    add_mass_to(Matrix &jacobian, const double factor) const
    {
      mass.add_to(jacobian,
                  factor,
                  NodeGraph<dim>::Conditions::worked_in,
                  damping);
    }

    /** The mass that effects add, block by block. */
    void
    hand_out_added_mass(const MassReceiver &receive) const
    {
      if (hand_out_mass)
        hand_out_mass(*active, receive);
    }
  };

  /** Whether a mass is taken with its damping. */
  enum class Damped
  {
    yes,
    no
  };

  /**
   * M~ as a matrix of all unknowns, kg, for those who factorise it: it takes
   * dim^2 times the memory. Collective.
   */
  template <int dim>
  Matrix
  mass_of_unknowns(const GridStart<dim>                       &start,
                   const typename NodalMatrix<dim>::Conditions conditions,
                   const Damped                                damped);

  /** Row sums of M~ at the local nodes, kg. Collective. */
  template <int dim>
  std::vector<double>
  lumped_mass(const GridStart<dim> &start);

  /**
   * Particles to grid: mass and momentum (Pretti et al. 2023, eqs 15, 26).
   * Owned by the step. Keeps the active nodes, the sparsity and the matrices
   * for as long as the stencils reach the same nodes.
   */
  template <int dim>
  class ParticlesToGrid
  {
  public:
    /** Of a grid and the scene's fields. */
    ParticlesToGrid(const BackgroundGrid<dim>     &grid,
                    const BoundaryConditions<dim> &boundary_conditions,
                    const FieldLayout             &layout,
                    const PointMapping            &mapping,
                    Phases                        *phases = nullptr);

    /**
     * Renew active nodes, mass and momentum. The velocity is left to the
     * caller, who has a linear solver. Collective.
     * @param couplings what effects add to the grid
     * @return valid until the next call
     */
    GridStart<dim> &
    operator()(const Stencils<dim>    &stencils,
               const PointArrays<dim> &points,
               const Couplings<dim>   &couplings = Couplings<dim>());

    /** The same, with the mass left as it was. */
    GridStart<dim> &
    renew_but_for_mass(const Stencils<dim>    &stencils,
                       const PointArrays<dim> &points,
                       const Couplings<dim>   &couplings);
    /** Momentum and mean velocity, for stencils with the nodes of then. */
    GridStart<dim> &
    renew_momentum(const Stencils<dim>    &stencils,
                   const PointArrays<dim> &points);
    /** What the last renewal made. */
    GridStart<dim> &
    last()
    {
      return start;
    }
    /** The mass, on the active nodes of the last renewal. */
    void
    assemble_mass(const Stencils<dim>    &stencils,
                  const PointArrays<dim> &points);

  private:
    /** Momentum and mean velocity. */
    void
    assemble_momentum(const Stencils<dim>    &stencils,
                      const PointArrays<dim> &points);

    const BackgroundGrid<dim>     &grid;
    const BoundaryConditions<dim> &boundary_conditions;
    Phases *const                  phases; ///< for effects; may be null
    const unsigned int             mass_component, velocity_component;
    GridStart<dim>                 start;
  };
} // namespace emmy

#endif
