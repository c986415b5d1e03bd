#ifndef emmy_material_drucker_prager_h
#define emmy_material_drucker_prager_h

#include <emmy/material/hencky.h>

#include <limits>

namespace emmy
{
  /**
   * A cone around the hydrostatic axis, cut by a plane. With the mean stress
   * p = tr(tau)/3 (positive in tension) and t = sqrt(1/2 s:s) of the deviator
   * s of the Kirchhoff stress, points flow at t + friction p = cohesion, and
   * at p = tension.
   */
  struct DruckerPragerSurface
  {
    double friction = 0.; ///< eta, dimensionless, not negative
    double dilation = 0.; ///< eta-bar of the flow, between 0 and friction
    double cohesion = 0.; ///< k, Pa, not negative
    /** At most cohesion/friction, where the apex is. Pa, not negative. */
    double tension = std::numeric_limits<double>::infinity();
  };

  /** Strength of a soil, as Mohr and Coulomb have it. */
  struct MohrCoulombStrength
  {
    double cohesion       = 0.; ///< Pa
    double friction_angle = 0.; ///< radian
    double dilation_angle = 0.; ///< radian, from 0 to the friction angle
  };

  /**
   * The cone that meets the six-sided pyramid of Mohr and Coulomb
   *  - outer: at its outer edges, that is in triaxial compression:
   *    eta = 6 sin(phi)/(sqrt(3) (3 - sin(phi))), k = c eta cot(phi);
   *  - inner: at its inner edges, in triaxial extension: with 3 + sin(phi);
   *  - plane strain: where it flows in plane strain. With
   *    eta-bar = 3 sin(psi)/sqrt(9 + 3 sin^2(psi)) and
   *    N = sqrt(1 - eta-bar^2/3) + eta-bar sin(phi)/3: eta = sin(phi)/N,
   *    k = c cos(phi)/N. Without dilation these are sin(phi) and c cos(phi);
   *    with psi = phi the usual fit 3 tan(phi)/sqrt(9 + 12 tan^2(phi)).
   *
   * (Drucker and Prager 1952; de Souza Neto, Peric and Owen 2008, sec. 6.4.4;
   * plane strain with dilation: doc/materials.md.)
   * The tension is that of the apex.
   *
   * @param fit outer, inner or plane strain
   */
  DruckerPragerSurface
  drucker_prager_fit(const MohrCoulombStrength &strength,
                     const std::string         &fit);

  /**
   * Hencky elasticity with the plasticity of a soil without hardening: flow
   * along s/(2 t) + dilation/3 I on the cone, and along I on the plane and at
   * the apex. With the trial values p_*, t_* the return is
   * @f[ \gamma = \frac{t_*+\eta p_*-k}{G+K\eta\bar\eta},\quad
   *     t = t_*-G\gamma,\quad p = p_*-K\bar\eta\gamma , @f]
   * if that has p <= tension; to the plane, p = tension, if t_* is in the cone
   * there; else to the edge of both, which is the apex where the tension is
   * that of the apex (de Souza Neto, Peric and Owen 2008, sec. 8.3; Koiter
   * 1953 at the edge).
   *
   * A step dissipates tau : (plastic strain), which is not negative. With
   * dilation < friction flow is not associated: d(psi + D) is not tau : d e,
   * but with M = G + K eta eta-bar
   * @f[ p'\,\mathbf I + t'\,s/t,\quad p' = p - \frac{KG\gamma(\eta-\bar\eta)}M,
   *     \quad t' = t + \frac{KG\gamma\bar\eta(\eta-\bar\eta)}M , @f]
   * which the material states, so that the tangent of the conserving stress is
   * exact.
   *
   * Cost per point: that of Hencky, and where it flows three exponentials.
   */
  template <int dim>
  class DruckerPrager : public Material<dim>
  {
  public:
    /** @param constants completed elastic constants. */
    DruckerPrager(const ElasticConstants     &constants,
                  const DruckerPragerSurface &surface);

    /**
     * equivalent_plastic_strain: sum of sqrt(2/3) |deviator of the plastic
     * strain of a step|; plastic_volume_strain: sum of its traces.
     */
    std::vector<Field>
    history() const override;

    void
    evaluate(MaterialBatch<dim> &batch) const override;

    bool
    gives_energy_change() const override;

    bool
    gives_energy_stress() const override;

    double
    density() const override;

    double
    p_wave_modulus() const override;
    double
    shear_wave_modulus() const override;
    bool
    has_strength() const override
    {
      return true;
    }

  private:
    /** @param surface_of a function of the point */
    template <class Surface>
    void
    evaluate_points(const Surface &surface_of, MaterialBatch<dim> &batch) const;

    const ElasticConstants     constants;
    const DruckerPragerSurface surface;
  };

  /** Parameters of DruckerPrager. */
  template <int dim>
  class DruckerPragerParameters : public MaterialParameters<dim>
  {
  public:
    /** Declares the entries of a section. */
    explicit DruckerPragerParameters(const std::string &section);

    std::unique_ptr<Material<dim>>
    make() const override;
    bool
    is_nearly_incompressible() const override
    {
      return constants.are_nearly_incompressible();
    }

    /** What `emmy --check` says of it. */
    static EffectCard
    card();

  private:
    ElasticConstants constants;
    double           cohesion       = -1.; // Pa; -1 = not given
    double           friction_angle = -1.; // degrees
    double           dilation_angle = -1.; // degrees
    double           tension        = -1.; // Pa
    std::string      fit            = "plane strain";
  };
} // namespace emmy

#endif
