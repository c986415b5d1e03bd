#ifndef emmy_particles_place_derivatives_h
#define emmy_particles_place_derivatives_h

#include <deal.II/base/aligned_vector.h>

#include <array>

namespace emmy
{
  /**
   * A shape function in one direction: value S, slope S' = dS/dx, and how both
   * change with the position x of the particle and the half-length l of its
   * box. 1, 1/m, 1/m^2.
   */
  struct Factor
  {
    /** Of the weight and its slope with position x and half-length l. */
    double value, slope, value_by_x, value_by_l, slope_by_x, slope_by_l;
  };

  /** Those of a point by direction and node along it; at most four nodes. */
  template <int dim>
  using Factors = std::array<std::array<Factor, 4>, dim>;

  /**
   * How the weights of a point change with its place: with the coordinates of
   * its position, k < dim, and with the half-lengths of its box, dim <= k.
   */
  template <int dim>
  struct PlaceDerivatives
  {
    /** Coordinates of a place; weight and gradient. */
    static constexpr unsigned int n = 2 * dim, n_weights = dim + 1;

    unsigned int n_nodes  = 0; ///< of the cell and its neighbours
    unsigned int n_padded = 0; ///< numbers in a row: full lanes of nodes
    /**
     * Rows over the nodes, behind them zeros: S,k, 1/m, with l = 0 and
     * (dS/dx_d),k, 1/m^2, with l = 1 + d: [(k n_weights + l) n_padded + a].
     */
    dealii::AlignedVector<double> rows;
    /**
     * Whether the weights depend on k; in one cell, a box weighs as a point.
     * Rows of other k are zero.
     */
    std::array<bool, n> depends;

    /** Derivatives of weight l of node k. */
    const double *
    row(const unsigned int k, const unsigned int l) const
    {
      return rows.data() + (k * n_weights + l) * n_padded;
    }
    /** Its weight. */
    const double *
    value(const unsigned int k) const
    {
      return row(k, 0);
    }
    /** Component d of its gradient, 1/m. */
    const double *
    gradient(const unsigned int k, const unsigned int d) const
    {
      return row(k, 1 + d);
    }

    /**
     * Products of the factors of all directions.
     * @param n_along nodes per direction; they are numbered x fastest
     */
    void
    combine(const Factors<dim>                  &factors,
            const std::array<unsigned int, dim> &n_along);
  };
} // namespace emmy

#endif
