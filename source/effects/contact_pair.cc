#include <emmy/effects/pair_law.h>

#include <Sacado.hpp>


namespace emmy
{
  using dealii::Tensor;
  using namespace pair_law;

  namespace
  {
    /** How a particle carries its contact point, and the common place. */
    template <int dim>
    struct Carried
    {
      double         sign;        ///< of its way in w: 1 for the first
      double         share;       ///< of x_m in b: -alpha, or 1 - alpha
      Tensor<1, dim> arm, place;  ///< a, and b without friction's share: m
      Tensor<2, dim> by_gradient; ///< M: the way changes by M dL a
      Tensor<2, dim> inverse;     ///< Y: b = share Y x_m
      bool           at_middle;

      Carried(const PairPoint<dim> &point,
              const double          sign,
              const double          share,
              const bool            has_friction)
        : sign(sign)
        , share(share)
        , arm(point.arm)
        , by_gradient(dealii::unit_symmetric_tensor<dim>())
        , inverse(dealii::unit_symmetric_tensor<dim>())
        , at_middle(point.at_middle)
      {
        if (at_middle)
          by_gradient = point.Z; // I + L Z/2
        else if (has_friction)
          inverse = invert(inverse + 0.5 * point.gradient);
      }
    };

    /** How the push changes with w and the slide. */
    template <int dim>
    struct PushByMotion
    {
      Tensor<2, dim> force_by_way, force_by_slide, friction_by_way,
        friction_by_slide;
    };

    /** Of both particles, and what they push each other with. */
    template <int dim>
    class Pair
    {
    public:
      using Motion = std::array<double, PairAction<dim>::n_motion>;

      Pair(const PairLaw        &law,
           const PairPoint<dim> &first,
           const PairPoint<dim> &second)
        : law(law)
        , has_friction(law.friction > 0.)
        , gradients{{first.gradient, second.gradient}}
        , of{{{first, 1., -law.share, has_friction},
              {second, -1., 1. - law.share, has_friction}}}
      {}

      /** The forces, which the result then has. */
      void
      evaluate(const Tensor<1, dim>      &before,
               const Tensor<1, dim>      &way,
               const Tensor<1, dim>      &spring,
               PairDerivative<dim> *const derivative,
               PairAction<dim>           &result)
      {
        Tensor<1, dim> slide = way;
        if (has_friction)
          for (unsigned int p = 0; p < 2; ++p)
            {
              of[p].place =
                of[p].share * (of[p].inverse * (before + 0.5 * way));
              slide += of[p].sign * (gradients[p] * of[p].place);
            }
        if (!derivative)
          {
            take(Evaluation<dim, double>(law, before, spring, result)(
              constant<dim, double>(way), constant<dim, double>(slide)));
            set_value(result);
            return;
          }
        using Number = Sacado::Fad::SFad<double, 2 * dim>;
        Components<dim, Number> varied_way, varied_slide;
        for (unsigned int i = 0; i < dim; ++i)
          {
            varied_way[i]   = Number(2 * dim, i, way[i]);
            varied_slide[i] = Number(2 * dim, dim + i, slide[i]);
          }
        const auto push =
          Evaluation<dim, Number>(law, before, spring, result)(varied_way,
                                                               varied_slide);
        take(push);
        set_value(result);
        PushByMotion<dim> by;
        for (unsigned int i = 0; i < dim; ++i)
          for (unsigned int j = 0; j < dim; ++j)
            {
              by.force_by_way[i][j]   = push.force[i].dx(j);
              by.force_by_slide[i][j] = push.force[i].dx(dim + j);
              if (!has_friction)
                continue;
              by.friction_by_way[i][j]   = push.friction[i].dx(j);
              by.friction_by_slide[i][j] = push.friction[i].dx(dim + j);
            }
        add_derivative(by, *derivative);
      }

    private:
      template <class Number>
      void
      take(const Push<dim, Number> &push)
      {
        for (unsigned int i = 0; i < dim; ++i)
          {
            force[i]    = plain(push.force[i]);
            friction[i] = has_friction ? plain(push.friction[i]) : 0.;
          }
      }

      /** f at a, and -T at b: on the first; on the second against them. */
      void
      set_value(PairAction<dim> &result) const
      {
        constexpr unsigned int n = PairAction<dim>::n_motion;
        for (unsigned int p = 0; p < 2; ++p)
          for (unsigned int i = 0; i < dim; ++i)
            {
              double *value = &result.value[n * p + (dim + 1) * i];
              value[0]      = of[p].sign * force[i];
              for (unsigned int l = 0; l < dim; ++l)
                value[1 + l] = of[p].sign * (force[i] * of[p].arm[l] -
                                             friction[i] * of[p].place[l]);
            }
      }

      /** A dw + B (slide of dL b) for the unknowns of a particle. */
      static std::array<Motion, dim>
      by_unknowns(const Tensor<2, dim> &A,
                  const Tensor<2, dim> &B,
                  const Carried<dim>   &by)
      {
        std::array<Motion, dim> result;
        const Tensor<2, dim>    along = by.at_middle ? A * by.by_gradient : A,
                             turned   = by.at_middle ? B : B * by.inverse;
        const Tensor<1, dim> arm = by.sign * by.arm, place = by.sign * by.place;
        for (unsigned int i = 0; i < dim; ++i)
          for (unsigned int j = 0; j < dim; ++j)
            {
              double *entry = &result[i][(dim + 1) * j];
              entry[0]      = by.sign * A[i][j];
              for (unsigned int m = 0; m < dim; ++m)
                entry[1 + m] = along[i][j] * arm[m] + turned[i][j] * place[m];
            }
        return result;
      }

