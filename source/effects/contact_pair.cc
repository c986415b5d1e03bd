#include <emmy/effects/contact_pair.h>

#include <Sacado.hpp>

#include <algorithm>
#include <cmath>

namespace emmy
{
  using dealii::Tensor;

  namespace
  {
    /** A vector of numbers that may know their derivatives. */
    template <int dim, class Number>
    struct Components
    {
      std::array<Number, dim> c;

      Number &
      operator[](const unsigned int i)
      {
        return c[i];
      }
      const Number &
      operator[](const unsigned int i) const
      {
        return c[i];
      }
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

    double
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
    constant(const Tensor<1, dim> &v)
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

    /** A point and its motion in numbers that may know derivatives. */
    template <int dim, class Number>
    struct Moving
    {
      Components<dim, Number>                  arm, way;
      std::array<Components<dim, Number>, dim> gradient; ///< rows

      /** L v. */
      Components<dim, Number>
      turned(const Components<dim, Number> &v) const
      {
        Components<dim, Number> result;
        for (unsigned int i = 0; i < dim; ++i)
          result[i] = gradient[i].dot(v);
        return result;
      }

      /** (I + L/2)^-1 v: its value, and by one Newton step its derivative. */
      Components<dim, Number>
      turned_back(const Components<dim, Number> &v,
                  const Tensor<2, dim>          &plain_gradient) const
      {
        Tensor<2, dim> half = 0.5 * plain_gradient;
        Tensor<1, dim> plain_v;
        for (unsigned int d = 0; d < dim; ++d)
          {
            half[d][d] += 1.;
            plain_v[d] = plain(v[d]);
          }
        const Tensor<2, dim>          inverse = invert(half);
        const Components<dim, Number> guess =
          constant<dim, Number>(inverse * plain_v);
        const Components<dim, Number> misfit =
          v.plus(-1., guess).plus(-0.5, turned(guess));
        return corrected(guess, inverse, misfit);
      }

      /** guess + A misfit. */
      static Components<dim, Number>
      corrected(Components<dim, Number>        guess,
                const Tensor<2, dim>          &A,
                const Components<dim, Number> &misfit)
      {
        for (unsigned int i = 0; i < dim; ++i)
          for (unsigned int j = 0; j < dim; ++j)
            guess[i] += A[i][j] * misfit[j];
        return guess;
      }
    };

    /** @param unknown called with the index of an unknown and its value */
    template <int dim, class Number, class Unknown>
    Moving<dim, Number>
    moving(const PairPoint<dim> &point, const Unknown &unknown)
    {
      Moving<dim, Number> result;
      for (unsigned int i = 0; i < dim; ++i)
        {
          result.way[i] = unknown((dim + 1) * i, point.way[i]);
          for (unsigned int j = 0; j < dim; ++j)
            result.gradient[i][j] =
              unknown((dim + 1) * i + 1 + j, point.gradient[i][j]);
        }
      result.arm = constant<dim, Number>(point.arm);
      if (point.at_middle)
        {
          // a = a_t + L a/2, solved by one Newton step at its solution
          const auto misfit = constant<dim, Number>(point.arm_old - point.arm)
                                .plus(0.5, result.turned(result.arm));
          result.arm =
            Moving<dim, Number>::corrected(result.arm, point.Z, misfit);
        }
      result.way = result.way.plus(1., result.turned(result.arm));
      return result;
    }

    /** What an evaluation finds, in numbers that may know derivatives. */
    template <int dim, class Number>
    struct Forces
    {
      std::array<Number, PairAction<dim>::n_motion> first, second;

      Forces()
      {
        first.fill(0.);
        second.fill(0.);
      }

      static void
      add(const Number                                  &factor,
          const Components<dim, Number>                 &force,
          const Components<dim, Number>                 &arm,
          std::array<Number, PairAction<dim>::n_motion> &sum)
      {
        for (unsigned int i = 0; i < dim; ++i)
          {
            sum[(dim + 1) * i] += factor * force[i];
            for (unsigned int l = 0; l < dim; ++l)
              sum[(dim + 1) * i + 1 + l] += factor * force[i] * arm[l];
          }
      }
    };

    template <int dim, class Number>
    class Evaluation
    {
    public:
      using V = Components<dim, Number>;

      Evaluation(const PairLaw        &law,
                 const PairPoint<dim> &first,
                 const PairPoint<dim> &second,
                 const Tensor<1, dim> &spring,
                 PairAction<dim>      &result)
        : law(law)
        , first(first)
        , second(second)
        , spring_old(spring)
        , result(result)
      {}

      template <class Unknown>
      Forces<dim, Number>
      operator()(const Unknown &unknown)
      {
        constexpr unsigned int n = PairAction<dim>::n_motion;
        const auto             one =
          moving<dim, Number>(first, [&](const auto i, const double v) {
            return unknown(i, v);
          });
        const auto two =
          moving<dim, Number>(second, [&](const auto i, const double v) {
            return unknown(n + i, v);
          });
        const Tensor<1, dim> before = first.place() - second.place();
        const double         d_old  = before.norm();
        const V              way    = one.way.plus(-1., two.way);
        const V      at_end = constant<dim, Number>(before).plus(1., way);
        const V      mean   = constant<dim, Number>(before).plus(0.5, way);
        const Number square = at_end.dot(at_end);
        const Number d_new  = sqrt_of(square);
        const Number gap    = d_new - law.reach;
        result.gap_old      = d_old - law.reach;
        result.gap_new      = plain(gap);

        Forces<dim, Number> forces;
        result.spring_stored = result.slip = 0.;
        if (result.gap_old >= 0.)
          let_go(spring_old); // what is open at the start has let go
        if (result.gap_old >= 0. && result.gap_new >= 0.)
          return forces;
        result.acts = true;
        result.stored =
          pair_energy(law, result.gap_new) - pair_energy(law, result.gap_old);
        const Number c =
          -2. * quotient(law, result.gap_old, gap) / (d_old + d_new);
        forces.add(c, mean, one.arm, forces.first);
        forces.add(-c, mean, two.arm, forces.second);
        for (unsigned int i = 0; i < dim; ++i)
          result.force[i] = plain(c) * plain(mean[i]);
        if (law.friction > 0.)
          add_friction(c, mean, way, one, two, forces);
        return forces;
      }

