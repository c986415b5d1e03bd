#include <emmy/particles/place_derivatives.h>

namespace emmy
{
  template <int dim>
  void
  PlaceDerivatives<dim>::combine(const Factors<dim>                  &factors,
                                 const std::array<unsigned int, dim> &n_along)
  {
    unsigned int n_nodes = 1;
    for (const unsigned int n_here : n_along)
      n_nodes *= n_here;
    values.resize(n * n_nodes);
    gradients.resize(n * n_nodes);
    for (unsigned int a = 0; a < n_nodes; ++a)
      {
        std::array<const Factor *, dim> f;
        for (unsigned int d = 0, rest = a; d < dim; rest /= n_along[d++])
          f[d] = &factors[d][rest % n_along[d]];
        for (unsigned int e = 0; e < dim; ++e)
          {
            // of the value, and of all slopes, with x_e and l_e
            double by_x = f[e]->value_by_x, by_l = f[e]->value_by_l;
            dealii::Tensor<1, dim> slope_by_x, slope_by_l;
            for (unsigned int i = 0; i < dim; ++i)
              {
                slope_by_x[i] = i == e ? f[e]->slope_by_x : f[e]->value_by_x;
                slope_by_l[i] = i == e ? f[e]->slope_by_l : f[e]->value_by_l;
                for (unsigned int d = 0; d < dim; ++d)
                  if (d != e)
                    {
                      const double other = d == i ? f[d]->slope : f[d]->value;
                      slope_by_x[i] *= other;
                      slope_by_l[i] *= other;
                    }
                if (i != e)
                  {
                    by_x *= f[i]->value;
                    by_l *= f[i]->value;
                  }
              }
            values[a * n + e]          = by_x;
            values[a * n + dim + e]    = by_l;
            gradients[a * n + e]       = slope_by_x;
            gradients[a * n + dim + e] = slope_by_l;
          }
      }
  }

  template struct PlaceDerivatives<2>;
  template struct PlaceDerivatives<3>;
} // namespace emmy
