#ifndef emmy_effects_starved_nodes_h
#define emmy_effects_starved_nodes_h

#include <emmy/base/effect_card.h>
#include <emmy/effects/aggregation.h>
#include <emmy/effects/effect.h>

namespace emmy
{
  /** Its name in the card of a scene and in the table of times. */
  constexpr const char *starved_nodes_effect = "aggregation";

  /**
   * `Method/Starved nodes` = follow: nodes that particles feed too little
   * follow others, see Aggregation. It has no force: it ties nodes of the grid.
   */
  template <int dim>
  class StarvedNodes : public Effect<dim>,
                       public NodeCoupling<dim>,
                       public StepMemory,
                       public StepMeasures<dim>
  {
  public:
    /** With the rule by which nodes starve. */
    explicit StarvedNodes(Aggregation<dim> aggregation);

    /** What `emmy --check` says of it. */
    static EffectCard
    card(const bool is_present);

    NodeCoupling<dim> *
    coupling() override;
    void
    classify(const Stencils<dim>       &stencils,
             const PointArrays<dim>    &points,
             const BackgroundGrid<dim> &grid) override;
    void
    couple(const Stencils<dim>           &stencils,
           const BackgroundGrid<dim>     &grid,
           const BoundaryConditions<dim> &boundary_conditions,
           Couplings<dim>                &couplings) override;

    /** How many follow, from how far, and the changes of class. */
    StepMeasures<dim> *
    measures() override;
    std::vector<StepMeasure>
    measure(const PointArrays<dim>    &points,
            const double               time,
            const BackgroundGrid<dim> &grid) override;
    /** Where starved nodes are worse off than ever before. */
    std::string
    finding() override;
    /** The classes of the last step, and the worst so far. */
    StepMemory *
    memory() override
    {
      return this;
    }
    std::vector<double>
    contents() const override;
    void
    recall(const std::vector<std::vector<double>> &parts) override;

  private:
    const Aggregation<dim> aggregation;
    NodeClasses<dim>       classes, classes_before; ///< of this step, the last
    Aggregates<dim>        found;
    /** Of the stencils that it was found for; not known once classes are
     * others. */
    std::vector<dealii::types::global_dof_index> node_ids;
    std::vector<ActiveCell<dim>>                 active_cells;
    bool                                         is_found = false;
    /** Of all steps. */
    std::uint64_t most_kept      = 0;
    double        largest_weight = 0.;
  };
} // namespace emmy

#endif
