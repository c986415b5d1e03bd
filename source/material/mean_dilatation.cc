#include <emmy/material/conserving_stress.h>
#include <emmy/material/mean_dilatation.h>
#include <emmy/math/divided_volume.h>
#include <emmy/math/kinematics.h>

#include <cmath>

namespace emmy
{
  using dealii::Tensor;

  namespace
  {
    /** As those of the conserving rule, see conserving_stress.cc. */
    constexpr double smallest_square = 1e-250, smallest_slope = 1e-8;

    template <int dim>
    using InPlane = Tensor<1, n_in_plane<dim>>;
    template <int dim>
    using InPlaneMatrix = Tensor<2, n_in_plane<dim>>;

    /** The components of the dim x dim block. */
    template <int dim>
    InPlane<dim>
    in_plane(const MandelVector<dim> &a)
    {
      InPlane<dim> result;
      for (unsigned int i = 0; i < n_in_plane<dim>; ++i)
        result[i] = a[i];
      return result;
    }
    template <int dim>
    InPlaneMatrix<dim>
    in_plane(const MandelMatrix<dim> &a)
    {
      InPlaneMatrix<dim> result;
      for (unsigned int i = 0; i < n_in_plane<dim>; ++i)
        for (unsigned int j = 0; j < n_in_plane<dim>; ++j)
          result[i][j] = a[i][j];
      return result;
    }

    /** The tensor with these components; in plane strain a_33 is zero. */
    template <int dim>
    MandelVector<dim>
    whole(const InPlane<dim> &a)
    {
      MandelVector<dim> result;
      for (unsigned int i = 0; i < n_in_plane<dim>; ++i)
        result[i] = a[i];
      return result;
    }
    template <int dim>
    MandelMatrix<dim>
    whole(const InPlaneMatrix<dim> &a)
    {
      MandelMatrix<dim> result;
      for (unsigned int i = 0; i < n_in_plane<dim>; ++i)
        for (unsigned int j = 0; j < n_in_plane<dim>; ++j)
          result[i][j] = a[i][j];
      return result;
    }

    template <int dim>
    Tensor<2, dim>
    identity()
    {
      return dealii::unit_symmetric_tensor<dim>();
    }

    template <int dim>
    InPlane<dim>
    unit_in_plane()
    {
      return in_plane<dim>(mandel::unit<dim>());
    }

    /** Of a dim x dim tensor. */
    template <int dim>
    InPlane<dim>
    symmetric(const Tensor<2, dim> &a)
    {
      return in_plane<dim>(mandel::symmetric_part<dim>(a));
    }

    /** (theta/j)^(1/3) - 1 */
    template <int dim>
    double
    scale_less_one(const CellPoint<dim> &point)
    {
      return std::expm1(
        (std::log1p(point.mean_change) - std::log1p(point.own_change)) / 3.);
    }

    /** (1 + scale)^2 b of a step without scale, less the unit tensor. */
    template <int dim>
    MandelVector<dim>
    scaled(const MandelVector<dim> &less_unit, const double scale)
    {
      return less_unit +
             (2. + scale) * scale * mandel::plus_unit<dim>(less_unit);
    }

    /** The states of a batch at t + dt, with scaled increments. */
    template <int dim>
    void
    update_scaled_states(const Material<dim>  &material,
                         const CellPoint<dim> *points,
                         const bool            with_energy_change,
                         StressBatch<dim>     &batch)
    {
      const auto &elastic_old =
        batch.is_inelastic ? batch.elastic_left_cauchy_green_less_unit_old
                           : batch.left_cauchy_green_less_unit_old;
      std::array<Tensor<2, dim>, max_batch_points> H;
      std::array<double, max_batch_points>         scales;
      for (unsigned int p = 0; p < batch.n_points; ++p)
        {
          const auto  &own   = batch.displacement_gradient[p];
          const double scale = scales[p] = scale_less_one(points[p]);
          H[p] = (1. + scale) * own + scale * identity<dim>();
          batch.material.left_cauchy_green_less_unit[p] =
            scaled<dim>(left_cauchy_green_less_unit<dim>(own, elastic_old[p]),
                        scale);
          if (batch.is_inelastic)
            batch.left_cauchy_green_less_unit[p] =
              scaled<dim>(left_cauchy_green_less_unit<dim>(
                            own, batch.left_cauchy_green_less_unit_old[p]),
                          scale);
        }
      batch.material.n_points     = batch.n_points;
      batch.material.with_tangent = batch.with_tangent;
      batch.material.with_energy_change =
        with_energy_change && material.gives_energy_change();
      batch.material.step = {H.data(),
                             elastic_old.data(),
                             batch.kirchhoff_stress_old.data(),
                             dim == 2 ? scales.data() : nullptr};
      material.evaluate(batch.material);
      batch.material.step.displacement_gradient = nullptr; // gone
      batch.material.step.out_of_plane          = nullptr;
    }

