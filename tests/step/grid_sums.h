#ifndef emmy_tests_step_grid_sums_h
#define emmy_tests_step_grid_sums_h

#include "one_step.h"

// Sums over nodes and particles, for the identities of a step.
namespace emmy
{
  namespace test
  {
    using Vector3 = dealii::Tensor<1, 3>;

    template <int dim>
    Vector
    times(const NodalMatrix<dim> &matrix, const Vector &vector)
    {
      Vector result = vector;
      matrix.vmult(result, vector);
      return result;
    }

    template <int dim>
    Vector3
    in_space(const std::vector<double> &values, const unsigned int node)
    {
      Vector3 result;
      for (unsigned int c = 0; c < dim; ++c)
        result[c] = values[dim * node + c];
      return result;
    }

    /** Sum of a_A x b_A over nodes, and of the sizes of its terms.
     * @param n_nodes of this rank, without those that others own */
    template <int dim>
    std::pair<Vector3, double>
    cross(const std::vector<double> &a,
          const std::vector<double> &b,
          const unsigned int         n_nodes)
    {
      Vector3 sum;
      double  size = 0.;
      for (unsigned int node = 0; node < n_nodes; ++node)
        {
          const auto a_A = in_space<dim>(a, node), b_A = in_space<dim>(b, node);
          sum += cross_product_3d(a_A, b_A);
          size += a_A.norm() * b_A.norm();
        }
      return {sum_over_ranks(sum), sum_over_ranks(size)};
    }

    template <int dim>
    Motion
    motion(const PointArrays<dim> &points, const FieldLayout &layout)
    {
      Motion result;
      for (std::size_t p = 0; p < points.n_points(); ++p)
        {
          const double m = points.component(layout["mass"])[p];
          Vector3      x, v;
          for (unsigned int d = 0; d < dim; ++d)
            {
              x[d] = points.position(d)[p];
              v[d] = points.component(layout["velocity"] + d)[p];
            }
          result.energy += 0.5 * m * v.norm_square();
          result.linear += m * v;
          result.angular += m * cross_product_3d(x, v);
          result.angular_size += m * x.norm() * v.norm();
        }
      result.energy       = sum_over_ranks(result.energy);
      result.linear       = sum_over_ranks(result.linear);
      result.angular      = sum_over_ranks(result.angular);
      result.angular_size = sum_over_ranks(result.angular_size);
      return result;
    }
  } // namespace test
} // namespace emmy

#endif
