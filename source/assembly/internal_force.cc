#include <emmy/assembly/internal_force.h>

#include <algorithm>

namespace emmy
{
  namespace
  {
    template <int dim>
    Field
    deformation_field(const std::string &name, const std::string &description)
    {
      Field      field{name, Field::Kind::symmetric_tensor, "1", description};
      const auto unit = mandel::unit<dim>();
      field.initial.assign(unit.begin_raw(), unit.end_raw());
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

    /** Displacement gradients of a batch: H_ij = sum u_ai dS_a/dx_j. */
    template <int dim>
    void
    displacement_gradients(const Stencils<dim>                 &stencils,
                           const typename Stencils<dim>::Group &group,
                           const unsigned int                   first,
                           const double                        *displacement,
                           const unsigned int                  *nodes,
                           StressBatch<dim>                    &batch)
    {
      for (unsigned int q = 0; q < batch.n_points; ++q)
        batch.displacement_gradient[q] = 0.;
      for (unsigned int a = 0; a < group.n_nodes; ++a)
        {
          const double *u = displacement + dim * nodes[a];
          for (unsigned int j = 0; j < dim; ++j)
            {
              const double *slope = stencils.gradient(group, a, j) + first;
              for (unsigned int q = 0; q < batch.n_points; ++q)
                for (unsigned int i = 0; i < dim; ++i)
                  batch.displacement_gradient[q][i][j] += u[i] * slope[q];
            }
        }
    }

    /** Add V0 P grad S of a batch to the forces of the group's nodes. */
    template <int dim>
    void
    add_forces(const Stencils<dim>                 &stencils,
               const typename Stencils<dim>::Group &group,
               const unsigned int                   first,
               const double                        *volume,
               const unsigned int                  *nodes,
               const StressBatch<dim>              &batch,
               std::vector<double>                 &force)
    {
      for (unsigned int a = 0; a < group.n_nodes; ++a)
        {
          dealii::Tensor<1, dim> sum;
          for (unsigned int j = 0; j < dim; ++j)
            {
              const double *slope = stencils.gradient(group, a, j) + first;
              for (unsigned int q = 0; q < batch.n_points; ++q)
                for (unsigned int i = 0; i < dim; ++i)
                  sum[i] +=
                    volume[q] * batch.nominal_stress[q][i][j] * slope[q];
            }
          for (unsigned int i = 0; i < dim; ++i)
            force[dim * nodes[a] + i] += sum[i];
        }
    }

    /** Add V0 grad S_a . dP/dH . grad S_b of a batch to the group's matrix. */
    template <int dim>
    void
    add_stiffness(const Stencils<dim>                 &stencils,
                  const typename Stencils<dim>::Group &group,
                  const unsigned int                   first,
                  const double                        *volume,
                  const StressBatch<dim>              &batch,
                  dealii::FullMatrix<double>          &stiffness)
    {
      const unsigned int  n = group.n_nodes, n_columns = dim * n;
      std::vector<double> half(dim * dim * n_columns);
      for (unsigned int q = 0; q < batch.n_points; ++q)
        {
          // half_(iJ)(bm) = V0 sum_L (dP_iJ/dH_mL) dS_b/dx_L
          for (unsigned int b = 0; b < n; ++b)
            {
              dealii::Tensor<1, dim> slope;
              for (unsigned int L = 0; L < dim; ++L)
                slope[L] =
                  volume[q] * stencils.gradient(group, b, L)[first + q];
              for (unsigned int iJ = 0; iJ < dim * dim; ++iJ)
                for (unsigned int m = 0; m < dim; ++m)
                  {
                    double sum = 0.;
                    for (unsigned int L = 0; L < dim; ++L)
                      sum += batch.tangent[q][iJ][m * dim + L] * slope[L];
                    half[iJ * n_columns + b * dim + m] = sum;
                  }
            }
          for (unsigned int a = 0; a < n; ++a)
            for (unsigned int J = 0; J < dim; ++J)
              {
                const double slope = stencils.gradient(group, a, J)[first + q];
                for (unsigned int i = 0; i < dim; ++i)
                  {
                    double       *row    = &stiffness(dim * a + i, 0);
                    const double *factor = &half[(i * dim + J) * n_columns];
                    for (unsigned int c = 0; c < n_columns; ++c)
                      row[c] += slope * factor[c];
                  }
              }
        }
    }
    template <class Particle>
    std::string
    inverted_particle(const Particle &particle)
    {
      return "particle " + std::to_string(particle.get_id()) + " at (" +
             dealii::Patterns::Tools::to_string(particle.get_location()) +
             ") m is turned inside out within the step (det of its deformation "
             "gradient is not positive)";
    }
  } // namespace

