#ifndef emmy_effects_cell_products_h
#define emmy_effects_cell_products_h

#include <emmy/effects/cell_pools.h>
#include <emmy/effects/moving_places.h>
#include <emmy/material/mean_dilatation.h>

namespace emmy
{
  /**
   * The part of the tangent of MeanDilatation that is of whole cells: over the
   * unknowns of the nodes that a pool reaches, s (x) t + n (x) (pi + k t), with
   * t the derivative of theta, pi and k t those of P_c, n and s those of the
   * forces by P_c and by theta. Made for one tangent; borrows all it is given.
   * Cost: per point that of its nodes, per cell the square of its unknowns.
   */
  template <int dim>
  class CellProducts
  {
  public:
    /** Particles that share a mean. */
    using Pool = typename CellPools<dim>::Pool;

    /** Of a point: V0, V/V_c, V0/V_c. */
    struct Weights
    {
      /** Factors of one particle. */
      double force, ratio, stress;
    };

    /** For one step, whose state they refer to. */
    CellProducts(const StepData<dim>              &step,
                 const Iterate<dim>               &iterate,
                 const CellPools<dim>             &cells,
                 const std::vector<CellLink<dim>> &links);

    /** Begin a cell. */
    void
    begin(const Pool &pool);

    /** The share of a point of that cell. */
    void
    add_point(const std::size_t p, const Weights &weights);

    /** Add the products of that cell to the tangent. */
    void
    add_to(Matrix &jacobian);

    /** After the last cell: where places move, what that adds. */
    void
    finish();

  private:
    using Group = typename Stencils<dim>::Group;

    /** What L, and with it t and pi, change with the place of a point. */
    void
    add_place(const Group                  &group,
              const std::size_t             p,
              const dealii::Tensor<2, dim> &ratio,
              const dealii::Tensor<2, dim> &pressure);

    const StepData<dim>              &step;
    const Iterate<dim>               &iterate;
    const CellPools<dim>             &cells;
    const std::vector<CellLink<dim>> &links;

    const Pool                *pool = nullptr;
    std::vector<unsigned int>  index_of;    ///< of local nodes in the pool
    std::vector<double>        s, n, t, pi; ///< [dim * a + c]
    dealii::FullMatrix<double> block;
    /** What the places, where they are not yet Q, change of theta and P_c. */
    double                t_shift = 0., pi_shift = 0.;
    std::vector<double>   share; ///< where places move
    PlaceDerivatives<dim> derivatives;
  };
} // namespace emmy

#endif
