#include <emmy/material/graded_material.h>

namespace emmy
{
  template <int dim>
  GradedMaterial<dim>::GradedMaterial(std::unique_ptr<Material<dim>> base,
                                      Formula                        stiffness,
                                      Formula                        strength)
    : base(std::move(base))
    , stiffness(std::move(stiffness))
    , strength(std::move(strength))
  {}

  template <int dim>
  std::vector<Field>
  GradedMaterial<dim>::history() const
  {
    return base->history();
  }

  template <int dim>
  std::vector<Field>
  GradedMaterial<dim>::parameters() const
  {
    std::vector<Field> fields;
    if (stiffness)
      fields.push_back({"stiffness_factor",
                        Field::Kind::scalar,
                        "1",
                        "what the moduli of the material are multiplied by",
                        {1.}});
    if (strength)
      fields.push_back({"strength_factor",
                        Field::Kind::scalar,
                        "1",
                        "what the strength of the material is multiplied by",
                        {1.}});
    return fields;
  }

  template <int dim>
  std::vector<double>
  GradedMaterial<dim>::parameters_at(const dealii::Point<dim> &place) const
  {
    std::vector<double> values;
    for (const Formula *formula : {&stiffness, &strength})
      if (*formula)
        values.push_back((*formula)->value(place));
    return values;
  }

  template <int dim>
  void
  GradedMaterial<dim>::evaluate(MaterialBatch<dim> &batch) const
  {
    using Batch = MaterialBatch<dim>;
    if (batch.parameters.empty())
      return base->evaluate(batch);

    // the stress at t is that of the material inside as well
    const double *const s = stiffness ? batch.parameters[0].data() : nullptr;
    const double *const r = strength ? batch.parameters.back().data() : nullptr;
    typename Batch::template PerPoint<double>            ratio;
    typename Batch::template PerPoint<MandelVector<dim>> stress_old;
    const auto *const given_stress = batch.step.kirchhoff_stress_old;
    for (unsigned int p = 0; p < batch.n_points; ++p)
      ratio[p] = (r ? r[p] : 1.) / (s ? s[p] : 1.);
    if (s && batch.with_energy_change)
      {
        for (unsigned int p = 0; p < batch.n_points; ++p)
          stress_old[p] = given_stress[p] / s[p];
        batch.step.kirchhoff_stress_old = stress_old.data();
      }
    batch.strength_ratio = ratio.data();
    base->evaluate(batch);
    batch.strength_ratio            = nullptr;
    batch.step.kirchhoff_stress_old = given_stress;
    if (s)
      scale(s, batch);
  }

  template <int dim>
  void
  GradedMaterial<dim>::scale(const double       *factor,
                             MaterialBatch<dim> &batch) const
  {
    const bool flows         = !base->history().empty();
    const bool energy_stress = batch.with_tangent && gives_energy_stress();
    for (unsigned int p = 0; p < batch.n_points; ++p)
      {
        const double s = factor[p];
        batch.kirchhoff_stress[p] *= s;
        batch.stored_energy[p] *= s;
        if (batch.with_tangent)
          batch.spatial_tangent[p] *= s;
        if (energy_stress)
          batch.energy_stress[p] *= s;
        if (batch.with_energy_change)
          batch.stored_energy_change[p] *= s;
        if (!flows)
          continue;
        batch.hardening_energy[p] *= s;
        batch.dissipation[p] *= s;
        if (batch.with_energy_change)
          batch.hardening_energy_change[p] *= s;
      }
  }

  template <int dim>
  bool
  GradedMaterial<dim>::has_strength() const
  {
    return base->has_strength();
  }

  template <int dim>
  bool
  GradedMaterial<dim>::gives_energy_change() const
  {
    return base->gives_energy_change();
  }

  template <int dim>
  bool
  GradedMaterial<dim>::gives_energy_stress() const
  {
    return base->gives_energy_stress();
  }

  template <int dim>
  double
  GradedMaterial<dim>::density() const
  {
    return base->density();
  }

  template <int dim>
  double
  GradedMaterial<dim>::p_wave_modulus() const
  {
    return base->p_wave_modulus();
  }

  template <int dim>
  double
  GradedMaterial<dim>::shear_wave_modulus() const
  {
    return base->shear_wave_modulus();
  }

  template class GradedMaterial<2>;
  template class GradedMaterial<3>;
} // namespace emmy
