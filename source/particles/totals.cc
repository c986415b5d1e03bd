#include <emmy/particles/totals.h>

#include <array>

namespace emmy
{
  template <int dim>
  Totals
  measure(const PointArrays<dim> &points,
          const FieldLayout      &layout,
          const MPI_Comm          communicator)
  {
    const double         *mass     = points.component(layout["mass"]);
    const unsigned int    velocity = layout["velocity"];
    std::array<double, 8> sums{};
    for (std::size_t p = 0; p < points.n_points(); ++p)
      {
        std::array<double, 3> x{}, momentum{};
        for (unsigned int d = 0; d < dim; ++d)
          {
            const double v = points.component(velocity + d)[p];
            x[d]           = points.position(d)[p];
            momentum[d]    = mass[p] * v;
            sums[1] += 0.5 * momentum[d] * v;
            sums[2 + d] += momentum[d];
          }
        sums[0] += mass[p];
        sums[5] += x[1] * momentum[2] - x[2] * momentum[1];
        sums[6] += x[2] * momentum[0] - x[0] * momentum[2];
        sums[7] += x[0] * momentum[1] - x[1] * momentum[0];
      }
    for (double &sum : sums)
      sum = dealii::Utilities::MPI::sum(sum, communicator);

    Totals totals;
    totals.particles =
      dealii::Utilities::MPI::sum(static_cast<std::uint64_t>(points.n_points()),
                                  communicator);
    totals.mass           = sums[0];
    totals.kinetic_energy = sums[1];
    for (unsigned int d = 0; d < 3; ++d)
      {
        totals.linear_momentum[d]  = sums[2 + d];
        totals.angular_momentum[d] = sums[5 + d];
      }
    return totals;
  }

  template Totals
  measure<2>(const PointArrays<2> &, const FieldLayout &, const MPI_Comm);
  template Totals
  measure<3>(const PointArrays<3> &, const FieldLayout &, const MPI_Comm);
} // namespace emmy
