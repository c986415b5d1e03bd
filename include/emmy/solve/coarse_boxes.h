#ifndef emmy_solve_coarse_boxes_h
#define emmy_solve_coarse_boxes_h

#include <emmy/solve/band_lu.h>
#include <emmy/system/node_places.h>

#include <array>
#include <vector>

namespace emmy
{
  /**
   * A coarse level for a preconditioner: the nodes of all ranks are grouped by
   * boxes in space, and each box has the rigid motions as its modes P, zero
   * where a row of the matrix couples nothing (unknowns that are given). With
   * A_c = P^T A P a residual r gets the correction P A_c^-1 P^T r (two-level
   * deflation, Nabben and Vuik 2006; box-wise rigid modes as in
   * Vanek et al. 1996, without the smoothing). It brings long
   * waves, which a step of many cells' length of travel couples, to an end that
   * ILU sees only node by node.
   *
   * Boxes have an edge of at least six cells, and there are so few of them that
   * A_c has at most 600 rows. Only boxes beside each other meet, so their
   * order, along the body, makes A_c a band. Cost: some two products with A to
   * make it, a quarter of one to apply it; the factors of A_c are on each rank
   * (see BandLu).
   *
   * @tparam dim unknowns per node
   */
  template <int dim>
  class CoarseBoxes
  {
  public:
    /** Collective. */
    void
    make(const Matrix &matrix, const NodePlaces &places);

    /**
     * y = P A_c^-1 P^T r, and r - A y to @p rest. Collective.
     */
    void
    correct(const Vector &r, Vector &y, Vector &rest) const;

  private:
    static constexpr unsigned int n_modes = dim * (dim + 1) / 2;
    using Key                             = std::array<int, dim>;
    /** What the modes of its box do at an unknown, and each at a node. */
    using Motion  = std::array<double, n_modes>;
    using Motions = std::array<std::array<double, dim>, n_modes>;

    /** A P. @param box_of, motions of each column */
    void
    multiply(const Matrix                    &matrix,
             const std::vector<unsigned int> &box_of,
             const std::vector<Motion>       &motions);
    /** A_c, and its factors. */
    void
    project(const unsigned int n_boxes, const MPI_Comm communicator);

    unsigned int              n_owned = 0; ///< nodes
    std::vector<unsigned int> box_of_node;
    /** Of each node, and one more to read behind the last. */
    std::vector<Motions> motions_of_node;
    /** A P: of node i, [first[i], first[i + 1]). */
    std::vector<std::size_t>    first;
    std::vector<unsigned int>   boxes;
    std::vector<Motions>        products; ///< and one more
    BandLu                      coarse;
    mutable std::vector<double> amounts;
  };
} // namespace emmy

#endif
