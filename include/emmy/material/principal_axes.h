#ifndef emmy_material_principal_axes_h
#define emmy_material_principal_axes_h

#include <emmy/material/material.h>
#include <emmy/math/spectral.h>

namespace emmy
{
  /**
   * The logarithmic strain e = 1/2 ln b of a point in the principal axes of
   * b, where isotropic laws are a matter of three numbers. In the kernels of
   * the materials only.
   */
  template <int dim>
  struct PrincipalStrain
  {
    SpectralDecomposition<dim> b;                ///< b - I
    std::array<double, 3>      log_b;            ///< ln(1 + b.values)
    std::array<double, 3>      deviator;         ///< dev e
    double                     trace;            ///< tr e
    double                     deviator_squared; ///< |dev e|^2
  };

  /** Of the tensors b - I of the trial. */
  template <int dim>
  inline std::array<SpectralDecomposition<dim>, max_batch_points>
  spectral_decompositions(const MaterialBatch<dim> &batch)
  {
    static_assert(max_batch_points <= max_spectral_batch, "");
    std::array<SpectralDecomposition<dim>, max_batch_points> result;
    spectral_decompositions<dim>(batch.left_cauchy_green_less_unit.data(),
                                 batch.n_points,
                                 result.data());
    return result;
  }

  /** Cost: three logarithms. @param b spectral decomposition of b - I */
  template <int dim>
  inline PrincipalStrain<dim>
  principal_strain(const SpectralDecomposition<dim> &b)
  {
    PrincipalStrain<dim> e;
    e.b = b;
    for (unsigned int i = 0; i < 3; ++i)
      e.log_b[i] = log_one_plus(e.b.values[i]);
    e.trace = 0.5 * (e.log_b[0] + e.log_b[1] + e.log_b[2]);

    e.deviator_squared = 0.;
    for (unsigned int i = 0; i < 3; ++i)
      {
        e.deviator[i] = 0.5 * e.log_b[i] - e.trace / 3.;
        e.deviator_squared += e.deviator[i] * e.deviator[i];
      }
    return e;
  }

  /** A tensor with these values along the principal axes of b. */
  template <int dim>
  inline MandelVector<dim>
  from_principal(const SpectralDecomposition<dim> &b,
                 const std::array<double, 3>      &values)
  {
    // the columns of mandel::congruence() of the axes that matter
    constexpr auto    ij = mandel::pairs<dim>();
    const auto       &V  = b.vectors;
    MandelVector<dim> result;
    for (unsigned int a = 0; a < n_in_plane<dim>; ++a)
      {
        const double factor = a < dim ? 1. : mandel::sqrt2;
        double       sum    = 0.;
        for (unsigned int c = 0; c < dim; ++c)
          sum += factor * V[ij[a][0]][c] * V[ij[a][1]][c] * values[c];
        result[a] = sum;
      }
    if constexpr (dim == 2)
      result[3] = values[2];
    return result;
  }

  /** b - I of what flow leaves of a trial, by its principal strains. */
  template <int dim>
  inline MandelVector<dim>
  elastic_part(const SpectralDecomposition<dim> &trial,
               const std::array<double, 3>      &flow)
  {
    std::array<double, 3> elastic; // less 1
    for (unsigned int i = 0; i < 3; ++i)
      elastic[i] =
        trial.values[i] + (1. + trial.values[i]) * std::expm1(-2. * flow[i]);
    return from_principal(trial, elastic);
  }

  /**
   * Spatial tangent, in the principal axes, of a stress that follows the
   * strain with the moduli K and G:
   * normal components K - 2/3 G + (2 G - 2 tau_i) delta_ij, shear components
   * (b_i + b_j)(tau_i - tau_j)/(b_i - b_j) - (tau_i + tau_j), with
   * tau_i - tau_j = 2 G (e_i - e_j) (Pretti et al. 2023, A.32).
   *
   * @param tau principal Kirchhoff stresses, Pa
   * @param K,G bulk and shear modulus, Pa
   */
  template <int dim>
  inline MandelMatrix<dim>
  principal_tangent(const PrincipalStrain<dim>  &e,
                    const std::array<double, 3> &tau,
                    const double                 K,
                    const double                 G)
  {
    constexpr auto    normal = mandel::normal_components<dim>();
    constexpr auto    ij     = mandel::pairs<dim>();
    MandelMatrix<dim> c;
    for (unsigned int i = 0; i < 3; ++i)
      {
        for (unsigned int j = 0; j < 3; ++j)
          c[normal[i]][normal[j]] = K - 2. / 3. * G;
        c[normal[i]][normal[i]] += 2. * G - 2. * tau[i];
      }
    for (unsigned int a = dim; a < n_in_plane<dim>; ++a)
      {
        const unsigned int i = ij[a][0], j = ij[a][1];
        c[a][a] = 2. * G *
                    logarithm_quotient(e.b.values[i],
                                       e.b.values[j],
                                       e.log_b[i] - e.log_b[j]) -
                  (tau[i] + tau[j]);
      }
    return c;
  }

  /** What one point has done in a step, in its principal axes. */
  template <int dim>
  struct PrincipalStep
  {
    SpectralDecomposition<dim>
      trial; ///< of b - I, before the return to the yield surface
    std::array<double, 3> stress; ///< after flow, Pa
    /** Plastic strain of the step, by which e is less than that of the trial.
     */
    std::array<double, 3> flow;
  };

  /**
   * What a step changes of an energy that is quadratic in the logarithmic
   * strain: Delta psi = 1/2 (tau + tau_t) : (e - e_t), with all digits however
   * small the step. The strains are turned into one frame, that of
   * a_t = b_t and a = sqrt(b_t) (I + A) sqrt(b_t), A = Delta F^T Delta F - I,
   * which has the principal values of the trial b. With principal values and
   * axes alpha_i, p_i of a and beta_j, w_j of b_t, exactly
   * @f[ \ln a - \ln b_t = \sum_{ij}
   *     \frac{\ln\alpha_i-\ln\beta_j}{\alpha_i-\beta_j}\,
   *     (p_i\cdot(a-b_t)\,w_j)\; p_i\otimes w_j , @f]
   * where a - b_t = sqrt(b_t) A sqrt(b_t) is never a difference. The axes p_i
   * follow from those of the trial, v_i:
   * p_i = sqrt(b_t) Delta F^T v_i / sqrt(alpha_i).
   *
   * @param start      spectral decomposition of b_t - I
   * @param stress_old tau_t, Pa; coaxial with b_t
   * @param H          displacement gradient of the step
   * @return J per unit reference volume
   */
  template <int dim>
  double
  quadratic_energy_change(const PrincipalStep<dim>         &step,
                          const SpectralDecomposition<dim> &start,
                          const MandelVector<dim>          &stress_old,
                          const dealii::Tensor<2, dim>     &H);

  /**
   * Fill the changes of stored energy of a batch.
   * @param steps one per point
   */
  template <int dim>
  void
  fill_energy_changes(const PrincipalStep<dim> *steps,
                      MaterialBatch<dim>       &batch);
} // namespace emmy

#endif