  template <int dim>
  InternalForce<dim>::InternalForce(
    std::vector<const Material<dim> *> material_of_body,
    FieldLayout                       &layout,
    const StressRule<dim>             &rule,
    std::vector<std::string>           names)
    : material_of_body(std::move(material_of_body))
    , names(std::move(names))
    , rule(rule)
    , reference_volume(layout["reference_volume"])
    , left_cauchy_green(layout.add(
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
  {}

  template <int dim>
  EffectCard
  InternalForce<dim>::card()
  {
    FieldLayout         layout = basic_fields(dim);
    const std::size_t   n      = layout.fields().size();
    const InternalForce elastic({}, layout);
    EffectCard          card;
    card.name           = internal_force_effect;
    card.enters         = "Newton: stress of the particles";
    card.fields         = {layout.fields().begin() + n, layout.fields().end()};
    card.ledger_columns = {"strain_energy"};
    card.is_present     = true;
    return card;
  }

  template <int dim>
  EffectCard
  InternalForce<dim>::with_history(EffectCard material)
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
  std::unique_ptr<const typename InternalForce<dim>::InelasticFields>
  InternalForce<dim>::add_inelastic_fields(
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
    result->elastic_left_cauchy_green =
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
  std::string
  InternalForce<dim>::add(const StepData<dim> &step,
                          const Iterate<dim>  &iterate,
                          Vector              &force,
                          Matrix              *jacobian) const
  {
    // too large for the stack of a thread
    const auto work          = std::make_unique<Assembly>();
    work->batch.with_tangent = jacobian != nullptr;
    work->nodal_force.resize(dim * step.start.active->n_local_nodes());

    // groups of one material after another are timed together: that takes no
    // time of its own
    const auto   &groups = step.stencils.groups;
    Phases *const phases = names.empty() ? nullptr : step.phases;
    std::string   problem;
    for (auto group = groups.begin(); group != groups.end() && problem.empty();)
      {
        const unsigned int body     = group->body;
        std::size_t        n_points = 0;
        {
          const auto timed =
            effect_scope(phases, phases ? std::string_view(names[body]) : "");
          for (; group != groups.end() && problem.empty() &&
                 material_of_body[group->body] == material_of_body[body];
               ++group)
            {
              problem = add_group(step, iterate, *group, *work, jacobian);
              n_points += group->n_points;
            }
        }
        if (phases)
          {
            phases->add_effect_count(internal_force_effect, n_points);
            phases->add_effect_count(names[body], n_points);
          }
      }
    step.start.active->add(work->nodal_force,
                           force); // collective: also after a problem
    return problem;
  }

  template <int dim>
  std::string
  InternalForce<dim>::add_group(const StepData<dim> &step,
                                const Iterate<dim>  &iterate,
                                const Group         &group,
                                Assembly            &work,
                                Matrix              *jacobian) const
  {
    const ActiveGrid<dim> &active = *step.start.active;
    const unsigned int    *nodes  = active.nodes(group);
    if (jacobian)
      work.stiffness.reinit(dim * group.n_nodes, dim * group.n_nodes);

    for (unsigned int first = 0; first < group.n_points;
         first += max_batch_points)
      {
        const std::size_t  point = group.first_point + first;
        const unsigned int inverted =
          evaluate(step, group, first, iterate.local_displacement, work.batch);
        if (inverted < work.batch.n_points)
          return inverted_particle(*step.stencils.particles[point + inverted]);

        write_states(work.batch, point, iterate.trial);
        if (inelastic)
          write_inelastic_states(
            step, work.batch, group.body, point, iterate.trial);
        const double *volumes = step.points.component(reference_volume) + point;
        add_forces(step.stencils,
                   group,
                   first,
                   volumes,
                   nodes,
                   work.batch,
                   work.nodal_force);
        if (jacobian)
          add_stiffness(
            step.stencils, group, first, volumes, work.batch, work.stiffness);
      }

    if (jacobian)
      {
        work.dofs.clear();
        for (unsigned int a = 0; a < group.n_nodes; ++a)
          for (unsigned int c = 0; c < dim; ++c)
            work.dofs.push_back(active.first_dof(nodes[a]) + c);
        active.constraints().affine().distribute_local_to_global(work.stiffness,
                                                                 work.dofs,
                                                                 *jacobian);
      }
    return {};
  }

  template <int dim>
  unsigned int
  InternalForce<dim>::evaluate(const StepData<dim>       &step,
                               const Group               &group,
                               const unsigned int         first,
                               const std::vector<double> &local_displacement,
                               StressBatch<dim>          &batch) const
  {
    const std::size_t point = group.first_point + first;
    batch.n_points = std::min(max_batch_points, group.n_points - first);
    displacement_gradients(step.stencils,
                           group,
                           first,
                           local_displacement.data(),
                           step.start.active->nodes(group),
                           batch);
    read_states(step, point, batch);
    if (inelastic)
      read_inelastic_states(step, group.body, point, batch);
    return rule.evaluate(*material_of_body[group.body], batch);
  }

  template <int dim>
  void
  InternalForce<dim>::read_states(const StepData<dim> &step,
                                  const std::size_t    first,
                                  StressBatch<dim>    &batch) const
  {
    constexpr int n = n_mandel<dim>;
    for (unsigned int q = 0; q < batch.n_points; ++q)
      {
        batch.left_cauchy_green_old[q] =
          step.points.template get<n>(left_cauchy_green, first + q);
        batch.kirchhoff_stress_old[q] =
          step.points.template get<n>(kirchhoff_stress, first + q);
        batch.stored_energy_old[q] =
          step.points.component(strain_energy_density)[first + q];
      }
  }

  template <int dim>
  void
  InternalForce<dim>::read_inelastic_states(const StepData<dim> &step,
                                            const unsigned int   body,
                                            const std::size_t    first,
                                            StressBatch<dim>    &batch) const
  {
    const std::vector<unsigned int> &history = inelastic->history[body];

    batch.is_inelastic = !history.empty();
    batch.material.history.resize(history.size());
    if (!batch.is_inelastic)
      return;
    const double *hardening =
      step.points.component(inelastic->hardening_energy_density) + first;
    for (unsigned int q = 0; q < batch.n_points; ++q)
      {
        batch.elastic_left_cauchy_green_old[q] =
          step.points.template get<n_mandel<dim>>(
            inelastic->elastic_left_cauchy_green, first + q);
        batch.hardening_energy_old[q] = hardening[q];
      }
    for (unsigned int h = 0; h < history.size(); ++h)
      std::copy_n(step.points.component(history[h]) + first,
                  batch.n_points,
                  batch.material.history[h].begin());
  }

  template <int dim>
  void
  InternalForce<dim>::write_states(const StressBatch<dim> &batch,
                                   const std::size_t       first,
                                   PointArrays<dim>       &trial) const
  {
    const auto &b = batch.is_inelastic ? batch.left_cauchy_green
                                       : batch.material.left_cauchy_green;
    for (unsigned int q = 0; q < batch.n_points; ++q)
      {
        trial.set(left_cauchy_green, first + q, b[q]);
        trial.set(kirchhoff_stress,
                  first + q,
                  batch.material.kirchhoff_stress[q]);
        trial.component(strain_energy_density)[first + q] =
          batch.material.stored_energy[q];
      }
  }

  template <int dim>
  void
  InternalForce<dim>::write_inelastic_states(const StepData<dim>    &step,
                                             const StressBatch<dim> &batch,
                                             const unsigned int      body,
                                             const std::size_t       first,
                                             PointArrays<dim> &trial) const
  {
    for (unsigned int q = 0; q < batch.n_points; ++q)
      trial.set(inelastic->elastic_left_cauchy_green,
                first + q,
                batch.material.left_cauchy_green[q]);
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
          step.points.component(dissipation)[first + q] +
          batch.material.dissipation[q];
      }
  }

  template <int dim>
  double
  InternalForce<dim>::work(const StepData<dim> &step,
                           const Vector        &displacement) const
  {
    const auto    local  = step.start.active->to_local(displacement);
    const double *volume = step.points.component(reference_volume);
    const auto    batch  = std::make_unique<StressBatch<dim>>();
    batch->with_tangent  = false;
    double result        = 0.;
    for (const Group &group : step.stencils.groups)
      for (unsigned int first = 0; first < group.n_points;
           first += max_batch_points)
        {
          evaluate(step, group, first, local, *batch);
          for (unsigned int q = 0; q < batch->n_points; ++q)
            result += volume[group.first_point + first + q] *
                      scalar_product(batch->nominal_stress[q],
                                     batch->displacement_gradient[q]);
        }
    return result;
  }

  template <int dim>
  std::vector<EnergyEntry>
  InternalForce<dim>::energies(const StepData<dim>    &step,
                               const Vector           &displacement,
                               const PointArrays<dim> &accepted) const
  {
    const double *volume = step.points.component(reference_volume);
    // of this rank, J, from densities
    const auto change_of = [&](const unsigned int density) {
      const double *old_density = step.points.component(density);
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
    if (!rule.is_conserving)
      {
        const auto timed = effect_scope(step.phases, stress_rule_effect);
        double     known = 0.;
        for (const EnergyEntry &entry : entries)
          known += entry.change;
        entries.back().change = work(step, displacement) - known;
      }
    return entries;
  }

  template <int dim>
  std::vector<EnergyEntry>
  InternalForce<dim>::energy_entries() const
  {
    using Kind = EnergyEntry::Kind;
    std::vector<EnergyEntry> entries{{"strain_energy", Kind::stored, 0.}};
    if (inelastic)
      {
        entries.push_back({"hardening_energy", Kind::stored, 0.});
        entries.push_back({"plastic_dissipation", Kind::dissipated, 0.});
      }
    if (!rule.is_conserving)
      entries.push_back({"stress_rule_loss", Kind::dissipated, 0.});
    return entries;
  }

  template class InternalForce<2>;
  template class InternalForce<3>;
} // namespace emmy
