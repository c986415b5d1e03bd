#ifndef emmy_particles_place_derivatives_h
#define emmy_particles_place_derivatives_h

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

    unsigned int n_nodes = 0;
    /** S,k of node a, 1/m: [k * n_nodes + a]. */
    std::vector<double> values;
    /** (dS/dx_d),k, 1/m^2: [(k * dim + d) * n_nodes + a]. */
    std::vector<double> gradients;

    const double *
    value(const unsigned int k) const
    {
      return values.data() + k * n_nodes;
    }
    const double *
    gradient(const unsigned int k, const unsigned int d) const
    {
      return gradients.data() + (k * dim + d) * n_nodes;
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
