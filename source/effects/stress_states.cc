#include <emmy/effects/stress_states.h>

#include <algorithm>

namespace emmy
{
  namespace
  {
    /** A tensor that is carried less the unit tensor and written whole. */
    template <int dim>
    Field
    deformation_field(const std::string &name, const std::string &description)
    {
      Field      field{name + "_less_unit",
                  Field::Kind::symmetric_tensor,
                  "1",
                  description};
      const auto unit  = mandel::unit<dim>();
      field.written_as = name;
      field.written_plus.assign(unit.begin_raw(), unit.end_raw());
      return field;
    }

    template <int dim>
    Field
    elastic_deformation_field()
    {
      return deformation_field<dim>("elastic_left_cauchy_green",
                                    "elastic left Cauchy-Green tensor; "
                                    "that of the stress");
    }

    Field
    hardening_field()
    {
      return {"hardening_energy_density",
              Field::Kind::scalar,
              "J/m^3",
              "energy stored by hardening, per undeformed volume"};
    }

    Field
    dissipation_field()
    {
      return {"plastic_dissipation_density",
              Field::Kind::scalar,
              "J/m^3",
              "energy dissipated by plastic flow so far, per undeformed "
              "volume"};
    }
  } // namespace

  template <int dim>
  StressStates<dim>::StressStates(
    std::vector<const Material<dim> *> material_of_body,
    std::vector<std::string>           names,
    FieldLayout                       &layout)
    : material_of_body(std::move(material_of_body))
    , names(std::move(names))
    , reference_volume(layout["reference_volume"])
    , left_cauchy_green_less_unit(layout.add(
        deformation_field<dim>("left_cauchy_green",
                               "left Cauchy-Green tensor b = F F^T")))
    , kirchhoff_stress(layout.add({"kirchhoff_stress",
                                   Field::Kind::symmetric_tensor,
                                   "Pa",
                                   "Kirchhoff stress, force per undeformed "
                                   "area pushed forward: J times the Cauchy "
                                   "stress"}))
    , strain_energy_density(
        layout.add({"strain_energy_density",
                    Field::Kind::scalar,
                    "J/m^3",
                    "stored elastic energy per undeformed volume"}))
    , inelastic(
        add_inelastic_fields(this->material_of_body, this->names, layout))
    , parameters(add_parameters(this->material_of_body, this->names, layout))
  {}

  template <int dim>
  EffectCard
  StressStates<dim>::card()
  {
    FieldLayout        layout = basic_fields(dim);
    const std::size_t  n      = layout.fields().size();
    const StressStates elastic({}, {}, layout);
    EffectCard         card;
    card.name           = internal_force_effect;
    card.enters         = "Newton: stress of the particles";
    card.fields         = {layout.fields().begin() + n, layout.fields().end()};
    card.ledger_columns = {"strain_energy"};
    card.is_present     = true;
    return card;
  }

  template <int dim>
  EffectCard
  StressStates<dim>::with_history(EffectCard material)
  {
    if (material.fields.empty())
      return material;
    material.fields.insert(material.fields.begin(),
                           elastic_deformation_field<dim>());
    material.fields.push_back(hardening_field());
    material.fields.push_back(dissipation_field());
    material.ledger_columns.insert(material.ledger_columns.end(),
                                   {"hardening_energy", "plastic_dissipation"});
    return material;
  }

  template <int dim>
  std::unique_ptr<const typename StressStates<dim>::InelasticFields>
  StressStates<dim>::add_inelastic_fields(
    const std::vector<const Material<dim> *> &material_of_body,
    const std::vector<std::string>           &names,
    FieldLayout                              &layout)
  {
    std::vector<std::vector<Field>> histories;
    unsigned int                    first = material_of_body.size();
    for (unsigned int body = 0; body < material_of_body.size(); ++body)
      {
        histories.push_back(material_of_body[body]->history());
        if (!histories.back().empty())
          first = std::min(first, body);
      }
    if (first == material_of_body.size())
      return nullptr;

    // the first material with history pays for what all share
    const auto pays = [&](const unsigned int body) {
      if (!names.empty())
        layout.set_effect(names[body]);
    };
    auto result = std::make_unique<InelasticFields>();
    pays(first);
    result->elastic_left_cauchy_green_less_unit =
      layout.add(elastic_deformation_field<dim>());
    for (unsigned int body = 0; body < histories.size(); ++body)
      {
        pays(body);
        result->history.emplace_back();
        for (const Field &field : histories[body])
          {
            Assert(field.kind == Field::Kind::scalar,
                   dealii::ExcMessage("A material's history is scalar."));
            result->history.back().push_back(layout.add(field));
          }
      }
    pays(first);
    result->hardening_energy_density    = layout.add(hardening_field());
    result->plastic_dissipation_density = layout.add(dissipation_field());
    return result;
  }

  template <int dim>
  std::vector<std::vector<unsigned int>>
  StressStates<dim>::add_parameters(
    const std::vector<const Material<dim> *> &material_of_body,
    const std::vector<std::string>           &names,
    FieldLayout                              &layout)
  {
    std::vector<std::vector<unsigned int>> result;
    for (unsigned int body = 0; body < material_of_body.size(); ++body)
      {
        result.emplace_back();
        for (const Field &field : material_of_body[body]->parameters())
          {
            if (!names.empty())
              layout.set_effect(names[body]);
            result.back().push_back(layout.add(field));
          }
      }
    return result;
  }

