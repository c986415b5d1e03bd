#include <emmy/math/lanes.h>
#include <emmy/particles/place_derivatives.h>

namespace emmy
{
  namespace
  {
    /**
     * S,k and its slopes,k of a node, where k belongs to direction e: the
     * product of the factors, with those of e differentiated.
     */
    template <int dim>
    inline void
    set_node(const std::array<const Factor *, dim> &f,
             const unsigned int                     e,
             const double                           value_by_k,
             const double                           slope_by_k,
             double                                *of_node,
             const unsigned int                     stride)
    {
      for (unsigned int l = 0; l <= dim; ++l)
        {
          double product = l == 1 + e ? slope_by_k : value_by_k;
          for (unsigned int d = 0; d < dim; ++d)
            if (d != e)
              product *= l == 1 + d ? f[d]->slope : f[d]->value;
          of_node[l * stride] = product;
        }
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
    for (unsigned int e = 0; e < dim; ++e)
      {
        bool by_l = false;
        for (unsigned int j = 0; j < n_along[e]; ++j)
          by_l = by_l || factors[e][j].value_by_l != 0. ||
                 factors[e][j].slope_by_l != 0.;
        depends[e]       = true;
        depends[dim + e] = by_l;
      }

    std::array<unsigned int, dim> index{};
    for (unsigned int a = 0; a < n_nodes; ++a)
      {
        std::array<const Factor *, dim> f;
        for (unsigned int d = 0; d < dim; ++d)
          f[d] = &factors[d][index[d]];
        double *row = &rows[a];
        for (unsigned int e = 0; e < dim; ++e, row += n_weights * n_padded)
          set_node<dim>(
            f, e, f[e]->value_by_x, f[e]->slope_by_x, row, n_padded);
        for (unsigned int e = 0; e < dim; ++e, row += n_weights * n_padded)
          if (depends[dim + e])
            set_node<dim>(
              f, e, f[e]->value_by_l, f[e]->slope_by_l, row, n_padded);
        for (unsigned int d = 0; d < dim && ++index[d] == n_along[d]; ++d)
          index[d] = 0;
      }
    for (unsigned int k = 0; k < n; ++k)
      for (unsigned int l = 0; l < n_weights; ++l)
        {
          double *row = &rows[(k * n_weights + l) * n_padded];
          for (unsigned int a = depends[k] ? n_nodes : 0; a < n_padded; ++a)
            row[a] = 0.;
        }
  }

  template struct PlaceDerivatives<2>;
  template struct PlaceDerivatives<3>;
} // namespace emmy