    /** What a stress at t + dt says relative to t: dev, and as C changes. */
    template <int dim>
    struct EndStress
    {
      double            pressure; ///< tr tau/3
      InPlane<dim>      deviator; ///< Delta F^-1 dev tau Delta F^-T
      InPlane<dim>      inverse_C;
      MandelMatrix<dim> Q; ///< the congruence of Delta F^-1

      EndStress(const Tensor<2, dim> &F, const MandelVector<dim> &tau)
        : pressure(mandel::unit<dim>() * tau / 3.)
        , Q(mandel::congruence<dim>(invert(F)))
      {
        deviator  = in_plane<dim>(Q * (tau - pressure * mandel::unit<dim>()));
        inverse_C = in_plane<dim>(Q * mandel::unit<dim>());
      }
    };

    /** Its derivatives; theta enters through the trial of the material. */
    template <int dim>
    struct EndSlope
    {
      InPlaneMatrix<dim> deviator_by_C;   ///< 2 d/dC
      InPlane<dim>       deviator_by_log; ///< d/d ln theta
      InPlane<dim>       pressure_by_C;   ///< d/dC
      double             pressure_by_log;

      /**
       * With the material's c, L_v tau = c : d, d the symmetric part of
       * dDelta F Delta F^-1, and that of the trial d + g I,
       * g = (d ln theta - tr d)/3:
       * d(F^-1 tau F^-T) = F^-1 (c : d + g (c : I + 2 tau)) F^-T,
       * dp = ((I : c + 2 tau) : d + g (I : c : I + 2 tr tau))/3.
       */
      EndSlope(const EndStress<dim>    &end,
               const MandelVector<dim> &tau,
               const MandelMatrix<dim> &c)
      {
        const MandelVector<dim> unit  = mandel::unit<dim>();
        const MandelVector<dim> right = c * unit + 2. * tau,
                                left  = unit * c + 2. * tau;
        const double       k       = (unit * c * unit + 6. * end.pressure) / 3.;
        const InPlane<dim> Q_right = in_plane<dim>(end.Q * right),
                           Q_left  = in_plane<dim>(end.Q * left);
        const auto &inverse_C      = end.inverse_C;

        deviator_by_log = (Q_right - k * inverse_C) / 3.;
        deviator_by_C =
          in_plane<dim>(mandel::transform<dim>(end.Q, c) +
                        2. * end.pressure * end.Q * transpose(end.Q)) -
          outer_product(deviator_by_log, inverse_C) -
          outer_product(inverse_C, Q_left) / 3.;
        pressure_by_C   = (Q_left - k * inverse_C) / 6.;
        pressure_by_log = k / 3.;
      }
    };

    /** D with D : A = j - 1, and 2 dD/dC. */
    template <int dim>
    struct RatioGradient
    {
      InPlane<dim>       value;
      InPlaneMatrix<dim> by_C;
    };

    /** See divided_volume(). */
    template <int dim>
    RatioGradient<dim>
    ratio_gradient(const Tensor<2, dim> &A,
                   const double          j,
                   const InPlane<dim>   &inverse_C,
                   const bool            with_derivative)
    {
      const auto         unit   = unit_in_plane<dim>();
      const double       factor = 1. / (j + 1.);
      RatioGradient<dim> result;
      result.value = symmetric<dim>(divided_volume(A, j));
      if (!with_derivative)
        return result;
      if constexpr (dim == 2)
        {
          result.by_C = factor * outer_product(unit, unit);
          for (unsigned int i = 0; i < unit.dimension; ++i)
            result.by_C[i][i] -= factor;
        }
      else
        {
          // d cof(X) is linear in X; Y = 6 times the mean of s (I + sA)
          constexpr auto ij      = mandel::pairs<dim>();
          const auto     Y       = 3. * identity<dim>() + 2. * A;
          const double   trace_Y = trace(Y);
          for (unsigned int a = 0; a < unit.dimension; ++a)
            {
              Tensor<2, dim>     X;
              const unsigned int k = ij[a][0], l = ij[a][1];
              X[k][l] = X[l][k]      = a < dim ? 1. : 1. / mandel::sqrt2;
              const double   trace_X = trace(X);
              Tensor<2, dim> change = Y * X + X * Y - trace_Y * X - trace_X * Y;
              const double diagonal = trace_X * trace_Y - scalar_product(X, Y);
              for (unsigned int d = 0; d < dim; ++d)
                change[d][d] += diagonal;
              const auto column = symmetric<dim>(change);
              for (unsigned int b = 0; b < unit.dimension; ++b)
                result.by_C[b][a] = factor / 3. * column[b];
            }
        }
      // dj = j/2 C^-1 : dC
      result.by_C -= j * factor * outer_product(result.value, inverse_C);
      return result;
    }
  } // namespace