  template <int dim>
  void
  StressStates<dim>::read(const PointArrays<dim> &points,
                          const unsigned int      body,
                          const std::size_t       first,
                          StressBatch<dim>       &batch) const
  {
    constexpr int n = n_mandel<dim>;
    for (unsigned int q = 0; q < batch.n_points; ++q)
      {
        batch.left_cauchy_green_less_unit_old[q] =
          points.template get<n>(left_cauchy_green_less_unit, first + q);
        batch.kirchhoff_stress_old[q] =
          points.template get<n>(kirchhoff_stress, first + q);
        batch.stored_energy_old[q] =
          points.component(strain_energy_density)[first + q];
      }
    if (inelastic)
      read_inelastic(points, body, first, batch);
    const auto &varying = parameters[body];
    batch.material.parameters.resize(varying.size());
    for (unsigned int i = 0; i < varying.size(); ++i)
      std::copy_n(points.component(varying[i]) + first,
                  batch.n_points,
                  batch.material.parameters[i].begin());
  }

  template <int dim>
  void
  StressStates<dim>::read_inelastic(const PointArrays<dim> &points,
                                    const unsigned int      body,
                                    const std::size_t       first,
                                    StressBatch<dim>       &batch) const
  {
    const std::vector<unsigned int> &history = inelastic->history[body];

    batch.is_inelastic = !history.empty();
    batch.material.history.resize(history.size());
    if (!batch.is_inelastic)
      return;
    const double *hardening =
      points.component(inelastic->hardening_energy_density) + first;
    for (unsigned int q = 0; q < batch.n_points; ++q)
      {
        batch.elastic_left_cauchy_green_less_unit_old[q] =
          points.template get<n_mandel<dim>>(
            inelastic->elastic_left_cauchy_green_less_unit, first + q);
        batch.hardening_energy_old[q] = hardening[q];
      }
    for (unsigned int h = 0; h < history.size(); ++h)
      std::copy_n(points.component(history[h]) + first,
                  batch.n_points,
                  batch.material.history[h].begin());
  }

  template <int dim>
  void
  StressStates<dim>::write(const StressBatch<dim> &batch,
                           const PointArrays<dim> &points,
                           const unsigned int      body,
                           const std::size_t       first,
                           PointArrays<dim>       &trial) const
  {
    const auto &b = batch.is_inelastic
                      ? batch.left_cauchy_green_less_unit
                      : batch.material.left_cauchy_green_less_unit;
    for (unsigned int q = 0; q < batch.n_points; ++q)
      {
        trial.set(left_cauchy_green_less_unit, first + q, b[q]);
        trial.set(kirchhoff_stress,
                  first + q,
                  batch.material.kirchhoff_stress[q]);
        trial.component(strain_energy_density)[first + q] =
          batch.material.stored_energy[q];
      }
    if (inelastic)
      write_inelastic(batch, points, body, first, trial);
  }

  template <int dim>
  void
  StressStates<dim>::write_inelastic(const StressBatch<dim> &batch,
                                     const PointArrays<dim> &points,
                                     const unsigned int      body,
                                     const std::size_t       first,
                                     PointArrays<dim>       &trial) const
  {
    for (unsigned int q = 0; q < batch.n_points; ++q)
      trial.set(inelastic->elastic_left_cauchy_green_less_unit,
                first + q,
                batch.material.left_cauchy_green_less_unit[q]);
    if (!batch.is_inelastic)
      return; // nothing else ever changes in an elastic body
    const std::vector<unsigned int> &history = inelastic->history[body];
    for (unsigned int h = 0; h < history.size(); ++h)
      std::copy_n(batch.material.history[h].begin(),
                  batch.n_points,
                  trial.component(history[h]) + first);
    const unsigned int dissipation = inelastic->plastic_dissipation_density;
    for (unsigned int q = 0; q < batch.n_points; ++q)
      {
        trial.component(inelastic->hardening_energy_density)[first + q] =
          batch.material.hardening_energy[q];
        trial.component(dissipation)[first + q] =
          points.component(dissipation)[first + q] +
          batch.material.dissipation[q];
      }
  }

  template <int dim>
  std::vector<EnergyEntry>
  StressStates<dim>::energies(const PointArrays<dim> &points,
                              const PointArrays<dim> &accepted) const
  {
    const double *volume = points.component(reference_volume);
    // of this rank, J, from densities
    const auto change_of = [&](const unsigned int density) {
      const double *old_density = points.component(density);
      const double *new_density = accepted.component(density);
      double        change      = 0.;
      for (std::size_t p = 0; p < accepted.n_points(); ++p)
        change += volume[p] * (new_density[p] - old_density[p]);
      return change;
    };

    std::vector<EnergyEntry> entries = energy_entries();
    entries[0].change                = change_of(strain_energy_density);
    if (inelastic)
      {
        entries[1].change = change_of(inelastic->hardening_energy_density);
        entries[2].change = change_of(inelastic->plastic_dissipation_density);
      }
    return entries;
  }

  template <int dim>
  std::vector<EnergyEntry>
  StressStates<dim>::energy_entries() const
  {
    using Kind = EnergyEntry::Kind;
    std::vector<EnergyEntry> entries{{"strain_energy", Kind::stored, 0.}};
    if (inelastic)
      {
        entries.push_back({"hardening_energy", Kind::stored, 0.});
        entries.push_back({"plastic_dissipation", Kind::dissipated, 0.});
      }
    return entries;
  }

  template <int dim>
  std::string
  inverted_particle(const Stencils<dim> &stencils, const std::size_t point)
  {
    const auto &particle = *stencils.particles[point];
    return "particle " + std::to_string(particle.get_id()) + " at (" +
           dealii::Patterns::Tools::to_string(particle.get_location()) +
           ") m is turned inside out within the step (det of its deformation "
           "gradient is not positive)";
  }

#define INSTANTIATE(dim)                                             \
  template class StressStates<dim>;                                  \
  template std::string inverted_particle<dim>(const Stencils<dim> &, \
                                              const std::size_t);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
