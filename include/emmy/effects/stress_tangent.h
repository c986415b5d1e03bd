#ifndef emmy_effects_stress_tangent_h
#define emmy_effects_stress_tangent_h

#include <emmy/effects/cell_matrix.h>
#include <emmy/effects/effect.h>
#include <emmy/material/middle_step.h>

namespace emmy
{
  /**
   * Sums the derivative of the stress of points with respect to the nodes,
   * where places move with their inertia (MovingPlaces), and hands it to a
   * matrix neighbourhood by neighbourhood. Made for one tangent; borrows all
   * it is given.
   */
  template <int dim>
  class StressTangent
  {
  public:
    /** Of an iterate of a step, into a matrix. */
    StressTangent(const StepData<dim> &step,
                  const Iterate<dim>  &iterate,
                  Matrix              &matrix);

    /** What a batch says of its points. */
    struct Stresses
    {
      const StressBatch<dim> &batch;   ///< with tangent
      const MiddleStep<dim>  &middle;  ///< where the grid is that of the middle
      const double           *volumes; ///< reference volumes, of the batch, m^3
      /** By what boxes are scaled beyond what the motion says; null: nothing.
       */
      const double *box_scales = nullptr;
    };

    /** Add points that come behind those of before. */
    void
    add(const PointBatch<dim> &points, const Stresses &stresses);

    /** Hand over what is there; once after the last points. */
    void
    finish();

  private:
    void
    add_collected(const Stresses &stresses);

    const StepData<dim> &step;
    const Iterate<dim>  &iterate;
    Matrix              &matrix;
    Neighbourhood<dim>   around;
    NeighbourPoints<dim> here; ///< collected so far
    CellMatrix<dim>      stiffness;
  };
} // namespace emmy

#endif
