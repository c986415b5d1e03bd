#include <emmy/effects/tool_contact.h>

#include <cmath>
#include <limits>

namespace emmy
{
  using dealii::Tensor;

  namespace
  {
    /** (psi_1 - psi_0)/(phi_1 - phi_0), and its derivative by phi_1. */
    struct Quotient
    {
      double value, by_new;
    };

    Quotient
    quotient(const double k,
             const double gap_old,
             const double gap_new,
             const bool   is_held)
    {
      if (is_held)
        return {0.5 * k * (gap_old + gap_new), 0.5 * k};
      const double p_old = std::max(-gap_old, 0.),
                   p_new = std::max(-gap_new, 0.);
      if (p_old > 0. && p_new > 0.)
        return {-0.5 * k * (p_old + p_new), 0.5 * k};
      if (p_new > 0.)
        {
          const double share = p_new / (p_new + gap_old);
          return {-0.5 * k * p_new * share, k * share * (1. - 0.5 * share)};
        }
      const double share = p_old > 0. ? p_old / (p_old + gap_new) : 0.;
      return {-0.5 * k * p_old * share, 0.5 * k * share * share};
    }

    /** g of contact(), and its derivative by w. */
    template <int dim>
    struct MeanNormal
    {
      Tensor<1, dim> value;
      Tensor<2, dim> by_way;
    };

    template <int dim>
    MeanNormal<dim>
    mean_normal(const SurfaceDistance<dim> &at_start,
                const SurfaceDistance<dim> &in_middle,
                const SurfaceDistance<dim> &at_end,
                const Tensor<1, dim>       &way,
                const double                size)
    {
      MeanNormal<dim> result{in_middle.normal, 0.5 * in_middle.curvature};
      const double    square = way * way;
      const double    misfit =
        at_end.value - at_start.value - in_middle.normal * way;
      // round-off of the distances is no misfit
      if (std::abs(misfit) <=
          16. * std::numeric_limits<double>::epsilon() * size)
        return result;
      const double         e = misfit / square;
      const Tensor<1, dim> e_by_way =
        (at_end.normal - in_middle.normal - 0.5 * (in_middle.curvature * way) -
         2. * e * way) /
        square;
      result.value += e * way;
      for (unsigned int d = 0; d < dim; ++d)
        result.by_way[d][d] += e;
      result.by_way += outer_product(way, e_by_way);
      return result;
    }

    /** I - v v^T. */
    template <int dim>
    Tensor<2, dim>
    across(const Tensor<1, dim> &v)
    {
      Tensor<2, dim> result = -1. * outer_product(v, v);
      for (unsigned int d = 0; d < dim; ++d)
        result[d][d] += 1.;
      return result;
    }

    /** A vector, and its derivative by w. */
    template <int dim>
    struct Varied
    {
      Tensor<1, dim> value;
      Tensor<2, dim> by_way;
    };

    /** v - n (n.v) of a vector that changes with w by @p v_by_way. */
    template <int dim>
    Varied<dim>
    tangential(const Tensor<1, dim> &v,
               const Tensor<2, dim> &v_by_way,
               const Varied<dim>    &n)
    {
      const double along = n.value * v;
      return {v - along * n.value,
              across(n.value) * v_by_way - along * n.by_way -
                outer_product(n.value, v * n.by_way)};
    }

    /** Friction of a point that presses with @p pressing N. */
    template <int dim>
    void
    add_friction(const ContactLaw     &law,
                 const Tensor<1, dim> &spring_old,
                 const Tensor<1, dim> &way,
                 const Varied<dim>    &n,
                 const double          pressing,
                 const Tensor<1, dim> &pressing_by_way,
                 Contact<dim>         &result)
    {
      const double k = law.spring_stiffness, limit = law.friction * pressing;
      Varied<dim>  spring = tangential(spring_old, Tensor<2, dim>(), n);
      if (const double length = spring.value.norm(); length > 0.)
        {
          const double stretch = spring_old.norm() / length;
          spring.by_way =
            stretch * (across(spring.value / length) * spring.by_way);
          spring.value *= stretch;
        }
      Tensor<2, dim> unit;
      for (unsigned int d = 0; d < dim; ++d)
        unit[d][d] = 1.;
      const Varied<dim> slide = tangential(way, unit, n);

      Varied<dim>  T{k * (spring.value + 0.5 * slide.value),
                    k * (spring.by_way + 0.5 * slide.by_way)};
      const double trial = T.value.norm();
      if (trial > limit)
        {
          const Tensor<1, dim> t = T.value / trial;
          T.by_way               = limit / trial * (across(t) * T.by_way) +
                     law.friction * outer_product(t, pressing_by_way);
          T.value = limit * t;
        }
      result.force -= T.value;
      result.derivative -= T.by_way;
      result.spring = (2. / k) * T.value - spring.value;
      if (const double length = result.spring.norm(); k * length > limit)
        result.spring *= limit / (k * length);
      result.spring_stored =
        0.5 * k * (result.spring.norm_square() - spring_old.norm_square());
      result.slip = T.value * way - result.spring_stored;
    }
  } // namespace