      /**
       * With dw = sum of sign (du + M dL a) and b = share Y x_m, the slide w +
       * L_1 b_1 - L_2 b_2 changes by Q dw and sign Y dL b.
       */
      void
      add_derivative(const PushByMotion<dim> &by,
                     PairDerivative<dim>     &result) const
      {
        if (!has_friction)
          {
            for (unsigned int column = 0; column < 2; ++column)
              {
                const auto df =
                  by_unknowns(by.force_by_way, Tensor<2, dim>(), of[column]);
                for (unsigned int row = 0; row < 2; ++row)
                  add_forces(df, of[row], result.of[row][column]);
              }
            if (of[0].at_middle)
              turn_arms(result);
            return;
          }
        Tensor<2, dim> Q = dealii::unit_symmetric_tensor<dim>();
        for (unsigned int p = 0; p < 2; ++p)
          Q +=
            (0.5 * of[p].sign * of[p].share) * (gradients[p] * of[p].inverse);
        const Tensor<2, dim> A = by.force_by_way + by.force_by_slide * Q,
                             C = by.friction_by_way + by.friction_by_slide * Q;
        for (unsigned int column = 0; column < 2; ++column)
          {
            const auto df = by_unknowns(A, by.force_by_slide, of[column]),
                       dT = by_unknowns(C, by.friction_by_slide, of[column]);
            for (unsigned int row = 0; row < 2; ++row)
              {
                const Carried<dim> &on    = of[row];
                auto               &block = result.of[row][column];
                add_forces(df, on, block);
                // b by dw
                const auto db = by_unknowns((0.5 * on.share) * on.inverse,
                                            Tensor<2, dim>(),
                                            of[column]);
                for (unsigned int i = 0; i < dim; ++i)
                  for (unsigned int l = 0; l < dim; ++l)
                    {
                      const double place = on.sign * on.place[l],
                                   T     = on.sign * friction[i];
                      Motion &entry      = block[(dim + 1) * i + 1 + l];
                      for (unsigned int z = 0; z < entry.size(); ++z)
                        entry[z] -= dT[i][z] * place + T * db[l][z];
                    }
              }
          }
        turn_arms(result);
      }

      /** sign df, and sign df (x) a behind it. */
      static void
      add_forces(const std::array<Motion, dim>       &df,
                 const Carried<dim>                  &on,
                 typename PairDerivative<dim>::Block &block)
      {
        for (unsigned int l = 0; l <= dim; ++l)
          {
            const double arm = l == 0 ? on.sign : on.sign * on.arm[l - 1];
            for (unsigned int i = 0; i < dim; ++i)
              {
                Motion &entry = block[(dim + 1) * i + l];
                for (unsigned int z = 0; z < entry.size(); ++z)
                  entry[z] += arm * df[i][z];
              }
          }
      }

      /** da = Z dL a/2 in the middle; else db = -Y dL b/2. */
      void
      turn_arms(PairDerivative<dim> &result) const
      {
        for (unsigned int p = 0; p < 2; ++p)
          {
            const Carried<dim>  &on = of[p];
            const Tensor<1, dim> f =
              (0.5 * on.sign) * (on.at_middle ? force : friction);
            const Tensor<1, dim> &arm = on.at_middle ? on.arm : on.place;
            const Tensor<2, dim> &turned =
              on.at_middle ? on.by_gradient : on.inverse;
            for (unsigned int i = 0; i < dim; ++i)
              for (unsigned int l = 0; l < dim; ++l)
                for (unsigned int j = 0; j < dim; ++j)
                  for (unsigned int m = 0; m < dim; ++m)
                    result
                      .of[p][p][(dim + 1) * i + 1 + l][(dim + 1) * j + 1 + m] +=
                      f[i] * turned[l][j] * arm[m];
          }
      }

      const PairLaw                      &law;
      const bool                          has_friction;
      const std::array<Tensor<2, dim>, 2> gradients; ///< L
      std::array<Carried<dim>, 2>         of;
      Tensor<1, dim>                      force, friction;
    };
  } // namespace

  double
  pair_energy(const PairLaw &law, const double gap)
  {
    return energy(law, gap);
  }

  template <int dim>
  PairAction<dim>
  pair_action(const PairLaw             &law,
              const PairPoint<dim>      &first,
              const PairPoint<dim>      &second,
              const Tensor<1, dim>      &spring,
              PairDerivative<dim> *const derivative)
  {
    PairAction<dim>      result;
    const Tensor<1, dim> before = first.place() - second.place(),
                         way    = first.way + first.gradient * first.arm -
                               second.way - second.gradient * second.arm;
    result.gap_old = before.norm() - law.reach;
    result.gap_new = (before + way).norm() - law.reach;
    if (result.gap_old >= 0.)
      let_go(law, spring, result); // what is open at the start has let go
    if (result.gap_old >= 0. && result.gap_new >= 0.)
      return result;
    result.acts = true;
    result.stored =
      pair_energy(law, result.gap_new) - pair_energy(law, result.gap_old);
    Pair<dim>(law, first, second)
      .evaluate(before, way, spring, derivative, result);
    return result;
  }

  template PairAction<2>
  pair_action<2>(const PairLaw &,
                 const PairPoint<2> &,
                 const PairPoint<2> &,
                 const Tensor<1, 2> &,
                 PairDerivative<2> *);
  template PairAction<3>
  pair_action<3>(const PairLaw &,
                 const PairPoint<3> &,
                 const PairPoint<3> &,
                 const Tensor<1, 3> &,
                 PairDerivative<3> *);
} // namespace emmy
