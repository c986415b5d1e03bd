#include <emmy/particles/totals.h>

#include <array>
#include <cmath>
#include <vector>

namespace emmy
{
  namespace
  {
    /** Compensated sum (Neumaier): its error does not grow with the length. */
    class Sum
    {
    public:
      void
      operator+=(const double term)
      {
        const double next = sum + term;
        correction += std::abs(sum) >= std::abs(term) ? (sum - next) + term
                                                      : (term - next) + sum;
        sum = next;
      }

      double
      value() const
      {
        return sum + correction;
      }

    private:
      double sum = 0., correction = 0.;
    };
  } // namespace

  template <int dim>
  Totals
  measure(const PointArrays<dim> &points,
          const FieldLayout      &layout,
          const MPI_Comm          communicator)
  {
    const double      *mass     = points.component(layout["mass"]);
    const unsigned int velocity = layout["velocity"];
    std::array<Sum, 8> local_sums;
    for (std::size_t p = 0; p < points.n_points(); ++p)
      {
        std::array<double, 3> x{}, momentum{};
        for (unsigned int d = 0; d < dim; ++d)
          {
            const double v = points.component(velocity + d)[p];
            x[d]           = points.position(d)[p];
            momentum[d]    = mass[p] * v;
            local_sums[1] += 0.5 * momentum[d] * v;
            local_sums[2 + d] += momentum[d];
          }
        local_sums[0] += mass[p];
        local_sums[5] += x[1] * momentum[2] - x[2] * momentum[1];
        local_sums[6] += x[2] * momentum[0] - x[0] * momentum[2];
        local_sums[7] += x[0] * momentum[1] - x[1] * momentum[0];
      }
    std::vector<double> sums;
    for (const Sum &sum : local_sums)
      sums.push_back(sum.value());
    sums.push_back(points.n_points()); // exact up to 2^53
    dealii::Utilities::MPI::sum(sums, communicator, sums);

    Totals totals;
    totals.particles      = static_cast<std::uint64_t>(sums[8]);
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
