#include <emmy/effects/stress_states.h>
#include <emmy/math/lanes.h>

#include <cstring>

// vectors stay within this file
#pragma GCC diagnostic ignored "-Wpsabi"

namespace emmy
{
  namespace
  {
    /** Points that a register holds. */
    constexpr unsigned int n_together = 4;
    /** One number of each of them. */
    using Together = LanesOf<n_together>::type;

    EMMY_INLINE Together
    read(const double *numbers)
    {
      Together result;
      std::memcpy(&result, numbers, sizeof result);
      return result;
    }

    /** Points of one group, with the slopes of its nodes. */
    struct Part
    {
      unsigned int        n_points, n_nodes;
      const unsigned int *nodes;
      const double       *slopes; ///< of the first point; by node, direction
      unsigned int        stride; ///< from a direction to the next
    };

    /** H = sum u_a (x) grad S_a, point after point. */
    template <int dim>
    EMMY_INLINE void
    add_up_gradients(const Part &part, const double *displacement, double *H)
    {
      unsigned int q = 0;
      for (; q + n_together <= part.n_points; q += n_together)
        {
          Together sums[dim * dim]{};
          for (unsigned int a = 0; a < part.n_nodes; ++a)
            {
              const double *u     = displacement + dim * part.nodes[a];
              const double *slope = part.slopes + a * dim * part.stride + q;
              for (int j = 0; j < dim; ++j)
                {
                  const Together slopes = read(slope + j * part.stride);
                  for (int i = 0; i < dim; ++i)
                    sums[dim * i + j] += u[i] * slopes;
                }
            }
          for (unsigned int lane = 0; lane < n_together; ++lane)
            for (int ij = 0; ij < dim * dim; ++ij)
              H[(q + lane) * dim * dim + ij] = sums[ij][lane];
        }
      for (; q < part.n_points; ++q)
        {
          double sums[dim * dim]{};
          for (unsigned int a = 0; a < part.n_nodes; ++a)
            {
              const double *u     = displacement + dim * part.nodes[a];
              const double *slope = part.slopes + a * dim * part.stride + q;
              for (int j = 0; j < dim; ++j)
                for (int i = 0; i < dim; ++i)
                  sums[dim * i + j] += u[i] * slope[j * part.stride];
            }
          for (int ij = 0; ij < dim * dim; ++ij)
            H[q * dim * dim + ij] = sums[ij];
        }
    }

    /** force_a += sum V P grad S_a, with P point after point. */
    template <int dim>
    EMMY_INLINE void
    add_up_forces(const Part   &part,
                  const double *volumes,
                  const double *P,
                  double       *force)
    {
      unsigned int q = 0;
      for (; q + n_together <= part.n_points; q += n_together)
        {
          Together stresses[dim * dim]; // times volume
          for (unsigned int lane = 0; lane < n_together; ++lane)
            for (int ij = 0; ij < dim * dim; ++ij)
              stresses[ij][lane] =
                volumes[q + lane] * P[(q + lane) * dim * dim + ij];
          for (unsigned int a = 0; a < part.n_nodes; ++a)
            {
              const double *slope = part.slopes + a * dim * part.stride + q;
              Together      sums[dim]{};
              for (int j = 0; j < dim; ++j)
                {
                  const Together slopes = read(slope + j * part.stride);
                  for (int i = 0; i < dim; ++i)
                    sums[i] += stresses[dim * i + j] * slopes;
                }
              for (int i = 0; i < dim; ++i)
                force[dim * part.nodes[a] + i] +=
                  (sums[i][0] + sums[i][1]) + (sums[i][2] + sums[i][3]);
            }
        }
      for (; q < part.n_points; ++q)
        {
          double stress[dim * dim]; // times volume
          for (int ij = 0; ij < dim * dim; ++ij)
            stress[ij] = volumes[q] * P[q * dim * dim + ij];
          for (unsigned int a = 0; a < part.n_nodes; ++a)
            {
              const double *slope = part.slopes + a * dim * part.stride + q;
              double        sums[dim]{};
              for (int j = 0; j < dim; ++j)
                for (int i = 0; i < dim; ++i)
                  sums[i] += stress[dim * i + j] * slope[j * part.stride];
              for (int i = 0; i < dim; ++i)
                force[dim * part.nodes[a] + i] += sums[i];
            }
        }
    }

    template <int dim>
    Part
    part_of(const PointBatch<dim>                &points,
            const typename PointBatch<dim>::Part &part,
            const ActiveGrid<dim>                &active)
    {
      return {part.n_points,
              part.group->n_nodes,
              active.nodes(*part.group),
              points.stencils.gradient(*part.group, 0, 0) + part.first,
              part.group->n_points};
    }
  } // namespace

  namespace point_kernels
  {
    // no templates: those have no clones
#define KERNELS(name, dim)                              \
  EMMY_CLONES void gradients_##name(const Part   &part, \
                                    const double *u,    \
                                    double       *H)    \
  {                                                     \
    add_up_gradients<dim>(part, u, H);                  \
  }                                                     \
  EMMY_CLONES void forces_##name(const Part   &part,    \
                                 const double *volumes, \
                                 const double *P,       \
                                 double       *force)   \
  {                                                     \
    add_up_forces<dim>(part, volumes, P, force);        \
  }
    KERNELS(in_plane, 2)
    KERNELS(in_space, 3)
#undef KERNELS
  } // namespace point_kernels

  template <int dim>
  void
  displacement_gradients(const PointBatch<dim>     &points,
                         const ActiveGrid<dim>     &active,
                         const std::vector<double> &displacement,
                         StressBatch<dim>          &batch)
  {
    constexpr auto kernel = dim == 2 ? point_kernels::gradients_in_plane
                                     : point_kernels::gradients_in_space;
    batch.n_points        = points.n_points;
    for (const auto &part : points.parts)
      kernel(part_of(points, part, active),
             displacement.data(),
             batch.displacement_gradient[part.at].begin_raw());
  }

  template <int dim>
  void
  add_forces(const PointBatch<dim>  &points,
             const ActiveGrid<dim>  &active,
             const double           *volumes,
             const StressBatch<dim> &batch,
             std::vector<double>    &force)
  {
    constexpr auto kernel = dim == 2 ? point_kernels::forces_in_plane
                                     : point_kernels::forces_in_space;
    for (const auto &part : points.parts)
      kernel(part_of(points, part, active),
             volumes + points.first_point + part.at,
             batch.nominal_stress[part.at].begin_raw(),
             force.data());
  }

#define INSTANTIATE(dim)                                                 \
  template void displacement_gradients<dim>(const PointBatch<dim> &,     \
                                            const ActiveGrid<dim> &,     \
                                            const std::vector<double> &, \
                                            StressBatch<dim> &);         \
  template void add_forces<dim>(const PointBatch<dim> &,                 \
                                const ActiveGrid<dim> &,                 \
                                const double *,                          \
                                const StressBatch<dim> &,                \
                                std::vector<double> &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