  double
  contact_energy(const double k, const double gap, const bool is_held)
  {
    return is_held || gap < 0. ? 0.5 * k * gap * gap : 0.;
  }

  template <int dim>
  Contact<dim>
  contact(const ToolShape<dim>    &shape,
          const ContactLaw        &law,
          const ContactPoint<dim> &point,
          const Tensor<1, dim>    &way)
  {
    const auto at_start = shape.distance(point.place);
    const auto at_end   = shape.distance(point.place + way);

    Contact<dim> result;
    result.gap_old    = at_start.value;
    result.gap_new    = at_end.value;
    const double lost = 0.5 * law.spring_stiffness * point.spring.norm_square();
    if (!point.is_held && at_start.value >= 0.)
      {
        // what is open at the start has let go
        result.spring_stored = -lost;
        result.slip          = lost;
        if (at_end.value >= 0.)
          return result;
      }
    result.acts = true;
    result.stored =
      contact_energy(law.stiffness, at_end.value, point.is_held) -
      contact_energy(law.stiffness, at_start.value, point.is_held);

    const auto   in_middle = shape.distance(point.place + 0.5 * way);
    const double size      = point.place.norm() + way.norm() +
                        std::abs(at_start.value) + std::abs(at_end.value);
    const auto     g = mean_normal(at_start, in_middle, at_end, way, size);
    const Quotient D =
      quotient(law.stiffness, at_start.value, at_end.value, point.is_held);
    result.force = -D.value * g.value;
    result.derivative =
      -D.by_new * outer_product(g.value, at_end.normal) - D.value * g.by_way;
    if (!(law.friction > 0.))
      return result;

    const double         length = g.value.norm();
    const Tensor<1, dim> n      = g.value / length;
    const Tensor<1, dim> pressing_by_way =
      -D.by_new * length * at_end.normal - D.value * (n * g.by_way);
    Contact<dim>         with = result;
    const Tensor<1, dim> old =
      at_start.value >= 0. ? Tensor<1, dim>() : point.spring;
    add_friction(law,
                 old,
                 way,
                 {n, across(n) * g.by_way / length},
                 -D.value * length,
                 pressing_by_way,
                 with);
    if (at_end.value >= 0.) // it lets go
      {
        const double let_go =
          0.5 * law.spring_stiffness * with.spring.norm_square();
        with.spring = Tensor<1, dim>();
        with.spring_stored -= let_go;
        with.slip += let_go;
      }
    with.spring_stored += result.spring_stored;
    with.slip += result.slip;
    return with;
  }

  template <int dim>
  double
  depth_on_way(const ToolShape<dim> &shape,
               const Tensor<1, dim> &place,
               const Tensor<1, dim> &way,
               const double          resolution)
  {
    // the distance changes by no more than the way that is gone
    const double length = way.norm();
    double       depth  = 0.;
    for (double gone = 0.; gone < length;)
      {
        const double gap = shape.distance(place + (gone / length) * way).value;
        depth            = std::max(depth, -gap);
        gone += std::max(std::abs(gap), resolution);
      }
    return depth;
  }

#define INSTANTIATE(dim)                                          \
  template Contact<dim> contact<dim>(const ToolShape<dim> &,      \
                                     const ContactLaw &,          \
                                     const ContactPoint<dim> &,   \
                                     const Tensor<1, dim> &);     \
  template double       depth_on_way<dim>(const ToolShape<dim> &, \
                                    const Tensor<1, dim> &, \
                                    const Tensor<1, dim> &, \
                                    const double);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
