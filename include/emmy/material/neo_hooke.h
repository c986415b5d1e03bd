#ifndef emmy_material_neo_hooke_h
#define emmy_material_neo_hooke_h

#include <emmy/material/hencky.h>

namespace emmy
{
  /**
   * Compressible neo-Hooke elasticity (Simo and Pister 1984), with
   * lambda = K - 2/3 G:
   * psi = G/2 (tr b - 3 - 2 ln J) + lambda/2 (ln J)^2,
   * tau = G (b - I) + lambda ln J I.
   * For rubber, and where a body is sheared by much; without spectral
   * decomposition, so it costs a third of Hencky.
   */
  template <int dim>
  class NeoHooke : public Material<dim>
  {
  public:
    /** @param constants completed elastic constants. */
    explicit NeoHooke(const ElasticConstants &constants);

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
    /** What a step changes of psi, without a difference of energies. */
    double
    energy_change(const MaterialBatch<dim> &batch, const unsigned int p) const;

    const double reference_density, lambda, shear_modulus;
  };

  /** Parameters of NeoHooke. */
  template <int dim>
  class NeoHookeParameters : public MaterialParameters<dim>
  {
  public:
    /** Declares the entries of a section. */
    explicit NeoHookeParameters(const std::string &section);

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