    private:
      void
      let_go(const Tensor<1, dim> &spring)
      {
        const double lost = 0.5 * law.spring_stiffness * spring.norm_square();
        result.spring_stored -= lost;
        result.slip += lost;
      }

      /** xi at the start, laid into the plane across n with its length kept. */
      V
      laid_spring(const V &n) const
      {
        const V spring = constant<dim, Number>(
          result.gap_old >= 0. ? Tensor<1, dim>() : spring_old);
        const V      across = spring.across(n);
        const Number square = across.dot(across);
        if (!(plain(square) > 0.))
          return spring.times(0.);
        const Number factor = spring_old.norm() / sqrt_of(square);
        return across.times(factor);
      }

      void
      add_friction(const Number              &c,
                   const V                   &mean,
                   const V                   &way,
                   const Moving<dim, Number> &one,
                   const Moving<dim, Number> &two,
                   Forces<dim, Number>       &forces)
      {
        const Number square = mean.dot(mean);
        const Number length = sqrt_of(square);
        const Number limit  = law.friction * c * length;
        const Number scale  = 1. / length;
        const V      n      = mean.times(scale);
        const V      b_one  = common(one, first, mean).times(-law.share),
                b_two       = common(two, second, mean).times(1. - law.share);
        const V slide       = way.plus(1., one.turned(b_one))
                          .plus(-1., two.turned(b_two))
                          .across(n);
        const V      spring = laid_spring(n);
        const double k      = law.spring_stiffness;
        V            T      = spring.plus(0.5, slide).times(k);
        const Number trial  = T.dot(T);
        if (plain(trial) > plain(limit) * plain(limit))
          {
            const Number factor = limit / sqrt_of(trial);
            T                   = T.times(factor);
          }
        forces.add(-1., T, one.arm.plus(1., b_one), forces.first);
        forces.add(1., T, two.arm.plus(1., b_two), forces.second);

        double work = 0.;
        for (unsigned int i = 0; i < dim; ++i)
          {
            work += plain(T[i]) * plain(slide[i]);
            result.force[i] -= plain(T[i]);
            result.spring[i] = 2. / k * plain(T[i]) - plain(spring[i]);
          }
        if (const double stretch = result.spring.norm();
            k * stretch > plain(limit))
          result.spring *= plain(limit) / (k * stretch);
        const double before =
          result.gap_old >= 0. ? 0. : spring_old.norm_square();
        const double gain = 0.5 * k * (result.spring.norm_square() - before);
        result.spring_stored += gain;
        result.slip += work - gain;
        if (result.gap_new >= 0.)
          {
            let_go(result.spring);
            result.spring = Tensor<1, dim>();
          }
      }

      /** From a point to the common place, but for its sign and share. */
      V
      common(const Moving<dim, Number> &moving,
             const PairPoint<dim>      &point,
             const V                   &mean) const
      {
        return point.at_middle ? mean
                               : moving.turned_back(mean, point.gradient);
      }

      const PairLaw        &law;
      const PairPoint<dim> &first, &second;
      const Tensor<1, dim> &spring_old;
      PairAction<dim>      &result;
    };
  } // namespace

  double
  pair_energy(const PairLaw &law, const double gap)
  {
    return energy(law, gap);
  }

  template <int dim>
  PairAction<dim>
  pair_action(const PairLaw        &law,
              const PairPoint<dim> &first,
              const PairPoint<dim> &second,
              const Tensor<1, dim> &spring,
              const bool            with_derivative)
  {
    constexpr unsigned int n = PairAction<dim>::n_motion;
    PairAction<dim>        result;
    const auto             forces =
      Evaluation<dim, double>(law, first, second, spring, result)(
        [](const unsigned int, const double value) { return value; });
    for (unsigned int i = 0; i < n; ++i)
      {
        result.value[i]     = forces.first[i];
        result.value[n + i] = forces.second[i];
      }
    if (!with_derivative || !result.acts)
      return result;
    using Number = Sacado::Fad::SFad<double, 2 * n>;
    PairAction<dim> same;
    const auto      varied =
      Evaluation<dim, Number>(law, first, second, spring, same)(
        [](const unsigned int i, const double value) {
          return Number(2 * n, i, value);
        });
    for (unsigned int i = 0; i < n; ++i)
      for (unsigned int j = 0; j < 2 * n; ++j)
        {
          result.derivative[i][j]     = varied.first[i].dx(j);
          result.derivative[n + i][j] = varied.second[i].dx(j);
        }
    return result;
  }

  template PairAction<2>
  pair_action<2>(const PairLaw &,
                 const PairPoint<2> &,
                 const PairPoint<2> &,
                 const Tensor<1, 2> &,
                 const bool);
  template PairAction<3>
  pair_action<3>(const PairLaw &,
                 const PairPoint<3> &,
                 const PairPoint<3> &,
                 const Tensor<1, 3> &,
                 const bool);
} // namespace emmy
