#ifndef emmy_particles_point_arrays_h
#define emmy_particles_point_arrays_h

#include <deal.II/base/point.h>

#include <vector>

namespace emmy
{
  /**
   * Positions and fields of the particles of this rank, one contiguous array
   * per component, in the order of the step's stencils. Two of them live
   * during a step: the old states, which Newton reads, and the trial states,
   * which it writes and which reach the particles only once the step is
   * accepted.
   */
  template <int dim>
  class PointArrays
  {
  public:
    PointArrays() = default;

    /** Of zeros. */
    PointArrays(const std::size_t n_points, const unsigned int n_components)
      : n(n_points)
      , positions(dim * n_points)
      , values(n_components * n_points)
    {}

    /** Of this rank. */
    std::size_t
    n_points() const
    {
      return n;
    }

    /** Numbers of a particle. */
    unsigned int
    n_components() const
    {
      return n == 0 ? 0 : values.size() / n;
    }

    /** Coordinate d of all points, m. */
    double *
    position(const unsigned int d)
    {
      return positions.data() + d * n;
    }
    /** Coordinate d of all particles, m. */
    const double *
    position(const unsigned int d) const
    {
      return positions.data() + d * n;
    }

    /** One component of the fields, as FieldLayout numbers them. */
    double *
    component(const unsigned int c)
    {
      return values.data() + c * n;
    }
    /** Number c of all particles. */
    const double *
    component(const unsigned int c) const
    {
      return values.data() + c * n;
    }

    /** The numbers of particle p. */
    dealii::Point<dim>
    point(const std::size_t p) const
    {
      dealii::Point<dim> result;
      for (unsigned int d = 0; d < dim; ++d)
        result[d] = position(d)[p];
      return result;
    }

    /** Components first ... first + N - 1 of a point as a vector. */
    template <int N>
    dealii::Tensor<1, N>
    get(const unsigned int first, const std::size_t p) const
    {
      dealii::Tensor<1, N> result;
      for (unsigned int c = 0; c < N; ++c)
        result[c] = component(first + c)[p];
      return result;
    }

    /** Components from the first on. */
    template <int N>
    void
    set(const unsigned int          first,
        const std::size_t           p,
        const dealii::Tensor<1, N> &value)
    {
      for (unsigned int c = 0; c < N; ++c)
        component(first + c)[p] = value[c];
    }

  private:
    std::size_t         n = 0;
    std::vector<double> positions, values;
  };
} // namespace emmy

#endif
