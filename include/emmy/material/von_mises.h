#ifndef emmy_material_von_mises_h
#define emmy_material_von_mises_h

#include <emmy/material/hencky.h>

namespace emmy
{
  template <int dim>
  struct HenckyLanes;

  /**
   * Where the deviator s of the Kirchhoff stress starts to flow:
   * |s| = radius + sqrt(2/3) H xi.
   */
  struct YieldSurface
  {
    double radius            = 0.; ///< Pa
    double hardening_modulus = 0.; ///< H, uniaxial, Pa
  };

  /**
   * Hencky elasticity with von Mises plasticity and linear isotropic
   * hardening (Simo 1992; Pretti et al. 2023, eqs 62, 63). The energy is
   * psi = K/2 tr(e)^2 + G |dev e|^2 + H/2 xi^2 of the elastic logarithmic
   * strain e and the equivalent plastic strain xi. Beyond the yield surface
   * the deviator returns radially: with the trial s, n = s/|s|,
   * @f[ \Delta\lambda = \frac{|s| - R(\xi_t)}{2G + \tfrac23 H},\quad
   *     e = e_{trial} - \Delta\lambda\,n,\quad
   *     \xi = \xi_t + \sqrt{2/3}\,\Delta\lambda . @f]
   * The step dissipates radius Delta lambda; the rest of the plastic work,
   * H xi dxi, is stored.
   *
   * Cost per point: that of Hencky, and where it flows three exponentials.
   */
  template <int dim>
  class VonMises : public Material<dim>
  {
  public:
    /** @param constants completed elastic constants. */
    VonMises(const ElasticConstants &constants, const YieldSurface &surface);

    /** equivalent_plastic_strain, xi. */
    std::vector<Field>
    history() const override;

    void
    evaluate(MaterialBatch<dim> &batch) const override;

    bool
    gives_energy_change() const override;

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
    /** What a point flows in a step. */
    struct Flow
    {
      bool                  is_plastic = false;
      double                kept       = 1.; ///< of the trial's deviator
      std::array<double, 3> direction{};     ///< of the deviator, principal
      std::array<double, 3> strain{};        ///< principal plastic strains
    };

    /**
     * That of point @p p, whose trial stands in a lane, for |s| of at most
     * @p radius, Pa; its history and energies of hardening go to the batch.
     */
    Flow
    flow(const HenckyLanes<dim> &trial,
         const unsigned int      lane,
         const double            radius,
         const unsigned int      p,
         MaterialBatch<dim>     &batch) const;

    const ElasticConstants constants;
    const YieldSurface     surface;
  };

  /** Parameters of VonMises. */
  template <int dim>
  class VonMisesParameters : public MaterialParameters<dim>
  {
  public:
    /** Declares the entries of a section. */
    explicit VonMisesParameters(const std::string &section);

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
    double           yield_stress      = 0.; // Pa; 0 = not given
    double           hardening_modulus = 0.; // Pa
    std::string      yield_measure     = "uniaxial";
  };
} // namespace emmy

#endif
