#ifndef emmy_material_graded_material_h
#define emmy_material_graded_material_h

#include <deal.II/base/function_parser.h>

#include <emmy/material/material.h>

namespace emmy
{
  /**
   * A material whose moduli and strength are multiplied by factors of the place
   * where a particle starts, s and r. Stresses and energies of an isotropic
   * material are linear in its moduli and strengths together, so with those of
   * the material inside, of strength r/s,
   * @f[ \tau = s\,\hat\tau,\quad \psi = s\,\hat\psi,\quad
   *     c = s\,\hat c,\quad \Delta D = s\,\Delta\hat D . @f]
   * The strains are the same, and with them history and plastic flow. A point
   * keeps its factors in fields of its own. Owned by the scene.
   *
   * Wave moduli and density are those of factors of 1. Cost per point: a few
   * products beside that of the material inside.
   */
  template <int dim>
  class GradedMaterial : public Material<dim>
  {
  public:
    /** A factor over the place. */
    using Formula = std::unique_ptr<dealii::FunctionParser<dim>>;

    /** @param stiffness,strength null: 1 everywhere; not both */
    GradedMaterial(std::unique_ptr<Material<dim>> base,
                   Formula                        stiffness,
                   Formula                        strength);

    std::vector<Field>
    history() const override;
    /** stiffness_factor, strength_factor: those that vary. */
    std::vector<Field>
    parameters() const override;
    std::vector<double>
    parameters_at(const dealii::Point<dim> &place) const override;

    /** Without parameters in the batch, with factors of 1. */
    void
    evaluate(MaterialBatch<dim> &batch) const override;

    bool
    has_strength() const override;
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

  private:
    /** Multiply what the material inside gave by the stiffness factors. */
    void
    scale(const double *factor, MaterialBatch<dim> &batch) const;

    const std::unique_ptr<Material<dim>> base;
    const Formula                        stiffness, strength;
  };
} // namespace emmy

#endif
