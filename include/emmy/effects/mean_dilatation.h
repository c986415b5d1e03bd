#ifndef emmy_effects_mean_dilatation_h
#define emmy_effects_mean_dilatation_h

#include <emmy/effects/cell_pools.h>
#include <emmy/effects/stress_states.h>
#include <emmy/material/mean_dilatation.h>
#include <emmy/material/middle_step.h>

#include <memory>

namespace emmy
{
  /** The name of the treatment, in cards and in the table of times. */
  constexpr const char *mean_dilatation_effect = "locking treatment";

  /** The field with det F - 1 of a particle's own motion. */
  constexpr const char *own_volume_field = "own_volume_ratio_less_one";

  /** The field with the mean Cauchy stress of a particle's cell. */
  constexpr const char *cell_mean_stress_field = "cell_mean_stress";

  /**
   * The internal force of a step in which the volume of all particles of a
   * cell and a material changes alike: see MeanDilatationStress. In place of
   * InternalForce where a scene asks for it. A particle counts to the cell
   * that holds it at the start of the step, on the rank that has both: there
   * are no messages. Its volume V_p is that of the true motion: that of the
   * scaled one, as its stress sees it, would let noise grow.
   *
   * Its derivative is that of points whose cells' theta and P_c stay, and for
   * each cell two products of vectors over the nodes that its particles reach:
   * with theta' = t . u' and P_c' = (pi + x t) . u',
   * @f[ s \otimes t + n \otimes (\pi + x\, t), \quad
   *     s = \sum V^0 P_{,\theta} g,\; n = \sum V^0 P_{,P_c} g,\;
   *     t = \sum \frac{V}{V_c} j_{,H} g,\;
   *     \pi = \sum\frac{V^0}{V_c} \Pi_{,H} g,\;
   *     x = \sum\frac{V^0}{V_c} \Pi_{,\theta} . @f]
   * Where places are unknowns, t and pi are of their motion too. These nodes
   * are coupled.
   *
   * Cost in an evaluation: three passes over the points; per cell with n nodes
   * 2 dim^2 n^2 multiplications. Some 100 numbers a point in space are kept
   * from one pass to the next.
   */
  template <int dim>
  class MeanDilatation : public ForceTerm<dim>, public NodeCoupling<dim>
  {
  public:
    /** Which stress it averages. */
    using Kind = typename MeanDilatationStress<dim>::Kind;

    /**
     * As those of InternalForce.
     * @param is_averaged one per body; the points of others keep their own
     *   volumes. Empty: all are.
     */
    MeanDilatation(std::vector<const Material<dim> *> material_of_body,
                   FieldLayout                       &layout,
                   const Kind                         kind,
                   std::vector<std::string>           names       = {},
                   std::vector<bool>                  is_averaged = {});

    /** What `emmy --check` says of it. */
    static EffectCard
    card(const bool is_present);

    NodeCoupling<dim> *
    coupling() override
    {
      return this;
    }
    /**
     * Where points flow: whether one does decides on the pressure of its whole
     * cell, and Newton can run in circles.
     */
    bool
    has_kinks() const override;
    /** Finds which points share a cell and a material, and their nodes. */
    void
    couple(const Stencils<dim>           &stencils,
           const BackgroundGrid<dim>     &grid,
           const BoundaryConditions<dim> &boundary_conditions,
           Couplings<dim>                &couplings) override;

    std::string
    add(const StepData<dim> &step,
        const Iterate<dim>  &iterate,
        Vector              &force,
        Matrix              *jacobian) const override;

    /** Those of the states; and stress_rule_loss in static steps. */
    std::vector<EnergyEntry>
    energies(const StepData<dim>    &step,
             const Vector           &displacement,
             const PointArrays<dim> &accepted) const override;
    std::vector<EnergyEntry>
    energy_entries() const override;

  private:
    /** What add() works on and with; as long as the points stay. */
    struct Work
    {
      CellPools<dim>                      cells;
      std::vector<CellPoint<dim>>         points;
      std::vector<CellLink<dim>>          links;
      std::vector<dealii::Tensor<2, dim>> gradients; ///< L
      std::vector<double>                 box_scales;

      StressBatch<dim>    batch;
      MiddleStep<dim>     middle;
      std::vector<double> nodal_force;
      double              energy = 0.; ///< sum V0 P : H of the last add(), J
    };

    /** The passes of add(). @return what is wrong, if anything */
    std::string
    find_ratios(const StepData<dim> &step, const Iterate<dim> &iterate) const;
    std::string
    find_own_stresses(const StepData<dim> &step,
                      const Iterate<dim>  &iterate) const;
    void
    add_stresses(const StepData<dim> &step,
                 const Iterate<dim>  &iterate,
                 Matrix              *jacobian) const;
    /** The products of the cells. */
    void
    add_cells(const StepData<dim> &step,
              const Iterate<dim>  &iterate,
              Matrix              &jacobian) const;
    /** P and its derivatives of the points from @p point on, of the batch. */
    void
    find_whole_stresses(const StepData<dim> &step,
                        const std::size_t    point) const;
    /** Points into the batch, with the gradients as they are. */
    void
    begin_batch(const PointBatch<dim> &points) const;

    const Kind                               kind;
    const MeanDilatationStress<dim>          rule;
    const StressStates<dim>                  states;
    const unsigned int                       volume_ratio_less_one, mean_stress;
    const std::vector<const Material<dim> *> material_of_body;
    const std::vector<bool>                  is_averaged; // by body, or none
    const std::unique_ptr<Work>              work;
  };
} // namespace emmy

#endif
