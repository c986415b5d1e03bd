#ifndef emmy_particles_place_derivatives_h
#define emmy_particles_place_derivatives_h

#include <deal.II/base/tensor.h>

#include <array>
#include <vector>

namespace emmy
{
  /**
   * A shape function in one direction: value S, slope S' = dS/dx, and how both
   * change with the position x of the particle and the half-length l of its
   * box. 1, 1/m, 1/m^2.
   */
  struct Factor
  {
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
    static constexpr unsigned int n = 2 * dim;

    /** S,k of node a, 1/m: [a * n + k]. */
    std::vector<double> values;
    /** (grad S),k, 1/m^2. */
    std::vector<dealii::Tensor<1, dim>> gradients;

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
