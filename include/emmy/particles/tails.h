#ifndef emmy_particles_tails_h
#define emmy_particles_tails_h

#include <emmy/particles/place_derivatives.h>

#include <cstdint>

namespace emmy
{
  /**
   * The least share of a particle that makes a node active, dimensionless. A
   * node with less has a row of the matrix that is nothing but round-off.
   */
  constexpr double least_share = 1e-12;

  /**
   * Corners of a box of GIMP that weigh nothing. A tail is the part of a box in
   * an outermost cell if it is less than half of the box. In one direction, it
   * gives the outermost node a weight w, of order (overlap/h)^2. Where the hats
   * of the cell before were continued into the tail instead, that node would
   * get nothing and the two before it w (2, -1): without tails the weights are
   *
   *   P - D,  D = w (1, -2, 1) on the outermost node and the two before it.
   *
   * A node at an edge or a corner of several tails has the product of their w.
   * Where that is below least_share, the product of the D is taken away from
   * the weights, value and slope alike: it vanishes on all linear functions, so
   * sum S = 1, sum grad S = 0, sum S x = x_p, sum x (x) grad S = I stay, and
   * the node has no weight left. Values change by a few times least_share,
   * slopes by that times h / overlap. Tails in one direction never get here:
   * where w is below least_share the cell is left out before.
   *
   * Cost: only for boxes with such corners.
   */
  template <int dim>
  class Tails
  {
  public:
    /**
     * @param factors   of a particle; values and slopes are used
     * @param n_along   nodes per direction
     * @param sides of the cells, m
     */
    Tails(const Factors<dim>                  &factors,
          const std::array<unsigned int, dim> &n_along,
          const std::array<double, dim>       &sides);

    /** The nodes of the box, x fastest, that are left without weight: bits. */
    std::uint64_t
    left_out() const;

    /**
     * The products to be taken away, each as its factors; linear in each of
     * the numbers of @p factors, so that derivatives can be handled alike.
     */
    std::vector<Factors<dim>>
    products(const Factors<dim> &factors) const;

    /**
     * Take them away from the derivatives of all nodes of the box, and keep
     * those of the nodes that are not left out.
     */
    void
    take_away(const Factors<dim>    &factors,
              PlaceDerivatives<dim> &derivatives) const;

  private:
    /** Per direction, 0: without tails; 1: lower tail; 2: upper tail. */
    using Choice = std::array<unsigned int, dim>;

    const std::array<unsigned int, dim>  n_along;
    std::array<std::array<bool, 3>, dim> exists;
    std::vector<Choice>                  dropped;
  };
} // namespace emmy

#endif
