#ifndef emmy_effects_pair_law_h
#define emmy_effects_pair_law_h

#include <emmy/effects/contact_pair.h>

#include <algorithm>
#include <cmath>

// The law of contact of pair_action(), in numbers that may know derivatives.

namespace emmy::pair_law
{
  /** A vector of numbers that may know their derivatives. */
  template <int dim, class Number>
  struct Components
  {
    std::array<Number, dim> c; ///< one for each direction

    /** Component i. */
    Number &
    operator[](const unsigned int i)
    {
      return c[i];
    }
    /** Component i. */
    const Number &
    operator[](const unsigned int i) const
    {
      return c[i];
    }
    /** The scalar product. */
    Number
    dot(const Components &other) const
    {
      Number sum = 0.;
      for (unsigned int i = 0; i < dim; ++i)
        sum += c[i] * other.c[i];
      return sum;
    }
    /** this + factor v. */
    Components
    plus(const Number &factor, const Components &v) const
    {
      Components result;
      for (unsigned int i = 0; i < dim; ++i)
        result.c[i] = c[i] + factor * v.c[i];
      return result;
    }
    /** factor this. */
    Components
    times(const Number &factor) const
    {
      Components result;
      for (unsigned int i = 0; i < dim; ++i)
        result.c[i] = factor * c[i];
      return result;
    }
    /** What is left of it across a unit vector. */
    Components
    across(const Components &n) const
    {
      return plus(-dot(n), n);
    }
  };

  template <class Number>
  Number
  sqrt_of(const Number &x)
  {
    using std::sqrt;
    return sqrt(x);
  }

  inline double
  plain(const double x)
  {
    return x;
  }
  template <class Number>
  double
  plain(const Number &x)
  {
    return x.val();
  }

  template <int dim, class Number>
  Components<dim, Number>
  constant(const dealii::Tensor<1, dim> &v)
  {
    Components<dim, Number> result;
    for (unsigned int i = 0; i < dim; ++i)
      result[i] = v[i];
    return result;
  }

  template <class Number>
  Number
  energy(const PairLaw &law, const Number &gap)
  {
    if (plain(gap) >= 0.)
      return 0.;
    Number power = gap * gap;
    for (unsigned int i = 2; i < law.exponent; ++i)
      power *= -gap / law.reach;
    return (law.stiffness / law.exponent) * power;
  }

  /** (psi_1 - psi_0)/(g_1 - g_0), without a difference where both touch. */
  template <class Number>
  Number
  quotient(const PairLaw &law, const double gap_old, const Number &gap_new)
  {
    if (gap_old >= 0. && plain(gap_new) >= 0.)
      return 0.;
    if (gap_old >= 0. || plain(gap_new) >= 0.)
      return (energy(law, gap_new) - energy(law, gap_old)) /
             (gap_new - gap_old);
    Number sum = 0.; // of p1^i p0^(q - 1 - i)
    for (unsigned int i = 0; i < law.exponent; ++i)
      {
        Number product = 1.;
        for (unsigned int j = 0; j + 1 < law.exponent; ++j)
          product *= j < i ? Number(-gap_new) : Number(-gap_old);
        sum += product;
      }
    return -law.stiffness / law.exponent *
           std::pow(law.reach, 2. - law.exponent) * sum;
  }

  template <int dim>
  void
  let_go(const PairLaw                &law,
         const dealii::Tensor<1, dim> &spring,
         PairAction<dim>              &result)
  {
    const double lost = 0.5 * law.spring_stiffness * spring.norm_square();
    result.spring_stored -= lost;
    result.slip += lost;
  }

  /** What acts on the first point: f, and the part T of friction in -f. */
  template <int dim, class Number>
  struct Push
  {
    Components<dim, Number> force, friction; ///< f and T, N
  };

  /** The law of two points, by w and the slide before it is laid across n. */
  template <int dim, class Number>
  class Evaluation
  {
  public:
    using V = Components<dim, Number>; ///< a vector

    /** Borrows all; the spring of friction is that of before the step. */
    Evaluation(const PairLaw                &law,
               const dealii::Tensor<1, dim> &before,
               const dealii::Tensor<1, dim> &spring,
               PairAction<dim>              &result)
      : law(law)
      , before(before)
      , spring_old(spring)
      , result(result)
    {}

    /** @pre they touch: result.acts, and its gaps are known */
    Push<dim, Number>
    operator()(const V &way, const V &slide)
    {
      const V      at_end = constant<dim, Number>(before).plus(1., way);
      const V      mean   = constant<dim, Number>(before).plus(0.5, way);
      const Number d_new  = sqrt_of(at_end.dot(at_end));
      const Number gap    = d_new - law.reach;
      const Number c =
        -2. * quotient(law, result.gap_old, gap) / (before.norm() + d_new);
      Push<dim, Number> push{mean.times(c), {}};
      if (law.friction > 0.)
        add_friction(c, mean, slide, push);
      for (unsigned int i = 0; i < dim; ++i)
        result.force[i] = plain(push.force[i]);
      return push;
    }

  private:
    /** xi at the start, laid into the plane across n with its length kept. */
    V
    laid_spring(const V &n) const
    {
      const V spring = constant<dim, Number>(
        result.gap_old >= 0. ? dealii::Tensor<1, dim>() : spring_old);
      const V      across = spring.across(n);
      const Number square = across.dot(across);
      if (!(plain(square) > 0.))
        return spring.times(0.);
      const Number factor = spring_old.norm() / sqrt_of(square);
      return across.times(factor);
    }

    void
    add_friction(const Number      &c,
                 const V           &mean,
                 const V           &way,
                 Push<dim, Number> &push)
    {
      const Number length = sqrt_of(mean.dot(mean));
      const Number limit  = law.friction * c * length;
      const Number scale  = 1. / length;
      const V      n      = mean.times(scale);
      const V      slide  = way.across(n);
      const V      spring = laid_spring(n);
      const double k      = law.spring_stiffness;
      V           &T      = push.friction;
      T                   = spring.plus(0.5, slide).times(k);
      const Number trial  = T.dot(T);
      if (plain(trial) > plain(limit) * plain(limit))
        {
          const Number factor = limit / sqrt_of(trial);
          T                   = T.times(factor);
        }
      push.force  = push.force.plus(-1., T);
      double work = 0.;
      for (unsigned int i = 0; i < dim; ++i)
        {
          work += plain(T[i]) * plain(slide[i]);
          result.spring[i] = 2. / k * plain(T[i]) - plain(spring[i]);
        }
      book(work, plain(limit));
    }

    void
    book(const double work, const double limit)
    {
      const double k = law.spring_stiffness;
      if (const double stretch = result.spring.norm(); k * stretch > limit)
        result.spring *= limit / (k * stretch);
      const double at_start =
        result.gap_old >= 0. ? 0. : spring_old.norm_square();
      const double gain = 0.5 * k * (result.spring.norm_square() - at_start);
      result.spring_stored += gain;
      result.slip += work - gain;
      if (result.gap_new >= 0.)
        {
          let_go(law, result.spring, result);
          result.spring = dealii::Tensor<1, dim>();
        }
    }

    const PairLaw                &law;
    const dealii::Tensor<1, dim> &before, &spring_old;
    PairAction<dim>              &result;
  };
} // namespace emmy::pair_law

#endif
