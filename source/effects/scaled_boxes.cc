#include <emmy/base/exceptions.h>
#include <emmy/effects/mean_dilatation.h>
#include <emmy/effects/scaled_boxes.h>

#include <cmath>

namespace emmy
{
  using dealii::Tensor;

  namespace
  {
    /** sqrt(det b), from b - I. */
    template <int dim>
    double
    volume_ratio(const PointArrays<dim> &points,
                 const unsigned int      left_cauchy_green_less_unit,
                 const std::size_t       p)
    {
      return std::sqrt(
        1. +
        mandel::determinant_less_one<dim>(
          points.template get<n_mandel<dim>>(left_cauchy_green_less_unit, p)));
    }
    /** See with_mean_dilatation(). */
    template <int dim>
    class ScaledUpdate : public DomainUpdate<dim>
    {
    public:
      ScaledUpdate(std::unique_ptr<DomainUpdate<dim>> inner,
                   const bool                         is_of_gradient,
                   const FieldLayout                 &layout)
        : inner(std::move(inner))
        , is_of_gradient(is_of_gradient)
        , half_length(layout["half_length"])
        , deformation_gradient(is_of_gradient ? layout["deformation_gradient"]
                                              : 0)
        , left_cauchy_green_less_unit(layout["left_cauchy_green_less_unit"])
        , volume_ratio_less_one(layout[own_volume_field])
      {}

      void
      operator()(const Stencils<dim>       &stencils,
                 const PointArrays<dim>    &points,
                 const ActiveGrid<dim>     &active,
                 const std::vector<double> &displacement,
                 PointArrays<dim>          &trial) const override
      {
        (*inner)(stencils, points, active, displacement, trial);
        if (!is_of_gradient) // b is that of the scaled motion already
          return;
        for (std::size_t p = 0; p < trial.n_points(); ++p)
          {
            const double scale =
              std::pow(scaled_over_own(trial, p) / scaled_over_own(points, p),
                       1. / dim);
            for (unsigned int c = 0; c < dim * dim; ++c)
              trial.component(deformation_gradient + c)[p] *= scale;
            for (unsigned int d = 0; d < dim; ++d)
              trial.component(half_length + d)[p] *= scale;
          }
      }

      MiddleBox<dim>
      middle(const PointArrays<dim> &states,
             const std::size_t       p,
             const unsigned int      body,
             const Tensor<2, dim>   &Z) const override
      {
        return inner->middle(states, p, body, Z); // the force scales it
      }

    private:
      double
      scaled_over_own(const PointArrays<dim> &states, const std::size_t p) const
      {
        return volume_ratio<dim>(states, left_cauchy_green_less_unit, p) /
               (1. + states.component(volume_ratio_less_one)[p]);
      }

      const std::unique_ptr<DomainUpdate<dim>> inner;
      const bool                               is_of_gradient;
      const unsigned int half_length, deformation_gradient,
        left_cauchy_green_less_unit, volume_ratio_less_one;
    };
  } // namespace

  template <int dim>
  std::unique_ptr<DomainUpdate<dim>>
  with_mean_dilatation(std::unique_ptr<DomainUpdate<dim>> inner,
                       const std::string                 &name,
                       const FieldLayout                 &layout)
  {
    AssertThrow(name != "corners",
                ExcParameter("Method",
                             "Domain update",
                             name,
                             "with Locking treatment = cell boxes follow the "
                             "mean dilatation of their cell, and corners do "
                             "not. Use stretch, diagF, detF or none."));
    if (!inner)
      return inner;
    return std::make_unique<ScaledUpdate<dim>>(std::move(inner),
                                               name != "detF",
                                               layout);
  }

#define INSTANTIATE(dim)                                            \
  template std::unique_ptr<DomainUpdate<dim>> with_mean_dilatation( \
    std::unique_ptr<DomainUpdate<dim>>,                             \
    const std::string &,                                            \
    const FieldLayout &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
