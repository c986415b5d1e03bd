#include <emmy/math/lanes.h>
#include <emmy/particles/place_derivatives.h>

#include <algorithm>

namespace emmy
{
  namespace
  {
    /** The numbers of a Factor as they stand in it. */
    enum Number
    {
      value,
      slope,
      value_by_x,
      value_by_l,
      slope_by_x,
      slope_by_l,
      n_numbers
    };
    static_assert(sizeof(Factor) == n_numbers * sizeof(double), "");

    /** Products over the nodes of one number of each direction's factors. */
    template <int dim>
    void
    multiply(const std::array<const double *, dim> &numbers,
             const std::array<unsigned int, dim>   &n_along,
             double                                *row)
    {
      const auto along_x = [&](const double others) {
        for (unsigned int i = 0; i < n_along[0]; ++i)
          *row++ = numbers[0][n_numbers * i] * others;
      };
      if constexpr (dim == 2)
        for (unsigned int j = 0; j < n_along[1]; ++j)
          along_x(numbers[1][n_numbers * j]);
      else
        for (unsigned int k = 0; k < n_along[2]; ++k)
          for (unsigned int j = 0; j < n_along[1]; ++j)
            along_x(numbers[1][n_numbers * j] * numbers[2][n_numbers * k]);
    }
  } // namespace

  template <int dim>
  void
  PlaceDerivatives<dim>::combine(const Factors<dim>                  &factors,
                                 const std::array<unsigned int, dim> &n_along)
  {
    n_nodes = 1;
    for (const unsigned int n_here : n_along)
      n_nodes *= n_here;
    n_padded = padded<dim>(n_nodes);
    rows.resize_fast(n * n_weights * n_padded);
    for (unsigned int k = 0; k < n; ++k)
      {
        const unsigned int e        = k % dim;
        const bool         is_box   = k >= dim;
        double            *first    = &rows[k * n_weights * n_padded];
        const auto         is_there = [&](const Factor &factor) {
          return !is_box || factor.value_by_l != 0. || factor.slope_by_l != 0.;
        };
        depends[k] = std::any_of(factors[e].begin(),
                                 factors[e].begin() + n_along[e],
                                 is_there);
        if (!depends[k])
          {
            std::fill_n(first, n_weights * n_padded, 0.);
            continue;
          }
        for (unsigned int l = 0; l < n_weights; ++l)
          {
            std::array<const double *, dim> numbers;
            for (unsigned int d = 0; d < dim; ++d)
              {
                const bool is_slope = l == 1 + d;
                const int  number =
                  d != e ? (is_slope ? Number::slope : Number::value)
                   : is_box
                     ? (is_slope ? Number::slope_by_l : Number::value_by_l)
                     : (is_slope ? Number::slope_by_x : Number::value_by_x);
                numbers[d] = &factors[d][0].value + number;
              }
            double *row = first + l * n_padded;
            multiply<dim>(numbers, n_along, row);
            std::fill(row + n_nodes, row + n_padded, 0.);
          }
      }
  }

  template struct PlaceDerivatives<2>;
  template struct PlaceDerivatives<3>;
} // namespace emmy
