#ifndef emmy_effects_node_coupling_h
#define emmy_effects_node_coupling_h

#include <emmy/particles/point_arrays.h>
#include <emmy/particles/stencils.h>

#include <emmy/system/couplings.h>

#include <string>

namespace emmy
{
  template <int dim>
  struct StepData;

  /**
   * What an effect makes of the nodes of a step: it couples them, or only looks
   * where the points are. See Effect::coupling(). All is collective, and does
   * nothing by default.
   */
  template <int dim>
  class NodeCoupling
  {
  public:
    virtual ~NodeCoupling() = default;

    /**
     * Once in a step, before the grid is made: what is found now is held for
     * as long as the step lasts.
     */
    virtual void
    classify(const Stencils<dim>       &stencils,
             const PointArrays<dim>    &points,
             const BackgroundGrid<dim> &grid)
    {
      (void)stencils;
      (void)points;
      (void)grid;
    }

    /** When stencils have other nodes or cells than before: add what couples.
     */
    virtual void
    couple(const Stencils<dim>           &stencils,
           const BackgroundGrid<dim>     &grid,
           const BoundaryConditions<dim> &boundary_conditions,
           Couplings<dim>                &couplings)
    {
      (void)stencils;
      (void)grid;
      (void)boundary_conditions;
      (void)couplings;
    }

    /**
     * Whether couple() keeps weights of nodes: then take_weights() is called
     * where points reach the nodes of before with other weights.
     */
    virtual bool
    couples_by_weights() const
    {
      return false;
    }

    /**
     * Take the weights of stencils that have the nodes of before.
     * @return whether what couple() told still holds, the same on all ranks;
     *   else couple() is called
     */
    virtual bool
    take_weights(const Stencils<dim> &stencils, const BackgroundGrid<dim> &grid)
    {
      (void)stencils;
      (void)grid;
      return true;
    }

    /**
     * Of a motion that solves the step: whether what classify() found is too
     * little for it. Then the step is solved again, and classify() is to find
     * more.
     * @return what is missing, the same on all ranks; empty: nothing
     */
    virtual std::string
    missing(const StepData<dim> &step, const Vector &displacement)
    {
      (void)step;
      (void)displacement;
      return "";
    }
  };
} // namespace emmy

#endif
