#ifndef emmy_effects_ghost_stabilisation_h
#define emmy_effects_ghost_stabilisation_h

#include <emmy/effects/effect.h>
#include <emmy/effects/ghost_faces.h>

namespace emmy
{
  /** Section `Effects/Ghost stabilisation`. */
  template <int dim>
  class GhostParameters : public EffectParameters<dim>
  {
  public:
    /** Declares the entries of a section. */
    explicit GhostParameters(const std::string &section);

    void
    add_to(Effects<dim> &effects, FieldLayout &layout) const override;

    /** What `emmy --check` says of it. */
    static EffectCard
    card();

  private:
    double mass_penalty = 0.25, stiffness_penalty = 0.01; // gamma_M, gamma_K
  };

  /**
   * Ghost stabilisation (Burman 2010; Sticko et al. 2020; formulation of Coombs
   * 2023): penalties on differences of slopes across the faces at the boundary
   * of a body. Its mass G is part of M~. Its stiffness, f = K_G u/2 on the
   * displacement of the step at its mid-point, keeps no memory, so that
   * u.K_G u/2 is lost in each step.
   */
  template <int dim>
  class GhostStabilisation : public Effect<dim>,
                             public AddedMass<dim>,
                             public NodeCoupling<dim>
  {
  public:
    /** With the faces that it acts on. */
    explicit GhostStabilisation(GhostFaces<dim> find);

    NodeCoupling<dim> *
    coupling() override;
    /** Finds the faces, whose nodes meet. */
    void
    couple(const Stencils<dim>           &stencils,
           const BackgroundGrid<dim>     &grid,
           const BoundaryConditions<dim> &boundary_conditions,
           Couplings<dim>                &couplings) override;
    const AddedMass<dim> *
    added_mass() const override;
    void
    hand_out(const ActiveGrid<dim> &active,
             const MassReceiver    &receive) const override;
    double
    kinetic_energy(const ActiveGrid<dim> &active,
                   const Vector          &velocity) const override;
    std::string
    loss_column() const override;

    bool
    is_force() const override;
    std::string
    add(const StepData<dim> &step,
        const Iterate<dim>  &iterate,
        Vector              &force,
        Matrix              *jacobian) const override;
    /** ghost_stiffness_loss. */
    std::vector<EnergyEntry>
    energies(const StepData<dim>    &step,
             const Vector           &displacement,
             const PointArrays<dim> &accepted) const override;
    std::vector<EnergyEntry>
    energy_entries() const override;

  private:
    /**
     * sum over this rank's faces of coefficient v.J v, the coefficient being
     * GhostFace::mass or GhostFace::stiffness. Collective.
     */
    double
    product(const ActiveGrid<dim> &active,
            const Vector          &v,
            double GhostFace<dim>::*coefficient) const;
    /** Local indices of the nodes of a face. */
    const unsigned int *
    nodes(const ActiveGrid<dim> &active, const unsigned int face) const;

    const GhostFaces<dim>       find;
    std::vector<GhostFace<dim>> faces;          ///< of the step
    std::size_t                 first_node = 0; ///< theirs in Couplings
    /** J of a face by its direction, m^dim. */
    std::array<dealii::FullMatrix<double>, dim> matrices;
  };
} // namespace emmy

#endif
