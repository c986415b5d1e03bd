#include <emmy/particles/place_derivatives.h>

namespace emmy
{
  template <int dim>
  void
  PlaceDerivatives<dim>::combine(const Factors<dim>                  &factors,
                                 const std::array<unsigned int, dim> &n_along)
  {
    n_nodes = 1;
    for (const unsigned int n_here : n_along)
      n_nodes *= n_here;
    values.resize(n * n_nodes);
    gradients.resize(n * dim * n_nodes);
    for (unsigned int a = 0; a < n_nodes; ++a)
      {
        std::array<const Factor *, dim> f;
        for (unsigned int d = 0, rest = a; d < dim; rest /= n_along[d++])
          f[d] = &factors[d][rest % n_along[d]];
        for (unsigned int e = 0; e < dim; ++e)
          {
            // of the value, and of all slopes, with x_e and l_e
            double by_x = f[e]->value_by_x, by_l = f[e]->value_by_l;
            for (unsigned int i = 0; i < dim; ++i)
              {
                double slope_by_x =
                         i == e ? f[e]->slope_by_x : f[e]->value_by_x,
                       slope_by_l =
                         i == e ? f[e]->slope_by_l : f[e]->value_by_l;
                for (unsigned int d = 0; d < dim; ++d)
                  if (d != e)
                    {
                      const double other = d == i ? f[d]->slope : f[d]->value;
                      slope_by_x *= other;
                      slope_by_l *= other;
                    }
                if (i != e)
                  {
                    by_x *= f[i]->value;
                    by_l *= f[i]->value;
                  }
                gradients[(e * dim + i) * n_nodes + a]         = slope_by_x;
                gradients[((dim + e) * dim + i) * n_nodes + a] = slope_by_l;
              }
            values[e * n_nodes + a]         = by_x;
            values[(dim + e) * n_nodes + a] = by_l;
          }
      }
  }

  template struct PlaceDerivatives<2>;
  template struct PlaceDerivatives<3>;
} // namespace emmy
