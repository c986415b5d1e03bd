#include <deal.II/base/utilities.h>

#include <emmy/math/lanes.h>
#include <emmy/particles/tails.h>

#include <algorithm>
#include <cmath>

namespace emmy
{
  namespace
  {
    /** Add @p scale times all numbers of @p other. */
    void
    add(const double scale, const Factor &other, Factor &factor)
    {
      factor.value += scale * other.value;
      factor.slope += scale * other.slope;
      factor.value_by_x += scale * other.value_by_x;
      factor.value_by_l += scale * other.value_by_l;
      factor.slope_by_x += scale * other.slope_by_x;
      factor.slope_by_l += scale * other.slope_by_l;
    }

    /** Add scale times D of a tail: its outermost node's numbers (1, -2, 1). */
    void
    add_tail(const double                 scale,
             const std::array<Factor, 4> &from,
             const bool                   is_upper,
             const unsigned int           n_nodes,
             std::array<Factor, 4>       &to)
    {
      const std::array<double, 3> difference{{1., -2., 1.}};
      for (unsigned int i = 0; i < 3; ++i)
        add(scale * difference[i],
            from[is_upper ? n_nodes - 1 : 0],
            to[is_upper ? n_nodes - 1 - i : i]);
    }
  } // namespace

  template <int dim>
  Tails<dim>::Tails(const Factors<dim>                  &factors,
                    const std::array<unsigned int, dim> &n_along,
                    const std::array<double, dim>       &sides)
    : n_along(n_along)
  {
    for (unsigned int d = 0; d < dim; ++d)
      for (const unsigned int end : {1, 2})
        {
          // |slope| h is the part of the box in the outermost cell
          const Factor &outermost = factors[d][end == 1 ? 0 : n_along[d] - 1];
          exists[d][0]            = true;
          exists[d][end] =
            n_along[d] > 2 && std::abs(outermost.slope) * sides[d] < 0.5;
        }
    for (int i = 0; i < dealii::Utilities::pow(3, dim); ++i)
      {
        Choice       choice;
        bool         is_there = true;
        unsigned int n_tails  = 0;
        double       share    = 1.;
        for (unsigned int d = 0, rest = i; d < dim; ++d, rest /= 3)
          {
            choice[d] = rest % 3;
            is_there  = is_there && exists[d][choice[d]];
            if (choice[d] == 0)
              continue;
            ++n_tails;
            share *=
              std::max(0.,
                       factors[d][choice[d] == 1 ? 0 : n_along[d] - 1].value);
          }
        if (is_there && n_tails > 1 && share < least_share)
          dropped.push_back(choice);
      }
  }

  template <int dim>
  std::uint64_t
  Tails<dim>::left_out() const
  {
    unsigned int n_nodes = 1;
    for (const unsigned int n : n_along)
      n_nodes *= n;
    std::uint64_t result = 0;
    for (unsigned int a = 0; a < n_nodes; ++a)
      {
        Choice choice;
        for (unsigned int d = 0, rest = a; d < dim; rest /= n_along[d++])
          {
            const unsigned int i = rest % n_along[d];
            choice[d]            = i == 0 && exists[d][1]                ? 1
                                   : i + 1 == n_along[d] && exists[d][2] ? 2
                                                                         : 0;
          }
        if (std::find(dropped.begin(), dropped.end(), choice) != dropped.end())
          result |= std::uint64_t(1) << a;
      }
    return result;
  }

  template <int dim>
  std::vector<Factors<dim>>
  Tails<dim>::products(const Factors<dim> &factors) const
  {
    std::vector<Factors<dim>> result;
    for (const Choice &choice : dropped)
      {
        result.emplace_back();
        for (unsigned int d = 0; d < dim; ++d)
          {
            const unsigned int n  = n_along[d];
            auto              &to = result.back()[d];
            to                    = {};
            if (choice[d] > 0)
              add_tail(1., factors[d], choice[d] == 2, n, to);
            else
              {
                to = factors[d];
                for (const unsigned int end : {1, 2})
                  if (exists[d][end])
                    add_tail(-1., factors[d], end == 2, n, to);
              }
          }
      }
    return result;
  }

  template <int dim>
  void
  Tails<dim>::take_away(const Factors<dim>    &factors,
                        PlaceDerivatives<dim> &derivatives) const
  {
    PlaceDerivatives<dim> part;
    for (const Factors<dim> &product : products(factors))
      {
        part.combine(product, n_along);
        for (unsigned int i = 0; i < part.rows.size(); ++i)
          derivatives.rows[i] -= part.rows[i];
      }
    // rows over the nodes of the box become rows over those that are reached
    const std::uint64_t         out    = left_out();
    const PlaceDerivatives<dim> in_box = derivatives;
    derivatives.n_nodes                = 0;
    for (unsigned int a = 0; a < in_box.n_nodes; ++a)
      derivatives.n_nodes += !(out >> a & 1);
    derivatives.n_padded = padded<dim>(derivatives.n_nodes);
    derivatives.rows.clear();
    derivatives.rows.resize(in_box.n * in_box.n_weights * derivatives.n_padded);
    double *row = derivatives.rows.data();
    for (unsigned int k = 0; k < in_box.n; ++k)
      for (unsigned int l = 0; l < in_box.n_weights;
           ++l, row += derivatives.n_padded)
        for (unsigned int a = 0, end = 0; a < in_box.n_nodes; ++a)
          if (!(out >> a & 1))
            row[end++] = in_box.row(k, l)[a];
  }

  template class Tails<2>;
  template class Tails<3>;
} // namespace emmy