  template <int dim>
  double
  volume_change(const Tensor<2, dim> &H)
  {
    if constexpr (dim == 2)
      return trace(H) + determinant(H);
    else
      {
        double minors = 0.;
        for (unsigned int i = 0; i < 3; ++i)
          {
            const unsigned int k = (i + 1) % 3;
            minors += H[i][i] * H[k][k] - H[i][k] * H[k][i];
          }
        return trace(H) + minors + determinant(H);
      }
  }

  template <int dim>
  MeanDilatationStress<dim>::MeanDilatationStress(const Kind kind)
    : kind(kind)
  {}

  template <int dim>
  void
  MeanDilatationStress<dim>::own_stress(const Material<dim> &material,
                                        StressBatch<dim>    &batch,
                                        CellPoint<dim>      *points) const
  {
    const bool is_conserving = kind == Kind::conserving;
    update_scaled_states(material, points, is_conserving, batch);
    if (is_conserving)
      subtract_energies(material.gives_energy_change(), batch);
    for (unsigned int p = 0; p < batch.n_points; ++p)
      {
        CellPoint<dim> &point = points[p];
        const auto     &tau   = batch.material.kirchhoff_stress[p];
        point.mean_stress_end = mandel::unit<dim>() * tau / 3.;
        if (is_conserving)
          {
            conserve(material, batch, p, point);
            continue;
          }
        const double         theta = 1. + point.mean_change;
        const EndStress<dim> end(identity<dim>() +
                                   batch.displacement_gradient[p],
                                 tau);
        point.S           = end.deviator;
        point.mean_stress = end.pressure / theta;
        if (!batch.with_tangent)
          continue;
        const EndSlope<dim> slope(end, tau, batch.material.spatial_tangent[p]);
        point.S_by_C           = slope.deviator_by_C;
        point.S_by_mean        = slope.deviator_by_log / theta;
        point.mean_stress_by_C = 2. / theta * slope.pressure_by_C;
        point.mean_stress_by_mean =
          (slope.pressure_by_log - end.pressure) / (theta * theta);
      }
  }

