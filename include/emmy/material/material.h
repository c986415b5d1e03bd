#ifndef emmy_material_material_h
#define emmy_material_material_h

#include <deal.II/base/point.h>

#include <emmy/base/field.h>
#include <emmy/base/library.h>
#include <emmy/base/section.h>
#include <emmy/math/mandel.h>

#include <array>
#include <memory>
#include <vector>

namespace emmy
{
  /** How many points a batch holds: its data stay in the first-level cache. */
  constexpr unsigned int max_batch_points = 32;

  /** What a material reads and writes: a batch of points of that material. */
  template <int dim>
  struct MaterialBatch
  {
    template <typename T>
    using PerPoint = std::array<T, max_batch_points>; ///< one value a point

    unsigned int n_points     = 0;    ///< at most max_batch_points
    bool         with_tangent = true; ///< whether Newton asks for the tangent

    // in and out
    /**
     * Elastic left Cauchy-Green tensor b less the unit tensor, so that small
     * strains have all their digits. In: of the trial, Delta F b^e_t
     * Delta F^T - I. Out: after the flow of this step. A material without
     * history leaves it.
     */
    PerPoint<MandelVector<dim>> left_cauchy_green_less_unit;
    /** One array per field of Material::history(). In: at t. Out: at t+dt. */
    std::vector<PerPoint<double>> history;

    // in
    /** One array per field of Material::parameters(). */
    std::vector<PerPoint<double>> parameters;
    /**
     * By what the strength of each point is multiplied; null: by 1. For
     * materials with a strength, see Material::has_strength().
     */
    const double *strength_ratio = nullptr;
    /** The step that led to the trial. Borrowed, one entry per point. */
    struct Step
    {
      /** Displacement gradient of the step, with respect to positions at t. */
      const dealii::Tensor<2, dim> *displacement_gradient = nullptr;
      /** Elastic left Cauchy-Green tensor less the unit tensor, at t. */
      const MandelVector<dim> *left_cauchy_green_less_unit_old = nullptr;
      /** Kirchhoff stress at t, Pa. */
      const MandelVector<dim> *kirchhoff_stress_old = nullptr;
      /** H_33 in plane strain, where a treatment of locking gives it; null: 0.
       */
      const double *out_of_plane = nullptr;
    };
    /** Only if with_energy_change, for materials that give it. */
    bool with_energy_change = false;
    Step step; ///< see there

    // out
    /** Kirchhoff stress tau, Pa per unit reference volume. */
    PerPoint<MandelVector<dim>> kirchhoff_stress;
    /** Stored elastic energy, J per unit reference volume. */
    PerPoint<double> stored_energy;
    /**
     * Energy stored by hardening at t+dt, and dissipation of this step, J per
     * unit reference volume. Written and read only for materials with history.
     */
    /**
     * J/m^3 of reference volume: stored by hardening; dissipated in the step.
     */
    PerPoint<double> hardening_energy, dissipation;
    /**
     * What the step changed of the energies stored elastically and by
     * hardening, J per unit reference volume: not as differences, but with all
     * their digits, however small the step. Only if with_energy_change, of
     * materials that give it.
     */
    PerPoint<double> stored_energy_change, hardening_energy_change;
    /**
     * Of flow that is not associated: the stress-like tensor T with
     * d(stored + hardening energy + dissipation) = T : d(trial strain), Pa.
     * Only if with_tangent, of materials that give it.
     */
    PerPoint<MandelVector<dim>> energy_stress;
    /**
     * Spatial tangent c of the Lie derivative, L_v tau = c : d, Pa: that is
     * c = d tau / d(strain increment) - (tau d + d tau). Only if
     * with_tangent.
     */
    PerPoint<MandelMatrix<dim>> spatial_tangent;

    /** The tensor b (b^e) itself, of point @p p. */
    MandelVector<dim>
    left_cauchy_green(const unsigned int p) const
    {
      return mandel::plus_unit<dim>(left_cauchy_green_less_unit[p]);
    }
  };

  /**
   * An isotropic material. Owned by the scene; the internal force calls it
   * once per batch and Newton iteration. It has no state: what a point
   * remembers is in the particle fields.
   *
   * A material with history is inelastic: besides stress and energies it
   * returns the elastic deformation after flow, its history, and what it
   * dissipated. The tangent of the conserving stress needs
   * d(psi + dissipation)/d(trial strain) = tau, with psi the elastic and the
   * hardening energy. This holds for elasticity, and for flow that is
   * associative and maximises the dissipation. A material with other flow
   * gives what stands there instead, as energy_stress.
   */
  template <int dim>
  class Material
  {
  public:
    virtual ~Material() = default;

    /**
     * What a point remembers beyond its deformation, stress and energies;
     * scalars. None: the material is elastic, and all else in this interface
     * that is about history does not concern it.
     */
    virtual std::vector<Field>
    history() const
    {
      return {};
    }

    /** Fill the out fields of the batch from its in fields. */
    virtual void
    evaluate(MaterialBatch<dim> &batch) const = 0;

    /**
     * Whether evaluate() fills the changes of energy on demand. Otherwise they
     * are differences, which lose digits when a step strains little.
     */
    virtual bool
    gives_energy_change() const
    {
      return false;
    }

    /** Whether evaluate() fills energy_stress: flow is not associated. */
    virtual bool
    gives_energy_stress() const
    {
      return false;
    }

    /** Density of the reference configuration, kg/m^3. */
    virtual double
    density() const = 0;

    /** P-wave modulus K + 4/3 G of the undeformed material, Pa. */
    virtual double
    p_wave_modulus() const = 0;

    /**
     * Modulus G of shear waves in the undeformed material, Pa. 0: sides that
     * take up waves take none of these.
     */
    virtual double
    shear_wave_modulus() const
    {
      return 0.;
    }

    /**
     * What differs from point to point and never changes: fields that each
     * particle gets at the start, scalars. None: the material is the same
     * everywhere.
     */
    virtual std::vector<Field>
    parameters() const
    {
      return {};
    }

    /**
     * The values of parameters() for a particle that starts at a place. All
     * must be positive and finite, which the caller checks.
     */
    virtual std::vector<double>
    parameters_at(const dealii::Point<dim> &place) const
    {
      (void)place;
      return {};
    }

    /** Whether evaluate() heeds strength_ratio. */
    virtual bool
    has_strength() const
    {
      return false;
    }
  };

  /** The section of a material in a parameter file. */
  template <int dim>
  class MaterialParameters : public Section
  {
  public:
    /** Declares <Model> and what varies; the models declare the rest. */
    explicit MaterialParameters(const std::string &section);

    /** Check what patterns cannot say, and build. Throws ExcParameter. */
    virtual std::unique_ptr<Material<dim>>
    make() const = 0;

    /** The same, with the factors that vary, if there are any. */
    std::unique_ptr<Material<dim>>
    make_graded() const;

    /**
     * Whether the undeformed material can hardly change its volume, so that
     * it locks: its Poisson's ratio is above 0.4. Never throws.
     */
    virtual bool
    is_nearly_incompressible() const
    {
      return false;
    }

    /** The value of <Model>. */
    const std::string &
    model_name() const
    {
      return model;
    }

  private:
    std::string model; // decides, before this is made, what is made
    std::string stiffness_factor, strength_factor; // formulas; empty: 1
  };

  /** All materials that a parameter file can name. */
  template <int dim>
  Library<MaterialParameters<dim>> &
  material_library();
} // namespace emmy

#endif
