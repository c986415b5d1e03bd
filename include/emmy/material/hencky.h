#ifndef emmy_material_hencky_h
#define emmy_material_hencky_h

#include <emmy/material/material.h>

#include <string>

namespace emmy
{
  /**
   * Elastic constants as an engineer has them: Young's modulus and Poisson's
   * ratio, or bulk and shear modulus; one pair, not a mixture. Also the
   * density, which every material needs.
   */
  struct ElasticConstants
  {
    double density       = 0.;  ///< kg/m^3; 0 = not given
    double young_modulus = 0.;  ///< Pa
    double poisson_ratio = -2.; ///< below -1 = not given
    double bulk_modulus  = 0.;  ///< Pa
    double shear_modulus = 0.;  ///< Pa

    /** Declare the entries in a material's section. */
    void
    add_to(Section &section);

    /**
     * Check ranges and fill the moduli that were not given.
     * Throws ExcParameter with the section's path.
     */
    ElasticConstants
    completed(const std::string &section) const;

    /** Poisson's ratio is above 0.4, as far as given; not of fluids. */
    bool
    are_nearly_incompressible() const;
  };

  /**
   * Hencky elasticity: the stored energy is quadratic in the logarithmic
   * strain e = 1/2 ln b, psi = K/2 tr(e)^2 + G |dev e|^2, so that
   * tau = K tr(e) I + 2 G dev e (formulation of Pretti et al. 2023, sec. 6).
   *
   * Cost per point: one spectral decomposition and three logarithms; as much
   * again where the change of energy is wanted.
   */
  template <int dim>
  class Hencky : public Material<dim>
  {
  public:
    /** @param constants completed elastic constants. */
    explicit Hencky(const ElasticConstants &constants);

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

  private:
    const double reference_density, bulk_modulus, shear_modulus;
  };

  /** Parameters of Hencky. */
  template <int dim>
  class HenckyParameters : public MaterialParameters<dim>
  {
  public:
    /** Declares the entries of a section. */
    explicit HenckyParameters(const std::string &section);

    std::unique_ptr<Material<dim>>
    make() const override;
    bool
    is_nearly_incompressible() const override
    {
      return constants.are_nearly_incompressible();
    }

  private:
    ElasticConstants constants;
  };
} // namespace emmy

#endif
