#include <emmy/effects/point_sums.h>
#include <emmy/math/four_numbers.h>

#include <cstring>

// vectors stay within this file
#pragma GCC diagnostic ignored "-Wpsabi"

namespace emmy
{
  namespace
  {
    /** Points of one group, with the slopes of its nodes. */
    template <int dim>
    struct Part
    {
      unsigned int        n_points, n_nodes;
      const unsigned int *nodes;
      const double       *slopes; ///< of the first point; by node, direction
      unsigned int        stride; ///< from a direction to the next
    };

    /** A number of one point, or of four that follow each other. */
    template <class Numbers>
    constexpr unsigned int how_many = sizeof(Numbers) / sizeof(double);

    EMMY_INLINE double
    sum_of(const double number)
    {
      return number;
    }
    EMMY_INLINE double
    sum_of(const FourNumbers &numbers)
    {
      return (numbers[0] + numbers[1]) + (numbers[2] + numbers[3]);
    }

    /** H = sum u_a (x) grad S_a of points from q on. */
    template <class Numbers, int dim>
    EMMY_INLINE void
    add_up_gradients(const Part<dim>   &part,
                     const double      *displacement,
                     const unsigned int q,
                     double            *H)
    {
      Numbers sums[dim * dim]{};
      for (unsigned int a = 0; a < part.n_nodes; ++a)
        {
          const double *u     = displacement + dim * part.nodes[a];
          const double *slope = part.slopes + a * dim * part.stride + q;
          for (int j = 0; j < dim; ++j)
            {
              const auto slopes =
                read_together<Numbers>(slope + j * part.stride);
              for (int i = 0; i < dim; ++i)
                sums[dim * i + j] += u[i] * slopes;
            }
        }
      double by_point[dim * dim][how_many<Numbers>];
      std::memcpy(by_point, sums, sizeof sums);
      for (unsigned int k = 0; k < how_many<Numbers>; ++k)
        for (int ij = 0; ij < dim * dim; ++ij)
          H[(q + k) * dim * dim + ij] = by_point[ij][k];
    }

    /** force_a += sum V P grad S_a of points from q on. */
    template <class Numbers, int dim>
    EMMY_INLINE void
    add_up_forces(const Part<dim>   &part,
                  const double      *volumes,
                  const double      *P,
                  const unsigned int q,
                  double            *force)
    {
      double by_point[dim * dim][how_many<Numbers>]; // times volume
      for (unsigned int k = 0; k < how_many<Numbers>; ++k)
        for (int ij = 0; ij < dim * dim; ++ij)
          by_point[ij][k] = volumes[q + k] * P[(q + k) * dim * dim + ij];
      Numbers stresses[dim * dim];
      std::memcpy(stresses, by_point, sizeof stresses);
      for (unsigned int a = 0; a < part.n_nodes; ++a)
        {
          const double *slope = part.slopes + a * dim * part.stride + q;
          Numbers       sums[dim]{};
          for (int j = 0; j < dim; ++j)
            {
              const auto slopes =
                read_together<Numbers>(slope + j * part.stride);
              for (int i = 0; i < dim; ++i)
                sums[i] += stresses[dim * i + j] * slopes;
            }
          for (int i = 0; i < dim; ++i)
            force[dim * part.nodes[a] + i] += sum_of(sums[i]);
        }
    }

    /** All points, four by four and then one by one. */
    template <int dim>
    EMMY_INLINE void
    find_gradients(const Part<dim> &part, const double *u, double *H)
    {
      unsigned int q = 0;
      for (; q + n_together <= part.n_points; q += n_together)
        add_up_gradients<FourNumbers>(part, u, q, H);
      for (; q < part.n_points; ++q)
        add_up_gradients<double>(part, u, q, H);
    }

    template <int dim>
    EMMY_INLINE void
    find_forces(const Part<dim> &part,
                const double    *volumes,
                const double    *P,
                double          *force)
    {
      unsigned int q = 0;
      for (; q + n_together <= part.n_points; q += n_together)
        add_up_forces<FourNumbers>(part, volumes, P, q, force);
      for (; q < part.n_points; ++q)
        add_up_forces<double>(part, volumes, P, q, force);
    }

    template <int dim>
    Part<dim>
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
    EMMY_CLONES void
    gradients(const Part<2> &part, const double *u, double *H)
    {
      find_gradients(part, u, H);
    }
    EMMY_CLONES void
    gradients(const Part<3> &part, const double *u, double *H)
    {
      find_gradients(part, u, H);
    }
    EMMY_CLONES void
    forces(const Part<2> &part,
           const double  *volumes,
           const double  *P,
           double        *force)
    {
      find_forces(part, volumes, P, force);
    }
    EMMY_CLONES void
    forces(const Part<3> &part,
           const double  *volumes,
           const double  *P,
           double        *force)
    {
      find_forces(part, volumes, P, force);
    }
  } // namespace point_kernels

  template <int dim>
  void
  displacement_gradients(const PointBatch<dim>     &points,
                         const ActiveGrid<dim>     &active,
                         const std::vector<double> &displacement,
                         StressBatch<dim>          &batch)
  {
    batch.n_points = points.n_points;
    for (const auto &part : points.parts)
      point_kernels::gradients(
        part_of(points, part, active),
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
    for (const auto &part : points.parts)
      point_kernels::forces(part_of(points, part, active),
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