  template <int dim>
  void
  MeanDilatationStress<dim>::conserve(const Material<dim> &material,
                                      StressBatch<dim>    &batch,
                                      const unsigned int   p,
                                      CellPoint<dim>      &point) const
  {
    const auto  &H        = batch.displacement_gradient[p];
    const auto  &tau      = batch.material.kirchhoff_stress[p];
    const auto  &tau_old  = batch.kirchhoff_stress_old[p];
    const auto   unit     = mandel::unit<dim>();
    const double mean_old = unit * tau_old / 3., change = point.mean_change,
                 theta = 1. + change;
    const EndStress<dim> end(identity<dim>() + H, tau);
    const auto           A = symmetric<dim>(2. * H + transpose(H) * H);
    const auto          &elastic_old = batch.is_inelastic
                                         ? batch.elastic_left_cauchy_green_less_unit_old
                                         : batch.left_cauchy_green_less_unit_old;
    const auto   b = mandel::block<dim>(mandel::plus_unit<dim>(elastic_old[p]));
    const auto   Qb = in_plane<dim>(mandel::congruence<dim>(b)); // X -> b X b
    const auto   b_squared = symmetric<dim>(b * b);
    const double unit_unit = unit_in_plane<dim>() * b_squared;
    const double kappa     = 4. / 9. * unit_unit;

    const auto mean_S =
      0.5 * (in_plane<dim>(tau_old - mean_old * unit) + end.deviator);
    const double mean_Pi = 0.5 * (mean_old + end.pressure / theta);
    const auto B = Qb * A - (b_squared * A / unit_unit) * b_squared; // b A_d b
    const double nu = A * B + kappa * change * change;
    const double missing =
      missing_energy(batch, p, mean_S * A + 2. * mean_Pi * change); // eta
    const double beta = nu > smallest_square ? missing / nu : 0.;
    point.S           = mean_S + beta * B;
    point.mean_stress = mean_Pi + 0.5 * kappa * beta * change;
    if (!batch.with_tangent)
      return;

    const EndSlope<dim> slope(end, tau, batch.material.spatial_tangent[p]);
    const double        mean_by_log =
      0.5 * (slope.pressure_by_log - end.pressure) / theta;
    point.S_by_C              = 0.5 * slope.deviator_by_C;
    point.S_by_mean           = 0.5 / theta * slope.deviator_by_log;
    point.mean_stress_by_C    = slope.pressure_by_C / theta;
    point.mean_stress_by_mean = mean_by_log / theta;
    if (!(nu > smallest_square &&
          nu > smallest_slope * smallest_slope * elastic_old[p].norm_square()))
      return;
    // d(psi + dissipation) of the material, unless it knows better
    const bool           has_own = material.gives_energy_stress();
    const EndStress<dim> energy =
      has_own
        ? EndStress<dim>(identity<dim>() + H, batch.material.energy_stress[p])
        : end;
    const auto beta_by_C =
      (energy.deviator - 0.25 * (A * slope.deviator_by_C) - mean_S -
       change / theta * slope.pressure_by_C - 2. * beta * B) /
      nu;
    const double beta_by_log =
      (2. * energy.pressure - 0.5 * (A * slope.deviator_by_log) -
       2. * change * mean_by_log - 2. * mean_Pi * theta -
       2. * beta * kappa * change * theta) /
      nu;
    point.S_by_C +=
      2. * outer_product(B, beta_by_C) +
      2. * beta * (Qb - outer_product(b_squared, b_squared) / unit_unit);
    point.S_by_mean += beta_by_log / theta * B;
    point.mean_stress_by_C += kappa * change * beta_by_C;
    point.mean_stress_by_mean +=
      0.5 * kappa * (change * beta_by_log / theta + beta);
  }

  template <int dim>
  CellLink<dim>
  MeanDilatationStress<dim>::whole_stress(const CellPoint<dim> &point,
                                          const double          cell_stress,
                                          const unsigned int    p,
                                          StressBatch<dim>     &batch) const
  {
    const bool           is_at_rest = kind == Kind::at_rest;
    const auto          &H          = batch.displacement_gradient[p];
    const Tensor<2, dim> F = identity<dim>() + H, inverse = invert(F);
    const Tensor<2, dim> Fm =
      is_at_rest ? F : Tensor<2, dim>(identity<dim>() + 0.5 * H);
    const double       j         = 1. + point.own_change;
    const auto         Q         = mandel::congruence<dim>(inverse);
    const auto         inverse_C = in_plane<dim>(Q * mandel::unit<dim>());
    RatioGradient<dim> D; // at rest that of the derivative, j/2 C^-1
    if (!is_at_rest)
      D = ratio_gradient<dim>(H + transpose(H) + transpose(H) * H,
                              j,
                              inverse_C,
                              batch.with_tangent);
    else
      {
        D.value = 0.5 * j * inverse_C;
        D.by_C  = 0.5 * j *
                 (outer_product(inverse_C, inverse_C) -
                  2. * in_plane<dim>(Q * transpose(Q)));
      }
    const auto by_mean_stress = 2. * point.volume_ratio * D.value;
    const auto S = whole<dim>(point.S + cell_stress * by_mean_stress);
    batch.nominal_stress[p] = Fm * mandel::block<dim>(S);
    CellLink<dim> link;
    if (!batch.with_tangent)
      return link;

    const auto C =
      whole<dim>(point.S_by_C + 2. * point.volume_ratio * cell_stress * D.by_C);
    batch.tangent[p] = nominal_tangent<dim>(Fm, F, S, C);
    if (is_at_rest) // the increment grows with dH, not dH/2
      batch.tangent[p] += nominal_tangent<dim>(Fm, F, S, {});
    link.stress_by_mean_stress =
      Fm * mandel::block<dim>(whole<dim>(by_mean_stress));
    link.stress_by_mean = Fm * mandel::block<dim>(whole<dim>(point.S_by_mean));
    link.change_by_H    = j * transpose(inverse);
    link.mean_stress_by_H =
      F * mandel::block<dim>(whole<dim>(point.mean_stress_by_C));
    return link;
  }

#define INSTANTIATE(dim)                    \
  template class MeanDilatationStress<dim>; \
  template double volume_change<dim>(const Tensor<2, dim> &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
