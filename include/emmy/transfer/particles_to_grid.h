#ifndef emmy_transfer_particles_to_grid_h
#define emmy_transfer_particles_to_grid_h

#include <deal.II/lac/trilinos_sparse_matrix.h>

#include <emmy/particles/field_layout.h>
#include <emmy/particles/point_arrays.h>
#include <emmy/transfer/active_grid.h>

#include <memory>

namespace emmy
{
  using Matrix = dealii::TrilinosWrappers::SparseMatrix;

  /** The particles of this rank as the step finds them, in stencil order. */
  template <int dim>
  PointArrays<dim>
  gather(const Stencils<dim> &stencils, const FieldLayout &layout);

  /** What the grid knows at the start of a step. */
  template <int dim>
  struct GridStart
  {
    /** The active nodes; null before the first step. */
    std::unique_ptr<const ActiveGrid<dim>> active;
    /** Effective mass M~ over all unknowns, without constraints, kg. */
    Matrix mass;
    /** The same with the essential conditions worked in: the map's matrix. */
    Matrix constrained_mass;
    /** Momentum p_A = sum m_p S_Ap v_p, kg m/s. */
    Vector momentum;
    /** Velocity v_t that solves M~ v = p under the constraints, m/s. */
    Vector velocity;
    /** The matrix that the map solves with. */
    const Matrix &
    map_matrix() const
    {
      return is_constrained ? constrained_mass : mass;
    }
    /** Whether any node of any rank is constrained. */
    bool is_constrained = false;
  };

  /**
   * Particles to grid: mass and momentum (Pretti et al. 2023, eqs 15, 26).
   * Owned by the step. Keeps the active nodes, the sparsity and the matrices
   * for as long as the stencils reach the same nodes.
   */
  template <int dim>
  class ParticlesToGrid
  {
  public:
    ParticlesToGrid(const BackgroundGrid<dim>     &grid,
                    const BoundaryConditions<dim> &boundary_conditions,
                    const FieldLayout             &layout);

    /**
     * Renew active nodes, mass and momentum. The velocity is left to the
     * caller, who has a linear solver. Collective.
     * @return valid until the next call
     */
    GridStart<dim> &
    operator()(const Stencils<dim> &stencils, const PointArrays<dim> &points);

  private:
    void
    assemble_mass(const Stencils<dim>    &stencils,
                  const PointArrays<dim> &points);
    void
    assemble_momentum(const Stencils<dim>    &stencils,
                      const PointArrays<dim> &points);

    const BackgroundGrid<dim>     &grid;
    const BoundaryConditions<dim> &boundary_conditions;
    const unsigned int             mass_component, velocity_component;
    GridStart<dim>                 start;
  };
} // namespace emmy

#endif
