#ifndef emmy_material_principal_lanes_h
#define emmy_material_principal_lanes_h

#include <emmy/math/lane_points.h>
#include <emmy/math/spectral.h>

namespace emmy
{
  /** Points side by side, in the principal axes of b. */
  template <int dim>
  struct PrincipalLanes
  {
    /** Components of a symmetric tensor. */
    static constexpr unsigned int m = n_in_plane<dim>;

    const LanePoints points;            ///< which they are
    Lanes            values[3];         ///< of b - I
    Lanes            vectors[dim][dim]; ///< column j: axis j
    /** A tangent: its normal components, symmetric, and those of shear. */
    Lanes normal[3][3], shear[m - dim];

    /** Nothing is known of these points. */
    explicit PrincipalLanes(const LanePoints &points)
      : points(points)
    {}

    /** Values and axes of tensors of a batch, from @p first on. */
    void
    read(const SpectralArrays<dim> &b, const unsigned int first)
    {
      for (int d = 0; d < 3; ++d)
        values[d] = read_together<Lanes>(b.values[d] + first);
      for (int i = 0; i < dim; ++i)
        for (int j = 0; j < dim; ++j)
          vectors[i][j] = read_together<Lanes>(b.vectors[i][j] + first);
    }
  };

  namespace principal_axes_kernels
  {
    /**
     * Tangents of all lanes, turned from their principal axes into those of the
     * grid: Q c Q^T in Mandel notation with the congruence Q of the axes,
     * without the zeros of c. @param tangents of a batch
     */
    void
    turn(const PrincipalLanes<2> &lanes, double *tangents);
    /** The same in space. */
    void
    turn(const PrincipalLanes<3> &lanes, double *tangents);
  } // namespace principal_axes_kernels
} // namespace emmy

#endif
