#include <emmy/material/strain_update.h>
#include <emmy/math/lane_points.h>

#include <algorithm>

// vectors stay within this file
#pragma GCC diagnostic ignored "-Wpsabi"

namespace emmy
{
  namespace
  {
    /** Points side by side. */
    template <int dim>
    struct SideStrains
    {
      const double *gradients, *old; ///< of the batch
      LanePoints    points;
      double       *result; ///< of the batch

      SideStrains(const double     *gradients,
                  const double     *old,
                  const LanePoints &points,
                  double           *result)
        : gradients(gradients)
        , old(old)
        , points(points)
        , result(result)
      {}

      Lanes H[dim][dim];
      Lanes b[n_mandel<dim>]; ///< less the unit, at t, then at the end
      Lanes determinant, square_of_change;
    };

    template <int dim>
    EMMY_INLINE void
    find_measures(SideStrains<dim> &p)
    {
      const auto &H = p.H;
      if constexpr (dim == 2)
        p.determinant = (1. + H[0][0]) * (1. + H[1][1]) - H[0][1] * H[1][0];
      else
        p.determinant =
          (1. + H[0][0]) *
            ((1. + H[1][1]) * (1. + H[2][2]) - H[1][2] * H[2][1]) -
          H[0][1] * (H[1][0] * (1. + H[2][2]) - H[1][2] * H[2][0]) +
          H[0][2] * (H[1][0] * H[2][1] - (1. + H[1][1]) * H[2][0]);

      Lanes sum{};
      for (int i = 0; i < dim; ++i)
        for (int j = 0; j <= i; ++j)
          {
            Lanes A = H[i][j] + H[j][i];
            for (int k = 0; k < dim; ++k)
              A += H[k][i] * H[k][j];
            sum += (i == j ? 1. : 2.) * A * A;
          }
      p.square_of_change = sum;
    }

    template <int dim>
    EMMY_INLINE void
    update(SideStrains<dim> &p)
    {
      constexpr auto   ij   = mandel::pairs<dim>();
      constexpr double half = 1. / mandel::sqrt2;
      Lanes            B[dim][dim];
      for (int c = 0; c < dim; ++c)
        B[c][c] = p.b[c];
      for (unsigned int c = dim; c < n_in_plane<dim>; ++c)
        B[ij[c][0]][ij[c][1]] = B[ij[c][1]][ij[c][0]] = half * p.b[c];

      // M = H b_t; b - b_t = M + M^T + M H^T, and the last is symmetric
      Lanes M[dim][dim];
      for (int i = 0; i < dim; ++i)
        for (int j = 0; j < dim; ++j)
          {
            Lanes sum = p.H[i][j];
            for (int k = 0; k < dim; ++k)
              sum += p.H[i][k] * B[k][j];
            M[i][j] = sum;
          }
      for (unsigned int c = 0; c < n_in_plane<dim>; ++c)
        {
          const int i = ij[c][0], j = ij[c][1];
          Lanes     change = M[i][j] + M[j][i];
          for (int k = 0; k < dim; ++k)
            change += M[i][k] * p.H[j][k];
          p.b[c] += (i == j ? 1. : mandel::sqrt2) * change;
        }
    }

    template <int dim>
    EMMY_INLINE void
    update_side(SideStrains<dim> &p)
    {
      read_points<dim * dim>(p.gradients, p.points, p.H[0]);
      read_points<n_mandel<dim>>(p.old, p.points, p.b);
      find_measures<dim>(p);
      update<dim>(p); // nothing moves out of the plane
      write_points<n_mandel<dim>>(p.b, p.points, p.result);
    }
  } // namespace

  namespace strain_kernels
  {
    // no templates: those have no clones
    EMMY_CLONES void
    update(SideStrains<2> &side)
    {
      update_side<2>(side);
    }
    EMMY_CLONES void
    update(SideStrains<3> &side)
    {
      update_side<3>(side);
    }
  } // namespace strain_kernels

  template <int dim>
  void
  update_strains(const dealii::Tensor<2, dim> *H,
                 const MandelVector<dim>      *old,
                 const unsigned int            n_points,
                 MandelVector<dim>            *result,
                 const StrainMeasures         &measures)
  {
    for (unsigned int first = 0; first < n_points; first += n_lanes)
      {
        SideStrains<dim> side(H[0].begin_raw(),
                              old[0].begin_raw(),
                              LanePoints(first, n_points),
                              result[0].begin_raw());
        strain_kernels::update(side);
        for (unsigned int lane = 0; lane < n_lanes; ++lane)
          {
            const std::size_t p           = side.points.of_lane[lane];
            measures.determinants[p]      = side.determinant[lane];
            measures.squares_of_change[p] = side.square_of_change[lane];
          }
      }
  }

#define INSTANTIATE(dim)                                            \
  template void update_strains<dim>(const dealii::Tensor<2, dim> *, \
                                    const MandelVector<dim> *,      \
                                    const unsigned int,             \
                                    MandelVector<dim> *,            \
                                    const StrainMeasures &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
